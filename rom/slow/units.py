"""Units in which curves are drawn and listed; what they hold is in rad/s and m."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import PER_UNIT, FrequencyUnit

if TYPE_CHECKING:
    from slipmode.rom.slow.steady_motion import SteadyMotion

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

    def size(self, motion: SteadyMotion) -> Floats:
        """Return |a_j| of steady states, or the amplitude of the DOF at each carrier."""
        if self.dof is None:
            return np.abs(motion.amplitude)
        return self.units.of_displacement(motion.displacement(self.dof))

    def named(self, name: str) -> str:
        """An amplitude with its unit."""
        return f"{name} [{self.modal}]" if self.dof is None else self.units.of_dof(name, self.dof)
