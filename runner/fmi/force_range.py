"""Largest forces of a scene at which its amplitudes stay inside the friction table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipmode.fmu import StoppedError
from slipmode.rom import Model, SlipmodeError
from slipmode.runner.plan.excited import start_amplitudes
from slipmode.runner.plan.plan import Plan
from slipmode.runner.plan.settling import shortened
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.script import Script


def largest_forces(plan: Plan, model: Model) -> dict[str, float]:
    """Return the largest magnitudes of the force inputs at which the scene stays in the table.

    All forces of the scene grow by one factor, found to 1 %, until an amplitude leaves the table.
    Inputs that the scene does not force are omitted, and all of them if no factor up to 1024 takes
    an amplitude out of the table.
    """
    names = [f"force_{mode}" for mode in plan.excited.modes]
    forces = np.abs(plan.schedule.extremes(names)).max(axis=0)
    factor, most = 1.0, 1024.0
    while factor < most and _stays(plan, model, 2.0 * factor):
        factor *= 2.0
    if factor >= most:
        return {}
    step = factor
    for _ in range(7):  # to 1 %
        step *= 0.5
        if _stays(plan, model, factor + step):
            factor += step
    largest = zip(names, (factor * forces).tolist(), strict=True)
    return {name: force for name, force in largest if force > 0.0}


def _stays(plan: Plan, model: Model, factor: float) -> bool:
    """Return whether the scene with `factor` times its forces stays in the table."""
    schedule = _forced(plan.schedule, factor)
    excited = plan.excited
    if plan.scene.model.formulation == "consistent":
        excited = replace(excited, amplitude=start_amplitudes(excited, schedule))
    try:
        component = excited.component(model, plan.scene.run.tolerance)
    except SlipmodeError:  # it starts outside
        return False
    try:
        for _ in component.trace(
            *shortened(schedule, model, excited.modes, component.input_names)
        ):
            pass
    except StoppedError:
        return False
    return True


def _forced(schedule: Schedule, factor: float) -> Schedule:
    """Return the schedule with `factor` times its forces."""
    scripts = {
        name: Script(script.times, tuple(factor * value for value in script.values))
        if name.startswith("force_")
        else script
        for name, script in schedule.scripts.items()
    }
    return replace(schedule, scripts=scripts)
