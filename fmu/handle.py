"""The core's component that steps a model."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import index
from typing import Any, TypeVar

import numpy as np

from slipmode.fmu.inputs import MODE_NAMES, AnyModel
from slipmode.rom import SlipmodeError, kernel
from slipmode.rom.arrays import as_number, in_one_line
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.error_budget import SLOW_FLOW
from slipmode.rom.errors import naming
from slipmode.rom.kernel.handle import Handle
from slipmode.rom.reduction.force_response import ForcePatterns
from slipmode.rom.slow.nonresonant.response_surface import forces_out, response_surface
from slipmode.rom.slow.slow_flow import slow_flow
from slipmode.rom.slow.tone.tone_states import ForcedTone
from slipmode.rom.table.local.tone_model import ToneModel

Function = TypeVar("Function", bound=Callable[..., Any])

STEPS_PER_PERIOD = 40
MEMORY_PERIODS = 8.0


@dataclass(frozen=True)
class ComponentOptions:
    """The keyword arguments of `Component`, which describes them."""

    contact: bool = False
    elastic: Sequence[int] = ()
    mode_names: Sequence[str] = MODE_NAMES
    tolerance: float = SLOW_FLOW
    sample: int = 0
    warned: bool = True

    def __post_init__(self) -> None:
        if not 1e-13 <= as_number("tolerance", self.tolerance) <= 1e-2:
            raise SlipmodeError(f"tolerance: must be 1e-13 to 1e-2, got {self.tolerance}")
        try:
            dofs = [index(dof) for dof in self.elastic]
        except TypeError:
            shown = in_one_line(self.elastic)
            raise SlipmodeError(f"elastic: must be a list of DOFs, got {shown}") from None
        if dofs and not self.contact:
            raise SlipmodeError("elastic: needs contact=True, because the contacts move the DOFs")


def takes(options: type[ComponentOptions]) -> Callable[[Function], Function]:
    """Return a decorator that shows **options in a signature as the fields of a dataclass."""

    def decorate(function: Function) -> Function:
        signature = inspect.signature(function)
        fields = inspect.signature(options).parameters.values()
        shown = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        shown += [field.replace(kind=field.KEYWORD_ONLY) for field in fields]
        vars(function)["__signature__"] = signature.replace(parameters=shown)
        return function

    return decorate


def create_component(
    model: AnyModel, force_patterns: ForcePatterns | None, options: ComponentOptions
) -> Handle:
    """Return the core's component, or its flow of a tone, which is freed with the handle."""
    if isinstance(model, ToneModel):
        forced = forced_tone(model, force_patterns)
        tone = forced.core(model.carrier, options.elastic, options.contact)
        return Handle("tone", tone, tolerance=options.tolerance)
    wanted: dict[str, Any] = {}
    if options.contact:
        surface = response_surface(model, options.elastic)
        wanted = {
            "wanted": 1,
            "elastic": len(options.elastic),
            "modes_out": surface.modes_out,
            "forces_out": forces_out(model, force_patterns, options.elastic),
            "contacts_out": kernel.contiguous(model.reduced.contact_shapes[list(options.elastic)]),
            "orders_count": len(surface.orders),
            "orders": surface.orders,
            "reaction": surface.reaction,
            "response": surface.elastic,
        }
    return Handle(
        "component",
        slow_flow(model, force_patterns),
        contact_problem(model.reduced, model.law),
        kernel.Motion(steps_per_period=STEPS_PER_PERIOD, memory_periods=MEMORY_PERIODS, **wanted),
        tolerance=options.tolerance,
    )


def forced_tone(model: ToneModel, force_patterns: ForcePatterns | None) -> ForcedTone:
    """Return modes that share a tone under their force; refuse a force that is missing."""
    if force_patterns is None:
        raise SlipmodeError(
            "force_patterns: is missing, because a force moves all modes that share a tone; give "
            "one for each tone, as [{DOF: amplitude}]"
        )
    with naming("force_patterns"):
        return ForcedTone.of(model, force_patterns, 0.0, model.carrier[np.newaxis])
