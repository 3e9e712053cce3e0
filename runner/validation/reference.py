"""The full-order motion that a scene is compared with, and its accuracy."""

from __future__ import annotations

import time

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.full import (
    FullMotion,
    aeroelastic,
    component_modes,
    integrate,
)
from slipmode.rom.full.structures import Projection
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.plan.plan import Plan
from slipmode.runner.transients.full_order import excitation_of, initial_state

# A comparison states the error of these steps, measured by a run at twice the step.
_STEPS_PER_PERIOD = 64
MOST_DOFS = 1000  # for which all modes are computed


@frozen
class Reference:
    """Motion at full order, with cheaper versions of it."""

    motion: FullMotion  # Its outputs are the retained modes
    # Pairs of motions whose difference is an error of `motion`: at twice the step; of large
    # structures also on half as many component modes
    comparisons: list[tuple[FullMotion, FullMotion]]
    coordinates: int  # Number of coordinates
    seconds: float  # Wall time of `motion` alone


def reference(plan: Plan, times: Floats) -> Reference:
    """Return the motion of a scene at full order, at times and at its end.

    Structures of up to 1000 DOFs have all their modes, larger ones `rom.full.component_modes`.
    """
    excited = plan.excited
    times = np.union1d(times, [plan.scene.run.duration])
    if plan.structure.n_dofs <= MOST_DOFS:
        fine, seconds = _timed(plan, times)
        coarse = full_motion(plan, times, _STEPS_PER_PERIOD / 2)
        return Reference(fine, [(coarse, fine)], plan.structure.n_dofs, seconds)
    excitation = excitation_of(plan, np.array(excited.force_patterns), plan.schedule)
    # component modes are accurate up to seven times the fastest forcing
    highest = 7 * excitation.fastest(plan.scene.run.duration)
    arguments = plan.structure, excited.law, excitation.patterns, highest
    least = max(excited.reduced.modes) + 1  # the retained modes are among them
    small = component_modes(*arguments)
    if small.frequency.size < 2 * least:
        small = component_modes(*arguments, modes=2 * least)
    fewer = component_modes(*arguments, modes=max(small.frequency.size // 2, least))
    fine, seconds = _timed(plan, times, small.projection)
    coarse = full_motion(plan, times, _STEPS_PER_PERIOD / 2, small.projection)
    halved = full_motion(plan, times, _STEPS_PER_PERIOD / 2, fewer.projection)
    return Reference(fine, [(coarse, fine), (halved, coarse)], small.structure.n_dofs, seconds)


def _timed(plan: Plan, times: Floats, on: Projection | None = None) -> tuple[FullMotion, float]:
    """Return the motion at full resolution, and the wall time that it takes [s]."""
    started = time.perf_counter()
    motion = full_motion(plan, times, _STEPS_PER_PERIOD, on)
    return motion, time.perf_counter() - started


def full_motion(
    plan: Plan, times: Floats, steps_per_period: float, on: Projection | None = None
) -> FullMotion:
    """Return the motion of a scene, with the retained modes as outputs.

    It is integrated on all modes of the structure, or on the coordinates of a projection.
    """
    reduced, structure = plan.excited.reduced, plan.structure
    excitation = excitation_of(plan, np.array(plan.excited.force_patterns), plan.schedule)
    start, shapes = initial_state(plan, excitation), reduced.mode_shapes
    if on is not None:
        structure, shapes = on.structure, on.to_coordinates @ shapes
        excitation, start = on.excitation(excitation), on.state(start)
    return integrate(
        aeroelastic(structure, reduced, shapes),
        plan.excited.law,
        excitation,
        times,
        steps_per_period=steps_per_period,
        outputs=as_dense(structure.mass @ shapes).T,
        start=start,
    )
