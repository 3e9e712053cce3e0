"""Fixed-interface modes: natural modes of the structure with its contacts bonded."""

from __future__ import annotations

from slipmode.rom.arrays import Floats
from slipmode.rom.structure.held import bonded
from slipmode.rom.structure.structure import Structure

_MOST = 128  # modes computed to pass a frequency


def modes_below(structure: Structure, frequency: float, at_least: int) -> tuple[Floats, Floats]:
    """Modes below a frequency [rad/s], but no fewer than asked for, and 128 at most."""
    return bonded(structure).modes(at_least, frequency, _MOST)


def fixed_interface_modes(
    structure: Structure, count: int, reach: float = 0.0
) -> tuple[Floats, Floats]:
    """Lowest natural frequencies (count,) and modes (n, count) with bonded contacts, Eq. (8).

    Mass-normalised; the largest component of each mode, of the elastic DOFs, is positive. Modes
    up to `reach` times the last frequency are computed along with them, for `modes_below`.
    """
    omega, shapes = bonded(structure).modes(count, 0.0, _MOST, reach)
    return omega[:count], shapes[:, :count]
