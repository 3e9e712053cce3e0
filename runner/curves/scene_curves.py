"""Response curves and backbones of the structure of a scene, under its forces at the end."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import RigidFriction
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.branches.forced import Varied
from slipmode.rom.slow.branches.performance import slip_onset
from slipmode.rom.table.cache import cached_model
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.scene import Scene

_COARSE = 0.05  # tolerance of tables that only show how far the curve goes
_MARGIN = 0.1  # of the table over the largest amplitude
_NEAR = 0.97  # of a table's range: a curve that comes so far may have been cut off
_GROWTH, _LARGEST_GROWTH = 3.0, 3.0**8  # of the range, from the scene's
# Of the scene's amplitudes, or of those at which contacts begin to slip: how far a performance
# curve goes, and so how far below the limits.
_DESIGN_RANGE = 8.0
# Contacts that slide much farther than they stick may not settle: it goes less far then.
_DESIGN_PARTS = (1.0, 0.5, 0.25, 0.125)
_DEFAULT_SPAN = (0.95, 1.05)  # of the natural frequency

_Forced = TypeVar("_Forced", rom.ResponseCurve, rom.PerformanceCurve)


@dataclass(frozen=True, eq=False)
class SceneForcing:
    """What acts at the end of a scene.

    Attributes
    ----------
    plan : Plan
    frequency : (modes,) ndarray
        [rad/s]
    force : list of (n,) ndarray
        [N]
    phase : (modes,) ndarray
        [rad]
    """

    plan: Plan
    frequency: Floats
    force: list[Floats]
    phase: Floats

    __repr__ = short_repr

    @classmethod
    def of(cls, scene: Scene, *, progress: bool = False) -> SceneForcing:
        """Of a scene, as its plan has it."""
        scene.check_tabulated()
        plan = make_plan(scene, progress=progress)
        modes = plan.excited.modes
        values = {
            name: np.array(
                [
                    plan.schedule.at_ends([f"{name}_{mode}"], slice(-1, None))[0, 0]
                    for mode in modes
                ]
            )
            for name in ("frequency", "force", "phase")
        }
        force = [f * v for f, v in zip(plan.excited.force_patterns, values["force"], strict=True)]
        return cls(plan, values["frequency"], force, values["phase"])


def scene_response_curve(
    scene: Scene,
    vary: Varied | None = None,
    span: Sequence[ArrayLike] | None = None,
    *,
    progress: bool = False,
) -> rom.ResponseCurve:
    """Steady states under the forces that act at the end of a scene, see `rom.response_curve`.

    The friction table reaches as far as the curve does. Default: the first forced mode's
    frequency, 5 % to both sides of its natural one.

    Raises
    ------
    SlipmodeError
    """
    forcing = SceneForcing.of(scene, progress=progress)
    excited = forcing.plan.excited
    vary = vary or _first_frequency(excited.modes)
    which = _renamed(vary, excited.modes)
    if span is None:
        if not which.startswith("frequency_"):
            raise SlipmodeError(f"span: give the first and last value of {vary}")
        natural = excited.reduced.frequency["AB".index(which[-1])]
        span = [part * natural for part in _DEFAULT_SPAN]
    tried = np.array(forcing.plan.amplitude)
    largest = _LARGEST_GROWTH * tried
    while True:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rom.ValidityWarning)  # of the curve itself there are
            _, reached = _curve(forcing, which, span, tried, _COARSE, progress)
        cut_off = reached > _NEAR * tried
        if not cut_off.any():
            break
        tried = np.where(cut_off, _GROWTH * tried, tried)
        if np.any(tried > largest):
            raise SlipmodeError("span: the amplitudes grow without bound in it")
    amplitude = (1.0 + _MARGIN) * np.maximum(reached, 1e-2 * tried)
    curve, _ = _curve(forcing, which, span, amplitude, scene.model.tolerance, progress)
    return _on(forcing.plan.structure, curve)


def scene_backbone(
    scene: Scene, mode: Mode | None = None, other: float = 0.0, *, progress: bool = False
) -> rom.Backbone:
    """Frequency and damping of a mode up to the amplitudes of a scene, see `rom.backbone`.

    Raises
    ------
    SlipmodeError
    """
    plan = make_plan(scene, progress=progress)
    at = _place(plan.excited.modes, mode)
    model, _ = plan.model(detuning=True, progress=progress)  # frequency follows amplitude
    return rom.backbone(model, at, other)


def scene_performance(
    scene: Scene, mode: Mode | None = None, *, progress: bool = False
) -> rom.PerformanceCurve:
    """Resonance peak of a mode under the scene's force, against limits and preloads.

    Of that mode alone; see `rom.performance_curve`. The friction table goes well beyond the
    scene's amplitudes, and, unless these are given as `model.amplitude`, beyond where the contacts
    begin to slip: the curve has them stuck and fully slipping.

    Raises
    ------
    SlipmodeError
    """
    forcing = SceneForcing.of(scene, progress=progress)
    plan = forcing.plan
    at = _place(plan.excited.modes, mode)
    if not forcing.force[at].any():
        name = plan.excited.modes[at]
        raise SlipmodeError(
            f"forcing.{name}: must not be 0: the resonance peak of mode {name} is under this force"
        )
    law, aerodynamics = plan.excited.law, plan.excited.reduced.aerodynamics
    reduced = rom.reduce(
        plan.structure,
        (plan.excited.reduced.modes[at],),
        law=None if isinstance(law, RigidFriction) else law,
        aerodynamics=None if aerodynamics is None else aerodynamics[at : at + 1].tolist(),
        warned=False,
        progress=progress,
    )
    furthest = plan.amplitude[at]
    if scene.model.amplitude is None:
        furthest = max(furthest, slip_onset(reduced, law, 0)[1])
    for part in _DESIGN_PARTS:
        largest = part * _DESIGN_RANGE * furthest
        try:
            model, _ = cached_model(
                *(reduced, law, (largest,), scene.model.tolerance),
                detuning=True,
                progress=progress,
            )
        except SlipmodeError:
            if part == _DESIGN_PARTS[-1]:
                raise
        else:
            break
    return _on(plan.structure, rom.performance_curve(model, forcing.force[at]))


def _on(structure: rom.Structure, curve: _Forced) -> _Forced:
    """The curve, displacements of DOFs with the quasi-static response to the forces."""
    return replace(curve, motion=replace(curve.motion, structure=structure))


def _place(modes: Sequence[Mode], mode: Mode | None) -> int:
    """Of a mode in the model of a scene; the first by default."""
    if mode is not None and mode not in modes:
        raise SlipmodeError(f"mode: must be one that the scene forces, {' or '.join(modes)}")
    return 0 if mode is None else modes.index(mode)


def _curve(
    forcing: SceneForcing,
    vary: Varied,
    span: Sequence[ArrayLike],
    amplitude: Floats,
    tolerance: float,
    progress: bool,
) -> tuple[rom.ResponseCurve, Floats]:
    """The curve on a table of that range, and how far in the table it goes (modes,)."""
    excited = forcing.plan.excited
    model, _ = cached_model(
        *(excited.reduced, excited.law, amplitude.tolist(), tolerance),
        combinations=forcing.plan.combinations,
        detuning=vary.startswith("frequency"),
        progress=progress,
    )
    curve = rom.response_curve(
        model, forcing.frequency, forcing.force, vary, span, tuple(forcing.phase)
    )
    size = np.abs(curve.amplitude)
    if vary == "limit":
        size = size / curve.parameter[:, np.newaxis]
    return curve, np.asarray(size.max(axis=0))


def _first_frequency(modes: Sequence[Mode]) -> Varied:
    return "frequency_A" if modes[0] == "A" else "frequency_B"


def _renamed(vary: Varied, modes: Sequence[Mode]) -> Varied:
    """What is varied, by the place of the mode in the model: a scene may force B alone."""
    if vary[-2:] not in ("_A", "_B"):
        return vary
    if vary[-1] not in modes:
        raise SlipmodeError(f"vary: the scene does not force mode {vary[-1]}")
    found: Varied = f"{vary[:-1]}{'AB'[modes.index(vary[-1])]}"  # type: ignore[assignment]
    return found
