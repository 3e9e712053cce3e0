"""Frequencies in simple ratios: harmonics of one mode drive the other."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from slipmode import rom
from slipmode.runner.report.cases.cases import Case, two_mode
from slipmode.runner.report.hard.hard_case import SIGNAL, HardCase
from slipmode.runner.report.hard.signals import scene_error, signal_error

_DETUNING = 0.98


def _at_ratio(p: int, q: int) -> Case:
    """Both natural frequencies and both forcings in the ratio p : q."""
    ratio = q / p
    structure = rom.two_mass(beta=0.01, k2=ratio**2)
    return replace(
        two_mode(),
        name=f"ratio {p}:{q}",
        structure=structure,
        force=({0: 0.15}, {1: 0.25}),
        frequency=(_DETUNING, _DETUNING * ratio),
    )


def ratio_cases() -> list[HardCase]:
    """1:1 is refused, the others are modelled."""
    found = [
        HardCase(
            "ratio 1:1",
            "one frequency, not two: the torus is a line",
            "RMS of modal displacements of the scene",
            SIGNAL,
            partial(scene_error, frequency_B=0.98),
            refusal="must differ at all times",
        )
    ]
    for p, q in ((1, 2), (1, 3), (3, 5)):
        case = _at_ratio(p, q)
        found.append(
            HardCase(
                case.name,
                "a harmonic on the carrier of the other mode; small denominators",
                "RMS of displacements, 600 s from rest",
                SIGNAL,
                partial(signal_error, case),
                motion=case,
                slow=True,
            )
        )
    return found
