"""Steps and windows of a scene compared with its frequencies."""

from __future__ import annotations

from itertools import product
from math import ceil, pi
from typing import TYPE_CHECKING

import numpy as np

from slipmode.rom import Model, SlipmodeError
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.validity import check_carrier
from slipmode.runner.plan.excited import Excited
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import Scene

if TYPE_CHECKING:
    from slipmode.runner.plan.plan import Plan

_LONGEST_STEP = 1e6  # periods: rounding then changes a phase by 1e-9 in a step
_MOST_SAMPLES = 1e8  # of all windows: some GB in a recording
# Part of the decay of free vibrations by which explicit Euler may be wrong, and the least ratio of
# Re to modulus of an eigenvalue whose decay it has to follow: amplitudes are then within 5 % of
# the exact ones (tests/fmu/test_fmu_command.py).
_EULER_ERROR, _LEAST_DAMPED = 0.05, 0.01


def check_time_scales(scene: Scene, excited: Excited, schedule: Schedule) -> None:
    """Refuse a scene whose forcing, steps or windows no run can follow, naming the key."""
    reached = schedule.frequency_range(excited.modes)
    natural = zip(excited.modes, excited.reduced.frequency, *reached, strict=True)
    for mode, omega, *values in natural:
        key, unit = f"forcing.{mode}.frequency", scene.units.frequency
        check_carrier(key, mode, float(omega), np.array(values), unit)
    fastest = float(reached[1].max())
    longest = _LONGEST_STEP * 2 * pi / fastest
    if scene.run.step > longest:
        raise SlipmodeError(
            f"run.step: must be at most {longest:.3g} s, {_LONGEST_STEP:g} periods of the "
            f"forcing, got {scene.run.step:g}"
        )
    per_second = fastest / (2 * pi)
    samples = sum(per_second * w.samples_per_period * (w.end - w.start) for w in scene.windows)
    if samples > _MOST_SAMPLES:
        raise SlipmodeError(
            f"contact.window, elastic.window: would hold {samples:.2g} samples, allowed: "
            f"{_MOST_SAMPLES:g}; make them shorter or samples_per_period smaller"
        )


def euler_step(plan: Plan, model: Model) -> float:
    """Return the scene's step, or a whole part of it, at which explicit Euler is accurate [s].

    FMUs declare it for importers that integrate Model Exchange with fixed steps. A step h takes
    h |lambda|^2 / 2 off the decay -Re lambda of a free vibration with eigenvalue lambda of the
    slow flow: at most 5 % at all nodes of the friction table, under the least, middle and largest
    frequencies of the scene.
    """
    nodes = [model.table.node_a, model.table.node_b][: model.modes]
    points = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, model.modes)
    least, most = plan.schedule.frequency_range(plan.excited.modes)
    longest = plan.scene.run.step
    for frequency in product(*zip(least, 0.5 * (least + most), most, strict=True)):
        flow = ForcedFlow.of(model, np.tile(frequency, (len(points), 1)))
        _, jacobian = flow.rate_and_jacobian(points.astype(complex))
        eigenvalue = np.linalg.eigvals(jacobian[np.isfinite(jacobian).all(axis=(1, 2))])
        size = np.abs(eigenvalue)
        decay = np.maximum(np.abs(eigenvalue.real), _LEAST_DAMPED * size)
        longest = min(longest, float(np.min(2.0 * _EULER_ERROR * decay / size**2)))
    return plan.scene.run.step / ceil(plan.scene.run.step / longest * (1.0 - 1e-9))
