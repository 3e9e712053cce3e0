"""Stretches of a scene at full order, where slow time has too large a transient error."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import short_list
from slipmode.rom.slow.transient import said_error
from slipmode.rom.validity import Finding
from slipmode.runner.plan.amplitude_range import DryRun
from slipmode.runner.plan.plan import Intervals, ModesPlan
from slipmode.runner.scene.sections import Scene

# Part of the allowed error below which slow time goes on after a stretch at full order: an error
# that stays close to the allowed one does not switch back and forth.
SETTLED = 0.6


def plan_transients(plan: ModesPlan, seen: DryRun | None) -> tuple[Intervals, Finding]:
    """Return start and end of the stretches at full order [s], and the decision.

    `seen` is None if the amplitude range is given, so that there is no dry run.
    """
    scene, modes = plan.scene, plan.excited.modes
    allowed = scene.model.transient_error
    limit = f"{100 * allowed:g} %"
    if seen is None:
        choice = f"full order where the error exceeds {limit}" if scene.switches else "slow time"
        reason = "model.amplitude is given, so the run estimates the transient error"
        return (), Finding("transients", choice, reason)
    error = seen.transient_error / np.array(plan.amplitude)
    largest = said_error(modes, error.max(axis=0, initial=0.0))
    if np.all(error <= allowed):
        return (), Finding("transients", "slow time", f"{largest}, allowed: {limit}")
    if not scene.switches:
        return (), slow_time_error(scene, largest)
    # the window of `demodulation`
    least = 4.0 * 2.0 * np.pi / float(plan.excited.reduced.carrier.min())
    found = _intervals(seen.time, error, allowed, least)
    listed = short_list(f"{start:.4g} to {end:.4g} s" for start, end in found)
    reason = f"{largest} in slow time, allowed: {limit}; times from the dry run"
    return found, Finding("transients", f"full order from {listed}", reason)


def slow_time_error(scene: Scene, error: str) -> Finding:
    """Return the warning that slow time has a larger transient error than allowed."""
    model, reason = scene.model, f"{error}, above {100 * scene.model.transient_error:g} %"
    if scene.saved_model is not None:
        advice = "model.file has no structure to integrate at full order"
    elif scene.disk is not None:
        advice = "structures with sectors have slow time only"
    elif model.transients == "slow":
        advice = 'runs with model.transients = "auto" integrate such stretches at full order'
    elif model.formulation == "paper":
        advice = 'model.formulation = "paper" allows slow time only'
    elif scene.nonlinear_stiffness:
        advice = "[nonlinear_stiffness] allows slow time only"
    else:
        advice = "limits.scale allows slow time only"
    return Finding("transients", "slow time", f"{reason}; {advice}", "warning")


def _intervals(time: Floats, error: Floats, allowed: float, least: float) -> Intervals:
    """Return intervals from an error above the allowed one until it has settled, plus `least`."""
    calm = np.flatnonzero(np.all(error <= SETTLED * allowed, axis=1))
    found: list[tuple[float, float]] = []
    for k in np.flatnonzero(np.any(error > allowed, axis=1)):
        start = float(time[k])
        later = calm[np.searchsorted(calm, k) :]
        end = float(time[later[0]]) + least if later.size else float(time[-1])
        if found and start <= found[-1][1]:
            start = found.pop()[0]
        found.append((start, min(end, float(time[-1]))))
    return tuple(found)
