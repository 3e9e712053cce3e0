"""Frequency and damping of a mode by a friction table, at measured amplitudes of a sensor."""

from __future__ import annotations

import numpy as np

from slipmode.rom import Contacts, Model, Reduced, backbone, decay_rates, tabulate
from slipmode.rom.common import Floats

# Range of the table relative to the largest amplitude by the closed form, which may be too small.
_MARGIN = 1.1
TABLE_TOLERANCE = 1e-3


def tabulated(reduced: Reduced, law: Contacts, amplitude: Floats) -> Model:
    """Return the model of one mode up to amplitudes |a| (points,) [kg^1/2 m]."""
    return tabulate(
        reduced, law, (_MARGIN * float(amplitude.max()),), TABLE_TOLERANCE, detuning=True
    )


def rates_at_sensor(
    model: Model, sensor: int, displacement: Floats, amplitude: Floats, steady: bool
) -> Floats:
    """Return frequency [rad/s] and damping ratio, (2, points), at displacements of a sensor [m].

    `amplitude` are approximate |a| there [kg^1/2 m]. Of steady or of free vibration.
    """
    a = amplitude * displacement / backbone(model, amplitude=amplitude).displacement(sensor)
    if steady:
        found = backbone(model, amplitude=a)
        return np.stack((found.frequency, found.damping))
    delta, omega = decay_rates(model, a[:, np.newaxis])
    return np.stack((omega[:, 0], delta[:, 0] / omega[:, 0]))
