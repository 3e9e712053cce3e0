"""Models of two travelling waves of one structure, at two frequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from numpy.typing import ArrayLike

from slipmode.rom.arrays import as_floats
from slipmode.rom.cyclic.wave.travelling_wave import TravellingWave
from slipmode.rom.cyclic.wave.wave_table import wave_model
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.table.model import Model
from slipmode.rom.table.tabulation import check_request


def tabulate_waves(
    waves: Sequence[TravellingWave],
    amplitude: Sequence[float],
    force: Sequence[Mapping[int, complex] | ArrayLike | None],
    tolerance: float = 1e-3,
    frequency: Sequence[float | None] = (None, None),
) -> Model:
    """Return the model of two travelling waves of one structure, at two frequencies.

    Two engine orders drive them, each near the frequency of its wave. Or one is self-excited and
    flutters while the other is forced: then `rom.limit_cycles` finds the limit cycles, with the
    force {} of the self-excited wave.

    Parameters
    ----------
    waves : sequence of TravellingWave
        Two, of the same structure and law. Their frequencies differ.
    amplitude : sequence of float
        Largest |a_j| [kg^1/2 m].
    force : sequence of {DOF: amplitude} or (n_s,) array_like
        Pattern of the excitation of each wave, see `TravellingWave.modal_force`; None of a wave
        without a force.
    tolerance : float
        As in `rom.tabulate`.
    frequency : sequence of float or None
        As in `TravellingWave.tabulate`, of each wave.

    Returns
    -------
    Model
        As of `TravellingWave.tabulate`, with two modes.

    Raises
    ------
    SlipmodeError
        If the waves do not belong together; if the tolerance cannot be reached.

    Notes
    -----
    Stability of steady states and limit cycles is that of the two amplitudes
    (tests/rom/cyclic/wave/test_flutter_and_engine_order.py). Whether the two waves break into
    waves of other nodal diameters is not known; `WaveState.stable` says so of one wave.
    """
    counts = [len(each) for each in (waves, force, frequency)]
    if counts != [2, 2, 2]:
        raise SlipmodeError(f"waves, force, frequency: must have two entries each, got {counts}")
    first, second = waves
    if first.structure is not second.structure or first.law != second.law:
        raise SlipmodeError("waves: must be of the same structure and law")
    ends = as_floats("amplitude", amplitude)
    check_request(ends, 2, tolerance, amplitude)
    carriers = [
        wave.carrier(f, omega) for wave, f, omega in zip(waves, force, frequency, strict=True)
    ]
    if carriers[0].frequency == carriers[1].frequency:
        raise SlipmodeError("waves: must have different frequencies")
    return wave_model(carriers, first.law, ends, tolerance)
