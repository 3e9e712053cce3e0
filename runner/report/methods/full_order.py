"""Full order on reduced bases, beside a hand-written Newmark and the slow flow: make bench-full.

Ratios of processor times at equal error, each at the coarsest setting that is as exact as asked:
Newmark is the peer of full order, full order that of slow runs. Tables are apart.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Floats
from slipmode.rom.full import FullMotion
from slipmode.rom.full.convergence import relative_rms
from slipmode.rom.full.integration import Integrator
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.recording.record import Recorder
from slipmode.runner.report.cases.blade import blade
from slipmode.runner.report.measure import one_thread
from slipmode.runner.report.peers.newmark import Newmark
from slipmode.runner.scene.scene import load_scene
from slipmode.runner.transients.full_order import excitation_of, initial_state
from slipmode.runner.transients.hybrid import stepper
from slipmode.runner.transients.integrated import IntegratedPass
from slipmode.runner.validation.reference import MOST_DOFS, on_all_modes
from slipmode.runner.validation.validate import slow_motion, with_window

T = TypeVar("T")

_DOFS, _CONTACTS, _COORDINATES = 10_000, 12, 100
_CYCLES, _SAMPLES = 160, 16
_RATIO, _STIFFNESS, _SLIPPING = 4e-3, 1e7, 0.3  # damping; k_t [N/m]; limit, of the stuck force
_ERROR = 1e-3
_STEPS = (16, 20, 24, 32, 40, 48, 64, 96, 128)  # per period, of full order
_NEWMARK_STEPS = (128, 192, 256, 320, 384, 448, 512, 768, 1024)
_REPEATS = 5
_SCENES = ("blade", "lap-joint")
_HARMONICS, _EXACT_STEPS = 7, 256
_SCENE_ERROR = 3e-3  # what blade's slow run, at its finest 2.4e-3 off, is allowed; then of all
_SCENE_STEPS = (3, 4, 6, 8, 12, 16, 24, 32, 64, 128)
_COMMUNICATION = (1, 2, 3, 5, 10, 20)  # steps of the scene at a time
_TOLERANCES = (1e-6, 1e-5, 1e-4, 1e-3)  # of the slow flow


class Timed(NamedTuple):
    """A run: processor seconds, relative RMS of its displacements, and what it was set to."""

    seconds: float
    error: float
    setting: str


class Jenkins12(NamedTuple):
    """The blade on 100 coordinates, its first mode forced somewhat below resonance."""

    structure: rom.Structure
    law: rom.Jenkins
    pattern: Floats
    frequency: float

    @classmethod
    def made(cls, dofs: int = _DOFS, coordinates: int = _COORDINATES) -> Jenkins12:
        """Two thirds of the contacts slip."""
        matrices = blade(dofs, _CONTACTS)
        stuck = rom.Jenkins(1.0, _STIFFNESS)
        bare = rom.Structure(**matrices, damping=0.0)
        omega = float(rom.reduce(bare, (0,), law=stuck).frequency[0])
        structure = rom.Structure(**matrices, damping=2.0 * _RATIO / omega)
        force = np.zeros(structure.n_dofs)
        force[-1] = 1.0
        modes = coordinates - _CONTACTS - 1
        small = full.component_modes(structure, stuck, [force], 7 * omega, modes=modes)
        pattern = force @ small.projection.basis
        amplitude = pattern[0] / (2.0 * _RATIO * omega**2)  # of the first mode at resonance
        reached = _STIFFNESS * np.abs(amplitude * as_dense(small.structure.directions)[0])
        law = rom.Jenkins(_SLIPPING * float(np.median(reached)), _STIFFNESS)
        return cls(small.structure, law, pattern, 0.99 * omega)

    def times(self, cycles: int = _CYCLES) -> Floats:
        """Sixteen samples a cycle."""
        period = 2.0 * np.pi / self.frequency
        return np.asarray(period / _SAMPLES * np.arange(1, cycles * _SAMPLES + 1))

    def integrated(self, steps: int, cycles: int = _CYCLES) -> Callable[[], Floats]:
        """Our run, its coordinates prepared: displacements of the contacts."""
        excitation = full.Excitation.harmonic(self.structure, (self.pattern,), (self.frequency,))
        integrator = Integrator(
            *(self.structure, self.law, excitation, self.pattern[np.newaxis]),
            steps_per_period=steps,
        )
        return lambda: integrator.run(self.times(cycles)).contact_displacement

    def newmark(self, steps: int, cycles: int = _CYCLES) -> Callable[[], Floats]:
        """Newmark's run, prepared likewise."""
        peer = Newmark.of(self.structure, self.law)
        step = 2.0 * np.pi / self.frequency / steps
        samples, every = cycles * _SAMPLES, steps // _SAMPLES
        rows = self.pattern[np.newaxis]
        return lambda: peer.run(self.pattern, self.frequency, rows, step, samples, every)[1]


