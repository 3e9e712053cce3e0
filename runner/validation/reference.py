"""The full order that a scene is compared with, and how far its answer is to be trusted."""

from __future__ import annotations

import time
from dataclasses import dataclass

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
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.plan.plan import Plan
from slipmode.runner.transients.full_order import excitation_of, initial_state

_STEPS_PER_PERIOD = 64
MOST_DOFS = 1000  # of which all modes are taken
_HARMONICS = 7  # of the fastest forcing, up to which component modes are right


@dataclass(frozen=True, eq=False)
class Reference:
    """Motion at full order, and how else it comes out when less is spent on it.

    Attributes
    ----------
    motion : FullMotion
        Outputs: the retained modes.
    doubts : list of (FullMotion, FullMotion)
        Pairs of motions: how far they lie apart is an error that the motion may have. At twice
        the step; and of large structures, at that step, on half as many component modes.
    coordinates : int
        It has so many.
    seconds : float
        Wall time of that motion alone.
    """

    motion: FullMotion
    doubts: list[tuple[FullMotion, FullMotion]]
    coordinates: int
    seconds: float

    __repr__ = short_repr


def reference(plan: Plan, times: Floats) -> Reference:
    """Of a scene, at times and at its end.

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
    highest = _HARMONICS * excitation.fastest(plan.scene.run.duration)
    arguments = plan.structure, excited.law, excitation.patterns, highest
    least = max(excited.reduced.modes) + 1  # retained modes are among them
    small = component_modes(*arguments)
    if small.frequency.size < 2 * least:
        small = component_modes(*arguments, modes=2 * least)
    fewer = component_modes(*arguments, modes=max(small.frequency.size // 2, least))
    started = time.perf_counter()
    fine = _on_component_modes(plan, small, excitation, times, 1)
    seconds = time.perf_counter() - started
    coarse = _on_component_modes(plan, small, excitation, times, 2)
    halved = _on_component_modes(plan, fewer, excitation, times, 2)
    doubts = [(coarse, fine), (halved, coarse)]
    return Reference(fine, doubts, small.structure.n_dofs, seconds)


def on_all_modes(plan: Plan, times: Floats, steps_per_period: int) -> FullMotion:
    """Motion of a scene at times, on a structure that is not large; outputs: retained modes."""
    excited = plan.excited
    excitation = excitation_of(plan, np.array(excited.force_patterns), plan.schedule)
    structure = aeroelastic(plan.structure, excited.reduced)
    return integrate(
        *(structure, excited.law, excitation, times),
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
