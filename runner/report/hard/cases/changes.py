"""Forcing that changes: sweeps through both peaks, steps of the force, jumps of its phase."""

from __future__ import annotations

from functools import partial

from slipmode.runner.report.hard.hard_case import SIGNAL, HardCase
from slipmode.runner.report.hard.signals import scene_error

_SWEEP = {"duration": 3000.0, "window": [0.0, 3000.0]}
_UP = {"frequency_A": [[0, 0.94], [3000, 1.02]], "frequency_B": [[0, 1.58], [3000, 1.74]]}
_DOWN = {"frequency_A": [[0, 1.02], [3000, 0.94]], "frequency_B": [[0, 1.74], [3000, 1.58]]}
_STEPS: dict[str, object] = {
    "force_A": [[0, 0.15], [200, 0.15], [200, 0.3], [400, 0.3], [400, 0.05]],
    "force_B": [[0, 0.25], [300, 0.25], [300, 0.0], [500, 0.0], [500, 0.5]],
}
_STUCK = {"limit": 1e9}
# Without slip free vibrations are all there is. The slow flow is of second order, so that at a
# detuning d their frequency is off by d^3 / (2 Omega^2): mode B at 1.65 instead of 1.7 rad/s turns
# by 1.6e-3 rad in the 69 s that it takes to decay.
_LINEAR = 1.6e-3
_JUMPS: dict[str, object] = {
    "phase_A": [[0, 0.0], [200, 0.0], [200, 3.1416], [400, 3.1416], [400, 1.0]]
}


def change_cases() -> list[HardCase]:
    """Scenes whose forcing does not stand still."""
    scenes: dict[str, tuple[dict[str, object], str]] = {
        "sweep up through both peaks": ({**_SWEEP, **_UP}, "delay, or a jump missed"),
        "sweep down through both peaks": ({**_SWEEP, **_DOWN}, "delay, or a jump missed"),
        "abrupt steps of force": (_STEPS, "friction behind that of steady motion"),
        "phase jumps": (_JUMPS, "friction behind that of steady motion"),
        "steps of force, no slip": (_STEPS | _STUCK, "free vibrations that jumps leave behind"),
        "phase jumps, no slip": (_JUMPS | _STUCK, "free vibrations that jumps leave behind"),
    }
    return [
        HardCase(
            name,
            risk,
            "RMS of modal displacements of the scene",
            _LINEAR if "no slip" in name else SIGNAL,
            partial(scene_error, **changed),
            slow=True,
        )
        for name, (changed, risk) in scenes.items()
    ]
