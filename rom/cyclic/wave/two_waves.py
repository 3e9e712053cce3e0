"""Models of two travelling waves of one structure, at two frequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from numpy.typing import ArrayLike

from slipmode.rom.cyclic.wave.travelling_wave import TravellingWave
from slipmode.rom.cyclic.wave.wave_table import wave_model
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.table.model import Model


def tabulate_waves(
    waves: Sequence[TravellingWave],
    amplitude: Sequence[float],
    force: Sequence[Mapping[int, complex] | ArrayLike | None],
    tolerance: float = 1e-3,
    frequency: Sequence[float | None] = (None, None),
) -> Model:
    """Return the model of two travelling waves of one structure at two frequencies.

    Two engine orders excite them, each near the frequency of its wave. Alternatively one wave is
    self-excited and the other is forced. `rom.limit_cycles` finds the limit cycles of such a
    model, with the force {} of the self-excited wave.

    Parameters
    ----------
    waves : sequence of TravellingWave
        Two waves with one structure and law, and with different frequencies.
    amplitude : sequence of float
        Largest amplitude |a_j| of each wave [kg^1/2 m].
    force : sequence of {DOF: amplitude} or (n_s,) array_like
        Force pattern of each wave, in any scale, see `TravellingWave.modal_force`. None for a wave
        without force.
    tolerance : float, default 0.001
        Relative error of the amplitude equation [-], as in `rom.tabulate`.
    frequency : sequence of float or None, default (None, None)
        Reference frequency of each wave [rad/s], see `TravellingWave.tabulate`.

    Returns
    -------
    Model
        Model of two modes, see `TravellingWave.tabulate`.

    Raises
    ------
    SlipmodeError
        If the waves have different structures or laws, or the tolerance cannot be reached.

    Notes
    -----
    The stability of steady states and limit cycles includes the two amplitudes only. The stability
    against waves of other nodal diameters is not computed; `WaveState.stable` computes it for one
    wave.
    """
    counts = [len(each) for each in (waves, force, frequency)]
    if counts != [2, 2, 2]:
        raise SlipmodeError(f"waves, force, frequency: must have two entries each, got {counts}")
    first, second = waves
    if first.structure is not second.structure or first.law != second.law:
        raise SlipmodeError("waves: must be of the same structure and law")
    carriers = [
        wave.carrier(f, omega) for wave, f, omega in zip(waves, force, frequency, strict=True)
    ]
    if carriers[0].frequency == carriers[1].frequency:
        raise SlipmodeError("waves: must have different frequencies")
    return wave_model(carriers, amplitude, tolerance)
