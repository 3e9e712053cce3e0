"""Fixed-interface modes: natural modes of the structure with its contacts bonded."""

from __future__ import annotations

from slipmode.rom.arrays import Floats
from slipmode.rom.structure.held import bonded
from slipmode.rom.structure.structure import Structure

_MOST = 128  # modes computed to pass a frequency


def modes_below(structure: Structure, frequency: float, at_least: int) -> tuple[Floats, Floats]:
    """Modes below a frequency [rad/s], but no fewer than asked for, and 128 at most."""
    return bonded(structure).modes(at_least, frequency, _MOST)


def fixed_interface_modes(structure: Structure, count: int) -> tuple[Floats, Floats]:
    """Lowest natural frequencies (count,) and modes (n, count) with bonded contacts, Eq. (8).

    Mass-normalised; the largest component of each mode, of the elastic DOFs, is positive.
    """
    return bonded(structure).modes(count)
