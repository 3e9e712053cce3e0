"""Which nodal diameters flutter while their contacts stick, and how fast they grow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.common import Floats, frozen
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.cyclic.wave.travelling_wave import travelling_wave
from slipmode.rom.laws import Elastic


@frozen
class FlutterGrowth:
    """Hold the free vibration of a mode family with stuck contacts and aerodynamic forces.

    Attributes
    ----------
    nodal_diameter : (N,) ndarray of int
        Nodal diameters k, ascending; k > 0 is a forward wave.
    frequency : (N,) ndarray
        Frequencies [rad/s].
    growth : (N,) ndarray
        Growth rates [1/s]; negative for decay.
    """

    nodal_diameter: NDArray[np.intp]
    frequency: Floats
    growth: Floats

    @property
    def unstable(self) -> list[int]:
        """Nodal diameters with positive growth rate, fastest growth first."""
        fastest = np.argsort(-self.growth)
        return [int(k) for k in self.nodal_diameter[fastest[self.growth[fastest] > 0.0]]]


def flutter_growth(structure: CyclicStructure, law: Elastic, mode: int = 0) -> FlutterGrowth:
    """Return frequencies and growth rates of all nodal diameters with stuck contacts.

    Parameters
    ----------
    structure : CyclicStructure
        Disk with aerodynamic forces, which couple the modes of each nodal diameter, see
        `CyclicStructure.with_aerodynamics`.
    law : Jenkins, Iwan, Sliders, FrictionalContact or Contacts
        Elastic law of the contacts of one sector.
    mode : int, default 0
        Mode of each nodal diameter, from 0 in the order of the frequencies.

    Returns
    -------
    FlutterGrowth
        Frequency and growth rate of each nodal diameter.
    """
    N = structure.sectors
    diameters = np.arange(N) - (N - 1) // 2
    # Frequencies of a family rise with the nodal diameter.
    highest = travelling_wave(structure, law, structure.highest_diameter, mode)
    free = [highest.modes_of(int(k)).growth() for k in diameters]
    frequency, growth = np.array([[part[mode] for part in of_k] for of_k in free]).T
    return FlutterGrowth(diameters, frequency, growth)
