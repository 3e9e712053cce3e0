"""Inputs of a component: their names, what is allowed, how they move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from fmu.stepping import Floats
from rom import Coulomb, Model, SlipmodeError, _kernel

MODE_NAMES = ("A", "B")
ForcePatterns = Sequence[Mapping[int, float] | ArrayLike]


class Inputs:
    """Names of a model's inputs, and where the core's records hold them.

    Parameters
    ----------
    model : Model
    force : sequence of {DOF: amplitude} or (n,) array_like, one per mode, optional
        Where a force input of 1 N acts. Default: the input is the modal force.
    mode_names : sequence of str
        See `present_modes`.
    """

    def __init__(
        self, model: Model, force: ForcePatterns | None, mode_names: Sequence[str]
    ) -> None:
        present = present_modes(model, mode_names)
        self.mode_names = (*present, *(name for name in MODE_NAMES if name not in present))
        self.names = tuple(
            f"{quantity}_{mode}" for mode in present for quantity in _kernel.INPUT_FIELDS
        )
        if isinstance(model.law, Coulomb):
            self.names += _kernel.SCALE_FIELDS
        self._force_factor = force_factors(model, force)

    def column(self, inputs: np.ndarray, name: str) -> Floats:
        """Where inputs (n,) hold an input, (n,)."""
        if name in _kernel.SCALE_FIELDS:
            scales: Floats = inputs[name]
            return scales
        quantity, mode = name.rsplit("_", 1)
        of_mode: Floats = inputs[quantity][:, self.mode_names.index(mode)]
        return of_mode

    def why_not(self, name: str) -> str:
        """Why a name is not an input."""
        if name not in _kernel.SCALE_FIELDS:
            return f"not an input; inputs are {', '.join(self.names)}"
        return (
            "only the Coulomb law scales with its limit, for the tanh law has a velocity alpha "
            "besides; tabulate a model with the other limit"
        )

    def modal(self, inputs: np.ndarray) -> np.ndarray:
        """Inputs with forces in newtons turned into modal forces."""
        scaled = inputs.copy()
        for name in ("force", "force_rate"):
            scaled[name] *= self._force_factor
        return scaled

    def refusal(self, inputs: np.ndarray) -> str:
        """Why inputs (1,) are refused, naming one; "" if they are not."""
        for name in self.names:
            value = self.column(inputs, name)[0]
            if not np.isfinite(value):
                return f"{name}: must be finite, got {value:g}"
            if name.rpartition("_")[0] == "frequency" and value <= 0:
                return f"{name}: must be > 0 rad/s, got {value:g}"
            if name == "limit_scale" and value <= 0:
                return f"{name}: must be > 0, got {value:g}"
        return ""


def moved_on(inputs: np.ndarray, duration: float) -> np.ndarray:
    """Inputs after they moved at their rates for `duration`."""
    later = inputs.copy()
    for name in (*_kernel.INPUT_QUANTITIES, "limit_scale"):
        later[name] += later[f"{name}_rate"] * duration
    return later


def present_modes(model: Model, mode_names: Sequence[str]) -> tuple[str, ...]:
    """What the model's modes are called; names past their number are left out."""
    present = tuple(mode_names)[: model.modes]
    if len(set(present)) < model.modes or not set(present) <= set(MODE_NAMES):
        raise SlipmodeError(f"mode_names: must be distinct, of A and B, got {present}")
    return present


def force_factors(model: Model, force: ForcePatterns | None) -> Floats:
    """Modal force per unit of the force input, (MODES,)."""
    factors = np.ones(_kernel.MODES)
    if force is not None:
        if len(force) != model.modes:
            raise SlipmodeError(f"force: needs one entry per mode ({model.modes})")
        for mode, pattern in enumerate(force):
            factors[mode] = model.reduced.modal_force(mode, pattern)
    return factors