def at_equal_error(runs: Sequence[Timed], error: float) -> Timed:
    """The cheapest run that is as exact as that; the most exact one where none is."""
    good = [run for run in runs if run.error <= error]
    return min(good, key=lambda run: run.seconds) if good else min(runs, key=lambda r: r.error)


def _timed(run: Callable[[], T], repeats: int = _REPEATS) -> tuple[float, T]:
    """Least processor time of several calls, which others disturb least."""
    seconds = []
    for _ in range(repeats):
        started = time.process_time()
        result = run()
        seconds.append(time.process_time() - started)
    return min(seconds), result


def _worst(found: Floats, exact: Floats) -> float:
    """The largest error of a signal (samples, signals)."""
    return float(relative_rms(found, exact).max())


def _beside_newmark() -> None:
    case = Jenkins12.made()
    exact = case.integrated(1024)()
    found: dict[str, list[Timed]] = {"rom.full": [], "Newmark": []}
    ways = (("rom.full", case.integrated, _STEPS), ("Newmark", case.newmark, _NEWMARK_STEPS))
    print(f"{_CYCLES} cycles, {_CONTACTS} Jenkins contacts, {case.structure.n_dofs} coordinates")
    for name, way, settings in ways:
        for steps in settings:
            seconds, x_c = _timed(way(steps))
            error = _worst(x_c, exact)
            found[name].append(Timed(seconds, error, f"{steps:5} steps a period"))
            print(f"  {name:9} {found[name][-1].setting} {seconds:8.4f} s {error:9.1e}")
    ours, peer = (at_equal_error(found[name], _ERROR) for name in ("rom.full", "Newmark"))
    print(
        f"  at {_ERROR:g}: {ours.seconds:.4f} s and {peer.seconds:.4f} s, "
        f"rom.full takes {ours.seconds / peer.seconds:.2f} of Newmark's time"
    )


class OnComponentModes:
    """Full order of a scene on component modes, displacements of the retained modes.

    Attributes
    ----------
    coordinates : int
    """

    def __init__(self, plan: Plan, times: Floats) -> None:
        patterns = np.array(plan.excited.force_patterns)
        excitation = excitation_of(plan, patterns, plan.schedule)
        highest = _HARMONICS * excitation.fastest(plan.scene.run.duration)
        small = full.component_modes(plan.structure, plan.excited.law, list(patterns), highest)
        projection = small.projection
        self._law, self._structure, self._times = plan.excited.law, small.structure, times
        self._excitation = projection.excitation(excitation)
        self._rows = (projection.to_coordinates @ plan.excited.reduced.mode_shapes).T
        self._start = projection.state(initial_state(plan, excitation))
        self.coordinates = small.structure.n_dofs

    def at(self, steps: int) -> Callable[[], FullMotion]:
        """A run of so many steps a period, prepared."""
        integrator = Integrator(
            *(self._structure, self._law, self._excitation, self._rows), steps_per_period=steps
        )
        return lambda: integrator.run(self._times, self._start)


