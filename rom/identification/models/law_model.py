"""The model of an identified law."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from slipmode.rom import Model, SlipmodeError, model_of_rates
from slipmode.rom.common import Complexes, Floats
from slipmode.rom.identification.slow_laws import SlowLaw


def model_of_laws(
    laws: Sequence[SlowLaw],
    factors: Complexes,
    range: Floats,
    mode_shapes: Floats,
    tolerance: float,
) -> Model:
    """Return the model of a law, the first one, with the others as its samples.

    `range` (modes, 2) are the smallest measured and the largest amplitudes of the model [sensor
    unit], `mode_shapes` (channels, modes) the mass-normalised modes at the sensors [kg^-1/2]. A
    constant friction force acts like linear damping below the smallest amplitude. Laws with
    quadratic coupling are refused.
    """
    least, largest = range.T
    if np.any(laws[0].coupling):
        raise _no_coupling(laws[0], largest)
    size = np.abs(factors)

    def rates(law: SlowLaw, amplitudes: Floats) -> tuple[Floats, Floats]:
        sensor = (amplitudes * size).T
        if law.form.law == "coulomb":
            sensor = np.maximum(sensor, least[:, np.newaxis])
        return law.damping_rates(*sensor).T, law.frequencies(*sensor).T

    ends = (largest / size).tolist()
    whole, *samples = [partial(rates, law) for law in laws]
    return model_of_rates(whole, ends, tolerance, mode_shapes=mode_shapes, samples=samples)


def _no_coupling(law: SlowLaw, largest: Floats) -> SlipmodeError:
    """Return the refusal of quadratic coupling, which S_j(|A|, |B|) cannot contain."""
    A, B = largest
    changes = np.abs(law.coupling) * [B, A**2 / B]  # |a_j'| / |a_j| by the coupling
    shares = changes / np.abs(law.damping_rates(*largest[:, np.newaxis])[:, 0])
    return SlipmodeError(
        "law: a model cannot contain quadratic coupling. At the largest amplitudes it changes "
        f"modes A and B at {shares[0]:.2g} and {shares[1]:.2g} times their damping rates; "
        "identify with law='power' to fit a law without it"
    )
