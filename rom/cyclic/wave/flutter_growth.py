"""Which nodal diameters flutter while their contacts stick, and how fast they grow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.cyclic.wave.travelling_wave import travelling_wave
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.short_repr import frozen


@frozen
class FlutterGrowth:
    """Free motion of a family of modes with stuck contacts and aerodynamic forces.

    Attributes
    ----------
    nodal_diameter : (N,) ndarray of int
        k, ascending; k > 0 travels forward.
    frequency : (N,) ndarray
        [rad/s]
    growth : (N,) ndarray
        Growth rate [1/s]; negative: decay.
    """

    nodal_diameter: NDArray[np.intp]
    frequency: Floats
    growth: Floats

    @property
    def unstable(self) -> list[int]:
        """Nodal diameters that flutter, the fastest growth first."""
        fastest = np.argsort(-self.growth)
        return [int(k) for k in self.nodal_diameter[fastest[self.growth[fastest] > 0.0]]]


def flutter_growth(structure: CyclicStructure, law: Elastic, mode: int = 0) -> FlutterGrowth:
    """Return frequencies and growth rates of all nodal diameters, without slip.

    Parameters
    ----------
    structure : CyclicStructure
        With aerodynamic forces, see `CyclicStructure.with_aerodynamics`. These couple the modes
        of a nodal diameter.
    law : Jenkins, Iwan, Sliders, FrictionalContact or Contacts
        Of the contacts of a sector.
    mode : int
        Mode of each nodal diameter, from 0 in the order of the frequencies.
    """
    N = structure.sectors
    diameters = np.arange(N) - (N - 1) // 2
    # Frequencies of a family rise with the nodal diameter.
    highest = travelling_wave(structure, law, structure.highest_diameter, mode).wave
    free = [highest.modes_of(int(k)).growth() for k in diameters]
    frequency, growth = np.array([[part[mode] for part in of_k] for of_k in free]).T
    return FlutterGrowth(diameters, frequency, growth)