def _slow_seconds(plan: Plan, model: rom.Model) -> float:
    """Of a slow run through the scene."""
    component = stepper(plan, model)
    durations = plan.schedule.durations()
    inputs = plan.schedule.inputs(component.input_names)
    started = time.process_time()
    component.run(durations, inputs)
    return time.process_time() - started


def _slow_runs(plan: Plan, model: rom.Model, exact: Floats) -> list[Timed]:
    """At every setting, beside the exact displacements in its windows."""
    found, run = [], plan.scene.run
    for many in _COMMUNICATION:
        for tolerance in _TOLERANCES:
            set_to = replace(run, step=many * run.step, tolerance=tolerance)
            schedule = replace(plan.schedule, step=set_to.step)
            coarser = replace(plan, scene=replace(plan.scene, run=set_to), schedule=schedule)
            seconds = min(_slow_seconds(coarser, model) for _ in range(_REPEATS))
            _, motion = slow_motion(coarser, model)
            error = _worst(motion.modal[:, : model.modes], exact)
            found.append(Timed(seconds, error, f"steps of {set_to.step:g} s, to {tolerance:g}"))
    return found


def _slow_beside_full(name: str) -> None:
    plan = with_window(make_plan(load_scene(name)))
    started = time.process_time()
    model, _ = plan.model()
    table = time.process_time() - started
    seconds, (_, motion) = _timed(lambda: slow_motion(plan, model), 2)
    times = np.union1d(motion.time, [plan.scene.run.duration])
    seen = np.isin(times, motion.time)
    small, runs = OnComponentModes(plan, times), []
    if plan.structure.n_dofs > MOST_DOFS:  # on these component modes then, all modes else
        converged = small.at(_EXACT_STEPS)()
    else:
        converged = on_all_modes(plan, times, _EXACT_STEPS)
    exact = converged.displacement[seen]
    ours = at_equal_error(_slow_runs(plan, model, exact), _SCENE_ERROR)
    for steps in _SCENE_STEPS:
        spent, full_order = _timed(small.at(steps), 2)
        error = _worst(full_order.displacement[seen], exact)
        runs.append(Timed(spent, error, f"{steps} steps a period"))
    peer = at_equal_error(runs, max(_SCENE_ERROR, ours.error))
    print(f"{name}, {plan.structure.n_dofs} DOFs, {plan.scene.run.duration:g} s")
    for what, run in (("slow run", ours), (f"rom.full on {small.coordinates} coordinates", peer)):
        print(f"  {what}: {1e3 * run.seconds:.3g} ms, error {run.error:.1e}; {run.setting}")
    print(f"  = {peer.seconds / ours.seconds:.0f} slow runs; with the fast motion of the scene")
    print(
        f"  {1e3 * seconds:.3g} ms; table {table:.1f} s = {table / peer.seconds:.1f} of full order"
    )
    integrated = _integrated_seconds(name)
    ratio = integrated / peer.seconds
    print(f"  without a table {1e3 * integrated:.3g} ms = {ratio:.1f} of full order")


def _integrated_seconds(name: str) -> float:
    """Of a run without a friction table: prepared, integrated, demodulated, sampled."""
    scene = load_scene(name)
    without = replace(scene.model, table="none", transients="slow", amplitude=None, budget=None)
    plan = make_plan(replace(scene, model=without))
    with Recorder([]) as recorder:
        return _timed(lambda: IntegratedPass(plan).record(recorder, lambda: None, False), 2)[0]


def main(arguments: list[str] | None = None) -> None:
    """Print both; tables are made anew."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("scenes", nargs="*", default=_SCENES, help="beside full order alone")
    options = parser.parse_args(arguments)
    with one_thread(), tempfile.TemporaryDirectory() as folder:
        os.environ["SLIPMODE_CACHE"] = folder
        if options.scenes == _SCENES:
            _beside_newmark()
        for name in options.scenes:
            _slow_beside_full(name)


if __name__ == "__main__":
    main()
