"""Units of pictures and tables of curves, which hold values in rad/s and m."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import PER_UNIT, FrequencyUnit
from slipmode.rom.physical_units import parse_unit

if TYPE_CHECKING:
    from slipmode.rom.slow.steady_motion import SteadyMotion

LengthUnit = Literal["m", "mm", "um"]

_PER_LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
MODAL = "kg$^{1/2}$ m"


@dataclass(frozen=True)
class Units:
    """Choose the units of plots and tables.

    Attributes
    ----------
    frequency : {"rad/s", "Hz"}
        Unit of frequencies.
    displacement : {"m", "mm", "um"}
        Unit of displacements of DOFs. Modal amplitudes stay in kg^1/2 m.
    """

    frequency: FrequencyUnit = "rad/s"
    displacement: LengthUnit = "m"

    def __post_init__(self) -> None:
        for name, allowed in (("frequency", FrequencyUnit), ("displacement", LengthUnit)):
            unit = parse_unit(str(getattr(self, name)))
            if unit and unit.name in get_args(allowed):  # other spellings
                object.__setattr__(self, name, unit.name)
            else:
                raise SlipmodeError(
                    f"units.{name}: must be one of {', '.join(get_args(allowed))}, got "
                    f"{getattr(self, name)!r}"
                )

    @property
    def per_frequency(self) -> float:
        """The unit of frequencies in rad/s."""
        return PER_UNIT[self.frequency]

    def of_frequency(self, omega: ArrayLike) -> Floats:
        """Return an angular frequency [rad/s] in these units."""
        return np.asarray(omega, dtype=float) / self.per_frequency

    def of_displacement(self, x: ArrayLike) -> Floats:
        """Return a displacement [m] in these units."""
        return np.asarray(x, dtype=float) / _PER_LENGTH[self.displacement]

    def named(self, name: str) -> str:
        """Return the name of a column of frequencies, with a unit other than rad/s."""
        return name if self.frequency == "rad/s" else f"{name} [{self.frequency}]"

    def of_dof(self, name: str, dof: int) -> str:
        """Return the name of a column of amplitudes of a DOF, with the unit."""
        return f"{name} at DOF {dof} [{self.displacement}]"


SI = Units()


@dataclass(frozen=True)
class Shown:
    """How pictures and tables show amplitudes: of modes or of a DOF, in which units."""

    dof: int | None = None
    units: Units = SI
    modal: str = MODAL  # the unit of modal amplitudes, as written

    def size(self, motion: SteadyMotion) -> Floats:
        """Return |a_j| of steady states, or the amplitude of the DOF at each carrier."""
        if self.dof is None:
            return np.abs(motion.amplitude)
        return self.units.of_displacement(motion.displacement(self.dof))

    @property
    def unit(self) -> str:
        """The unit of an amplitude."""
        return self.modal if self.dof is None else self.units.displacement

    def named(self, name: str) -> str:
        """Return the name of an amplitude with its unit."""
        return f"{name} [{self.modal}]" if self.dof is None else self.units.of_dof(name, self.dof)
