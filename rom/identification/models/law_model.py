"""The model of an identified law."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import Finding, warn
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.rom.slow.rates.model_of_rates import model_of_rates
from slipmode.rom.table.model import Model


def model_of_law(
    law: SlowLaw, factors: Complexes, largest: Floats, mode_shapes: Floats, tolerance: float
) -> Model:
    """Return the model of a law, without its quadratic coupling.

    `largest` (modes,) are the largest amplitudes of the model [sensor unit], `mode_shapes`
    (channels, modes) the mass-normalised modes at the sensors [kg^-1/2].
    """
    size = np.abs(factors)

    def rates(amplitudes: Floats) -> tuple[Floats, Floats]:
        sensor = (amplitudes * size).T
        return law.damping_rates(*sensor).T, law.frequencies(*sensor).T

    warn(_coupling_findings(law, largest), stacklevel=4)
    ends = (largest / size).tolist()
    return model_of_rates(rates, ends, tolerance, mode_shapes=mode_shapes)


def _coupling_findings(law: SlowLaw, largest: Floats) -> list[Finding]:
    """Return a warning of the quadratic coupling, which S_j(|A|, |B|) does not contain."""
    if not np.any(law.coupling):
        return []
    A, B = largest
    changes = np.abs(law.coupling) * [B, A**2 / B]  # |a_j'| / |a_j| by the coupling
    shares = changes / np.abs(law.damping_rates(*largest[:, np.newaxis])[:, 0])
    reason = (
        "the model leaves it out; at the largest amplitudes it changes modes A and B at "
        f"{shares[0]:.2g} and {shares[1]:.2g} times their damping rates"
    )
    return [Finding("quadratic coupling", "neglected", reason, "warning")]
