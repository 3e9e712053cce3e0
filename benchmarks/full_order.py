"""Full order on reduced bases, beside a hand-written Newmark and the slow flow: make bench-full.

Ratios of processor times at equal error, each method at the coarsest setting that is as accurate
as required. Newmark is compared with full order, full order with slow runs, without their tables.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from benchmarks.blade import CYCLES, SAMPLES, DenseCase, jenkins_blade
from benchmarks.measure import one_thread, processor_time, worst_rms
from benchmarks.peers.newmark import newmark
from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Floats
from slipmode.rom.full import FullMotion
from slipmode.rom.full.coordinates import ModalCoordinates
from slipmode.rom.full.integration import Integrator
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.planning import make_plan
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import load_scene
from slipmode.runner.transients.full_order import excitation_of, initial_state
from slipmode.runner.transients.passes.integrated import IntegratedPass
from slipmode.runner.transients.passes.loop import Destination
from slipmode.runner.transients.passes.slow import SlowPass
from slipmode.runner.validation.validate import MOST_DOFS, full_motion, slow_motion, with_window

_ERROR = 1e-3
_STEPS = (16, 20, 24, 32, 40, 48, 64, 96, 128)  # per period, of full order
_NEWMARK_STEPS = (128, 192, 256, 320, 384, 448, 512, 768, 1024)
_REPEATS = 5
_SCENES = ("blade", "lap-joint")
_SCENE_ERROR = 3e-3  # the slow run of `blade` at its finest has 2.4e-3
_SCENE_STEPS = (3, 4, 6, 8, 12, 16, 24, 32, 64, 128)
_EXACT_STEPS = 256
_COMMUNICATION = (1, 2, 3, 5, 10, 20)  # steps of the scene at a time
_TOLERANCES = (1e-6, 1e-5, 1e-4, 1e-3)  # of the slow flow


Integrated = Callable[[], FullMotion]


class Timed(NamedTuple):
    """A run: processor seconds, relative RMS error of its displacements, and its setting."""

    seconds: float
    error: float
    setting: str


def at_equal_error(runs: Sequence[Timed], error: float) -> Timed:
    """Return the fastest run that is as accurate, or the most accurate run where none is."""
    good = [run for run in runs if run.error <= error]
    return min(good, key=lambda run: run.seconds) if good else min(runs, key=lambda r: r.error)


def one_mode_blade(dofs: int = 10_000, coordinates: int = 100) -> DenseCase:
    """Return a blade with twelve Jenkins contacts, of which two thirds slip."""
    return jenkins_blade(
        12, dofs=dofs, modes=1, coordinates=coordinates, stiffness=1e7, slipping=0.3
    )


def by_newmark(case: DenseCase, steps: int, cycles: int = CYCLES) -> Callable[[], Floats]:
    """Prepare Newmark's run of a one-mode case; it returns displacements of the contacts."""
    assert isinstance(case.law, rom.Jenkins)
    modes, (pattern,), (Omega,) = ModalCoordinates.of(case.structure), case.force, case.frequency
    step, samples, every = 2.0 * np.pi / Omega / steps, cycles * SAMPLES, steps // SAMPLES
    return partial(newmark, modes, case.law, pattern, Omega, step, samples, every)


def _beside_newmark() -> None:
    case = one_mode_blade()
    exact = case.integrated(1024)().contact_displacement
    print(f"{CYCLES} cycles, {case.name}, {case.structure.n_dofs} coordinates")

    def integrated(steps: int) -> Callable[[], Floats]:
        run = case.integrated(steps)
        return lambda: run().contact_displacement

    chosen = []
    for name, prepare, settings in (
        ("rom.full", integrated, _STEPS),
        ("Newmark", partial(by_newmark, case), _NEWMARK_STEPS),
    ):
        runs = []
        for steps in settings:
            seconds, x_c = processor_time(prepare(steps), _REPEATS)
            runs.append(Timed(seconds, worst_rms(x_c, exact), f"{steps:5} steps a period"))
            print(f"  {name:9} {runs[-1].setting} {seconds:8.4f} s {runs[-1].error:9.1e}")
        chosen.append(at_equal_error(runs, _ERROR))
    ours, peer = chosen
    print(
        f"  at {_ERROR:g}: {ours.seconds:.4f} s and {peer.seconds:.4f} s, "
        f"rom.full takes {ours.seconds / peer.seconds:.2f} of Newmark's time"
    )


