"""The full-order motion that a scene is compared with, and its accuracy."""

from __future__ import annotations

import time

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.full import (
    ComponentModes,
    Excitation,
    FullMotion,
    aeroelastic,
    component_modes,
    integrate,
)
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
        started = time.perf_counter()
        fine = on_all_modes(plan, times, _STEPS_PER_PERIOD)
        seconds = time.perf_counter() - started
        coarse = on_all_modes(plan, times, _STEPS_PER_PERIOD // 2)
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
    started = time.perf_counter()
    fine = _on_component_modes(plan, small, excitation, times, 1)
    seconds = time.perf_counter() - started
    coarse = _on_component_modes(plan, small, excitation, times, 2)
    halved = _on_component_modes(plan, fewer, excitation, times, 2)
    return Reference(fine, [(coarse, fine), (halved, coarse)], small.structure.n_dofs, seconds)


def on_all_modes(plan: Plan, times: Floats, steps_per_period: int) -> FullMotion:
    """Return the motion of a scene on all modes of its structure; outputs: retained modes."""
    excited = plan.excited
    excitation = excitation_of(plan, np.array(excited.force_patterns), plan.schedule)
    structure = aeroelastic(plan.structure, excited.reduced)
    return integrate(
        structure,
        excited.law,
        excitation,
        times,
        steps_per_period=steps_per_period,
        outputs=as_dense(structure.mass @ excited.reduced.mode_shapes).T,
        start=initial_state(plan, excitation),
    )


def _on_component_modes(
    plan: Plan, small: ComponentModes, excitation: Excitation, times: Floats, part: int
) -> FullMotion:
    reduced, projection = plan.excited.reduced, small.projection
    modes = projection.to_coordinates @ reduced.mode_shapes
    return integrate(
        aeroelastic(small.structure, reduced, modes),
        plan.excited.law,
        projection.excitation(excitation),
        times,
        steps_per_period=_STEPS_PER_PERIOD / part,
        outputs=modes.T,
        start=projection.state(initial_state(plan, excitation)),
    )
