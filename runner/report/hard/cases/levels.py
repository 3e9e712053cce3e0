"""Amplitudes and forces: none, at the slip threshold, very unequal, beyond the table."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

import numpy as np

from slipmode import rom
from slipmode.fmu import Component
from slipmode.runner.report.cases.cases import Case, two_mode
from slipmode.runner.report.hard.hard_case import FLOW, SIGNAL, HardCase
from slipmode.runner.report.hard.signals import largest, scene_error, signal_error

# What just reaches the slip thresholds |A| = 1, |B| = 0.346 without friction at
# 0.98 and 1.65 rad/s: F_j = 2 |a_j| |omega_j^2 - Omega_j^2 + i beta omega_j^2 Omega_j|
_THRESHOLD = (0.0816, 0.1206)
_RANGE = (4.0, 4.0)
_START = (2.0, 1.0)
# An internal step may err by its tolerance times |a| + 1e-3 of the range (dopri5.c, error_of):
# the second part is what a decay may leave, and the decay itself forgets earlier errors.
_LEFT = FLOW * 1e-3 * _RANGE[0] / _START[0]


def _forced(name: str, A: float, B: float, law: rom.Friction | None = None) -> Case:
    case = two_mode()
    return replace(case, name=name, force=({0: A}, {1: B}), law=law or case.law)


@cache
def _model() -> rom.Model:
    return rom.tabulate(rom.reduce(rom.two_mass()), two_mode().law, _RANGE, 1e-2)


def _friction_of_modes_at_rest() -> float:
    """|S_j| where |a_j| = 0, relative to the largest |S_j|."""
    model = _model()
    axis = np.linspace(0.0, 4.0, 101)
    rest = np.zeros_like(axis)
    along = [model.table(np.column_stack(pair)) for pair in ((axis, rest), (rest, axis))]
    scale = largest(model.table((axis[-1], axis[-1])))
    return max(largest(along[0][:, 1]), largest(along[1][:, 0])) / scale


def _motion_without_force() -> float:
    """Amplitudes after 1000 s at rest without force [kg^1/2 m]."""
    component = Component(_model())
    component.do_step(0.0, 1000.0)
    outputs = component.outputs()
    return max(abs(outputs[f"{mode}_{part}"]) for mode in "AB" for part in ("re", "im"))


def _left_of_a_decay() -> float:
    """Amplitude after a decay that would take it below the smallest double, of the first."""
    component = Component(_model(), tolerance=FLOW)
    component.reset(amplitude=_START)
    component.do_step(0.0, 1e6)
    outputs = component.outputs()
    return float(np.hypot(outputs["A_re"], outputs["A_im"]) / _START[0])


def level_cases() -> list[HardCase]:
    """Nothing, little, much."""
    signals = {
        "at the slip threshold, Coulomb": (*_THRESHOLD, rom.Coulomb(2.0)),
        "at the slip threshold, tanh": (*_THRESHOLD, None),
        "weak B under strong A": (0.3, 0.01, None),
        "weak A under strong B": (0.005, 0.5, None),
        "force 0.5 / 0.75 (Fig. 8)": (0.5, 0.75, None),
    }
    risks = {
        "at": "contacts that slip in some cycles and not in others",
        "weak": "a small amplitude lost in the error of a large one",
        "force": "contacts that slip all the time; amplitudes past a fixed table",
    }
    found = [
        HardCase(
            name,
            risks[name.split()[0]],
            "RMS of displacements, 600 s from rest",
            SIGNAL,
            partial(signal_error, case := _forced(name, *given)),
            motion=case,
            slow=name != "at the slip threshold, Coulomb",
        )
        for name, given in signals.items()
    ]
    return found + _nothing() + _force_times_ten()


def _nothing() -> list[HardCase]:
    """What must vanish: exactly at rest, but for the absolute tolerance in a decay."""
    zeros = (
        ("|A| = 0 or |B| = 0", "a quotient Q = S / |a| of zeros", _friction_of_modes_at_rest, 0.0),
        ("|A| = |B| = 0", "NaN, or motion out of nothing", _motion_without_force, 0.0),
        ("decay over 1e6 s", "denormal numbers, NaN", _left_of_a_decay, _LEFT),
    )
    return [
        HardCase(name, risk, "what must vanish", bound, measure)
        for name, risk, measure, bound in zeros
    ]


def _force_times_ten() -> list[HardCase]:
    """The table grows by the dry run; a table of given range stops the run."""
    case = _forced("force x 10", 1.5, 2.5)
    steady = {"force_A": 1.5, "force_B": 2.5}
    return [
        HardCase(
            "force x 10",
            "amplitudes beyond the table",
            "RMS of modal displacements of the scene",
            SIGNAL,
            partial(scene_error, **steady),
            motion=case,
            slow=True,
        ),
        HardCase(
            "force x 10, range given",
            "silent extrapolation",
            "RMS of modal displacements of the scene",
            SIGNAL,
            partial(scene_error, **steady, model="amplitude = [4.0, 4.0]\ntolerance = 1e-2"),
            refusal="leaves the friction table",
        ),
    ]
