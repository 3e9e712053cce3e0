"""Full order on reduced bases, beside a hand-written Newmark and the slow flow: make bench-full.

Ratios of processor times at equal error. Newmark is the peer of full order; full order at the
largest step that is as exact as the slow run is that of the slow run. Tables are apart.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Sequence
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
from slipmode.runner.report.cases.blade import blade
from slipmode.runner.report.measure import one_thread
from slipmode.runner.report.peers.newmark import Newmark
from slipmode.runner.scene.scene import load_scene
from slipmode.runner.transients.full_order import excitation_of, initial_state
from slipmode.runner.transients.hybrid import stepper
from slipmode.runner.transients.reference import on_all_modes
from slipmode.runner.validate import slow_motion, with_window

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
_SCENE_STEPS = (4, 6, 8, 12, 16, 24, 32, 64, 128)


class Timed(NamedTuple):
    """A run: steps per period, processor seconds, relative RMS of its displacements."""

    steps: int
    seconds: float
    error: float


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


def _beside_newmark() -> None:
    case = Jenkins12.made()
    exact = case.integrated(1024)()
    found: dict[str, list[Timed]] = {"rom.full": [], "Newmark": []}
    ways = (("rom.full", case.integrated, _STEPS), ("Newmark", case.newmark, _NEWMARK_STEPS))
    print(f"{_CYCLES} cycles, {_CONTACTS} Jenkins contacts, {case.structure.n_dofs} coordinates")
    for name, way, settings in ways:
        for steps in settings:
            seconds, x_c = _timed(way(steps))
            found[name].append(Timed(steps, seconds, float(relative_rms(x_c, exact).max())))
            error = found[name][-1].error
            print(f"  {name:9} {steps:5} steps a period {seconds:8.4f} s {error:9.1e}")
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


def _slow_beside_full(name: str) -> None:
    plan = with_window(make_plan(load_scene(name)))
    started = time.process_time()
    model, _ = plan.model()
    table = time.process_time() - started
    slow_seconds = min(_slow_seconds(plan, model) for _ in range(_REPEATS))
    seconds, (_, motion) = _timed(lambda: slow_motion(plan, model))
    times = np.union1d(motion.time, [plan.scene.run.duration])
    seen = np.isin(times, motion.time)
    exact = on_all_modes(plan, times, _EXACT_STEPS).displacement[seen]

    def error(modal: Floats) -> float:
        return float(relative_rms(modal[:, : model.modes], exact).max())

    small, runs = OnComponentModes(plan, times), []
    for steps in _SCENE_STEPS:
        spent, found = _timed(small.at(steps), 2)
        runs.append(Timed(steps, spent, error(found.displacement[seen])))
    ours = error(motion.modal)
    peer = at_equal_error(runs, ours)
    print(f"{name}, {plan.structure.n_dofs} DOFs, {plan.scene.run.duration:g} s")
    print(f"  slow run {1e3 * slow_seconds:.3g} ms, error {ours:.1e}; with fast motion in its")
    print(f"  window {1e3 * seconds:.3g} ms; table {table:.1f} s")
    print(f"  rom.full on {small.coordinates} coordinates, {peer.steps} steps a period:", end=" ")
    print(f"{1e3 * peer.seconds:.3g} ms, error {peer.error:.1e}")
    print(f"  = {peer.seconds / slow_seconds:.0f} slow runs; ", end="")
    print(f"the table takes {table / peer.seconds:.1f} of it")


def main() -> None:
    """Print both; tables are made anew."""
    with one_thread(), tempfile.TemporaryDirectory() as folder:
        os.environ["SLIPMODE_CACHE"] = folder
        _beside_newmark()
        for name in _SCENES:
            _slow_beside_full(name)


if __name__ == "__main__":
    main()