def on_component_modes(plan: ModesPlan, times: Floats) -> tuple[int, Callable[[int], Integrated]]:
    """Return the number of coordinates, and what prepares a run of so many steps a period.

    A run returns displacements of the retained modes.
    """
    patterns, law = np.array(plan.excited.force_patterns), plan.excited.law
    excitation = excitation_of(plan.excited.modes, patterns, plan.schedule)
    highest = 7 * excitation.fastest(plan.scene.run.duration)
    small = full.component_modes(plan.structure, law, list(patterns), highest)
    projection = small.projection
    projected = projection.excitation(excitation)
    rows = (projection.to_coordinates @ plan.excited.reduced.mode_shapes).T
    start = projection.state(initial_state(plan, excitation))

    def prepare(steps: int) -> Integrated:
        integrator = Integrator(small.structure, law, projected, rows, steps_per_period=steps)
        return lambda: integrator.run(times, start)

    return small.structure.n_dofs, prepare


def _slow_runs(plan: ModesPlan, model: rom.Model, exact: Floats) -> list[Timed]:
    """Slow runs at every setting; errors of the displacements in the scene's windows."""
    found, run = [], plan.scene.run
    for many in _COMMUNICATION:
        for tolerance in _TOLERANCES:
            changed = replace(run, step=many * run.step, tolerance=tolerance)
            schedule = replace(plan.schedule, step=changed.step)
            coarser = replace(plan, scene=replace(plan.scene, run=changed), schedule=schedule)
            seconds = min(_slow_seconds(coarser, model) for _ in range(_REPEATS))
            motion, _ = slow_motion(coarser, model)
            error = worst_rms(motion.modal[:, : model.modes], exact)
            found.append(Timed(seconds, error, f"steps of {changed.step:g} s, to {tolerance:g}"))
    return found


def _slow_seconds(plan: ModesPlan, model: rom.Model) -> float:
    without = replace(plan, scene=replace(plan.scene, contact=(), elastic=()))
    pass_ = SlowPass(without, Destination(Recorder([])), model)
    pass_.run()
    return pass_.seconds


def _slow_beside_full(name: str) -> None:
    plan = with_window(make_plan(load_scene(name)))
    table, (model, _) = processor_time(plan.model)
    seconds, (motion, _) = processor_time(lambda: slow_motion(plan, model), 2)
    times = np.union1d(motion.time, [plan.scene.run.duration])
    seen = np.isin(times, motion.time)
    coordinates, prepare = on_component_modes(plan, times)
    if plan.structure.n_dofs > MOST_DOFS:
        converged = prepare(_EXACT_STEPS)()
    else:
        converged = full_motion(plan, times, _EXACT_STEPS)
    exact = converged.displacement[seen]
    ours = at_equal_error(_slow_runs(plan, model, exact), _SCENE_ERROR)
    runs = []
    for steps in _SCENE_STEPS:
        spent, full_order = processor_time(prepare(steps), 2)
        error = worst_rms(full_order.displacement[seen], exact)
        runs.append(Timed(spent, error, f"{steps} steps a period"))
    peer = at_equal_error(runs, max(_SCENE_ERROR, ours.error))
    print(f"{name}, {plan.structure.n_dofs} DOFs, {plan.scene.run.duration:g} s")
    for what, run in (("slow run", ours), (f"rom.full on {coordinates} coordinates", peer)):
        print(f"  {what}: {1e3 * run.seconds:.3g} ms, error {run.error:.1e}; {run.setting}")
    print(f"  = {peer.seconds / ours.seconds:.0f} slow runs")
    for what, spent in (
        ("with the fast motion of the scene", seconds),
        ("table", table),
        ("run without a table", _integrated_seconds(name)),
    ):
        print(f"  {what}: {1e3 * spent:.3g} ms = {spent / peer.seconds:.2g} of full order")


def _integrated_seconds(name: str) -> float:
    """Time of a run without a friction table: prepared, integrated, demodulated, sampled."""
    scene = load_scene(name)
    without = replace(scene.model, table="none", transients="slow", amplitude=None, budget=None)
    plan = make_plan(replace(scene, model=without))
    return processor_time(lambda: IntegratedPass(plan, Destination(Recorder([]))).run(), 2)[0]


def main(arguments: list[str] | None = None) -> None:
    """Print both; tables are made anew."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", help="beside full order, without Newmark")
    scenes = parser.parse_args(arguments).scenes
    with one_thread(), tempfile.TemporaryDirectory() as folder:
        os.environ["SLIPMODE_CACHE"] = folder
        if not scenes:
            _beside_newmark()
        for name in scenes or _SCENES:
            _slow_beside_full(name)


if __name__ == "__main__":
    main()
