"""The same problem in other units: results must agree to rounding."""

from __future__ import annotations

from functools import partial

import numpy as np

from slipmode import rom
from slipmode.runner.report.hard.hard_case import HardCase

_LENGTH, _STIFFNESS, _RATE = 1e-9, 1e8, 1e3  # [m], [N/m], [1/s]
_MASS, _FORCE = _STIFFNESS / _RATE**2, _STIFFNESS * _LENGTH
_ROUNDING = 1e-10
_TOLERANCE = 1e-2  # of the tables: the same nodes in both units
_FREQUENCY = np.array([0.98, 1.65])
_RANGE = np.array([4.0, 2.0])


def _steady(
    structure: rom.Structure, law: rom.Friction, length: float, mass: float, rate: float
) -> np.ndarray:
    """Steady amplitudes in units of length times the root of mass."""
    unit = length * np.sqrt(mass)
    frequency = _FREQUENCY * rate
    reduced = rom.reduce(structure, carrier=frequency.tolist())
    model = rom.tabulate(reduced, law, (unit * _RANGE).tolist(), _TOLERANCE)
    force = mass * rate**2 * length
    amplitude = rom.steady(model, frequency, ({0: 0.15 * force}, {1: 0.25 * force}))
    return np.asarray(amplitude / unit)


def _difference(law: rom.Friction, contact_mass: float) -> float:
    """Largest relative difference of a steady amplitude in SI units of a small thing."""
    plain = rom.two_mass(beta=0.01, contact_mass=contact_mass)
    scaled = rom.Structure(
        _MASS * np.asarray(plain.mass),
        _STIFFNESS * np.asarray(plain.stiffness),
        0.01 / _RATE,
        contact=(2, 3),
    )
    limit = 2.0 * _FORCE
    other = (
        rom.Tanh(limit, law.alpha * _LENGTH * _RATE)
        if isinstance(law, rom.Tanh)
        else rom.Coulomb(limit)
    )
    ours = _steady(plain, law, 1.0, 1.0, 1.0)
    theirs = _steady(scaled, other, _LENGTH, _MASS, _RATE)
    return float(np.abs(theirs / ours - 1.0).max())


def unit_cases() -> list[HardCase]:
    """1e-9 m, 1e8 N/m, 1e3 rad/s; and mass ratios of 1e-6."""
    problems: dict[str, tuple[rom.Friction, float]] = {
        "SI units (nm, 1e8 N/m, 1e3 rad/s), tanh": (rom.Tanh(2.0, 0.02), 0.01),
        "SI units, Coulomb": (rom.Coulomb(2.0), 0.01),
        "SI units, mass ratio 1e-6": (rom.Tanh(2.0, 0.02), 1e-6),
    }
    return [
        HardCase(
            name,
            "tolerances that are absolute in some unit",
            "change of the steady amplitudes, relative",
            _ROUNDING,
            partial(_difference, *given),
            slow="Coulomb" not in name,
        )
        for name, given in problems.items()
    ]
