"""Friction from blunt to exactly sharp."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.friction_terms import friction_functions
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.runner.report.cases.cases import two_mode
from slipmode.runner.report.hard.hard_case import SIGNAL, HardCase
from slipmode.runner.report.hard.signals import largest, signal_error

_LIMIT = 2.0
_STEPS = 4096  # per period, of the friction function that is compared with its closed form
_FAST = ("0.1", "1e-8")
_ALPHAS = ("0.1", "1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8")


def closed_form(reduced: rom.Reduced, amplitude: Floats) -> np.ndarray:
    """Q of mode A alone under Coulomb friction, the other contact stuck."""
    k, K = abs(reduced.coupling[0, 0]), reduced.stiffness[0, 0]
    r = np.minimum(_LIMIT / (2 * k * amplitude), 1.0)
    root = np.sqrt(r * (1 - r))
    real = np.pi / 2 + np.arcsin(1 - 2 * r) + 2 * (1 - 2 * r) * root
    return np.asarray(k**2 / K * (real - 4j * r * (1 - r)) / np.pi)


def _closed_form_error() -> float:
    reduced = rom.reduce(rom.two_mass(), modes=(0,), formulation="paper")
    amplitude = np.linspace(0.1, 4.0, 40)
    exact = closed_form(reduced, amplitude)
    grid = Discretisation(_STEPS, lines=1)
    law = rom.Coulomb(_LIMIT)
    found = friction_functions(reduced, law, amplitude[:, np.newaxis], grid, 1e-10)[:, 0]
    return largest(found - exact) / largest(exact)


def sharpness_cases() -> list[HardCase]:
    """From alpha 0.1 to exact Coulomb."""
    laws: list[tuple[str, rom.Friction]] = [
        (f"alpha {alpha}", rom.Tanh(_LIMIT, float(alpha))) for alpha in _ALPHAS
    ]
    everything = [*laws, ("exact Coulomb", rom.Coulomb(_LIMIT))]
    found = []
    for name, law in everything:
        case = replace(two_mode(), name=name, law=law)
        found.append(
            HardCase(
                name,
                "friction as stiff as it is sharp: steps that fail or shrink without end",
                "RMS of displacements, 600 s from rest",
                SIGNAL,
                partial(signal_error, case),
                motion=case,
                slow=name.removeprefix("alpha ") not in _FAST,
            )
        )
    found.append(
        HardCase(
            "exact Coulomb, closed form",
            "stick and slip changing within a step",
            "Q of one mode, of its largest",
            1e-6,
            _closed_form_error,
        )
    )
    return found
