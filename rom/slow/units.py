"""Units in which curves are drawn and listed; what they hold is in rad/s and m."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import PER_UNIT, FrequencyUnit

LengthUnit = Literal["m", "mm", "um"]

_PER_LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
MODAL = "kg$^{1/2}$ m"


@dataclass(frozen=True)
class Units:
    """Units of pictures and tables.

    Attributes
    ----------
    frequency : {"rad/s", "Hz"}
    displacement : {"m", "mm", "um"}
        Of DOFs; modal amplitudes stay in kg^1/2 m.
    """

    frequency: FrequencyUnit = "rad/s"
    displacement: LengthUnit = "m"

    def __post_init__(self) -> None:
        for name, allowed in (("frequency", FrequencyUnit), ("displacement", LengthUnit)):
            if getattr(self, name) not in get_args(allowed):
                raise SlipmodeError(
                    f"units.{name}: must be one of {', '.join(get_args(allowed))}, got "
                    f"{getattr(self, name)!r}"
                )

    @property
    def per_frequency(self) -> float:
        """[rad/s] in one."""
        return PER_UNIT[self.frequency]

    def of_frequency(self, omega: ArrayLike) -> Floats:
        """An angular frequency [rad/s] in these units."""
        return np.asarray(omega, dtype=float) / self.per_frequency

    def of_displacement(self, x: ArrayLike) -> Floats:
        """A displacement [m] in these units."""
        return np.asarray(x, dtype=float) / _PER_LENGTH[self.displacement]

    def named(self, name: str) -> str:
        """A column of frequencies: with its unit where that is not rad/s."""
        return name if self.frequency == "rad/s" else f"{name} [{self.frequency}]"

    def of_dof(self, name: str, dof: int) -> str:
        """A column of the amplitude of a DOF, with its unit."""
        return f"{name} at DOF {dof} [{self.displacement}]"


SI = Units()


@dataclass(frozen=True)
class Shown:
    """How pictures and tables show amplitudes: those of a DOF where one is given, and units.

    `modal` is how the unit of modal amplitudes is written.
    """

    dof: int | None = None
    units: Units = SI
    modal: str = MODAL

    def size(self, mode_shapes: Floats, amplitude: Floats) -> Floats:
        """Of modal amplitudes, as `modal_displacement` has them."""
        if self.dof is None:
            return amplitude
        return self.units.of_displacement(modal_displacement(mode_shapes, amplitude, self.dof))

    def named(self, name: str) -> str:
        """An amplitude with its unit."""
        return f"{name} [{self.modal}]" if self.dof is None else self.units.of_dof(name, self.dof)


def modal_displacement(mode_shapes: Floats, amplitude: Floats, dof: int) -> Floats:
    """Amplitude of a DOF in the shape of a mode (n,), or of each of several (n, modes) [m].

    Of modal amplitudes (...), or (..., modes); refused for a DOF that there is not.
    """
    if not 0 <= dof < len(mode_shapes):
        raise SlipmodeError(f"dof: must be 0 to {len(mode_shapes) - 1}, got {dof}")
    return np.asarray(2.0 * np.abs(mode_shapes[dof]) * amplitude)
