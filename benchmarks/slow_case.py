"""slipmode on a case: the friction table, the slow flow, and the motion that it describes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.cases import Case
from slipmode import rom
from slipmode.fmu import Component, StoppedError
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reduction import Formulation
from slipmode.rom.slow.motion import Motion

_COARSE = 0.05  # tolerance of the table that finds the amplitude range
_MARGIN = 1.15  # range of a table over the largest amplitude of the run


@dataclass(frozen=True, eq=False)
class SlowCase:
    """A case with its friction table, and the seconds that reduction, range and table took."""

    case: Case
    model: rom.Model
    seconds: float

    @classmethod
    def tabulate(
        cls, case: Case, tolerance: float, formulation: Formulation = "consistent"
    ) -> SlowCase:
        """Reduce a case, find the amplitudes that it reaches, and tabulate them."""
        started = time.perf_counter()
        consistent = formulation == "consistent"
        reduced = rom.reduce(
            *(case.structure, range(len(case.force)), formulation),
            carrier=case.frequency if consistent else None,
            force_patterns=case.force if consistent else None,
        )
        harmonics = RESPONSE_ORDER if consistent else 0
        reached = _reach(case, reduced)
        model = rom.tabulate(reduced, case.law, reached, tolerance, harmonics=harmonics)
        return cls(case, model, time.perf_counter() - started)

    def march(self, step: float, tolerance: float = 1e-6) -> Marcher:
        """Return the slow flow from rest in communication steps [s], ready to be timed."""
        return Marcher(self, step, tolerance)


class Marcher:
    """The slow flow of a case in equal communication steps; a call runs it from rest."""

    def __init__(self, slow: SlowCase, step: float, tolerance: float) -> None:
        case, self._model = slow.case, slow.model
        self._case, reduced = case, slow.model.reduced
        self.component = Component(slow.model, case.force, tolerance=tolerance)
        steps = round(case.duration / step)
        self._durations = np.full(steps, step)
        self._inputs = constant_inputs(self.component, case.frequency, steps)
        modal = [reduced.modal_force(j, pattern) for j, pattern in enumerate(case.force)]
        self._modal_force = np.asarray(modal, dtype=complex)
        self._force_response = AppliedForces.of(reduced, case.force, case.structure)
        self._start = self._force_response.free_vibration(
            self._modal_force, np.asarray(case.frequency)
        )

    def __call__(self) -> Floats:
        """Return the outputs after every step, (steps, outputs)."""
        self.component.reset(amplitude=self._start)
        return self.component.run(self._durations, self._inputs)

    def column(self, outputs: Floats, name: str) -> Floats:
        """Return one output after every step, (steps,)."""
        return outputs[:, self.component.output_names.index(name)]

    def motion(self, outputs: Floats, times: Floats) -> Motion:
        """Return the fast motion, with contacts integrated in time."""
        return rom.reconstruct(self._model, self._trajectory(outputs), times)

    def sums(self, outputs: Floats, times: Floats) -> Motion:
        """Return the fast motion, summed from harmonics."""
        return rom.sum_harmonics(self._model, self._trajectory(outputs), times)

    def elastic(self, motion: Motion) -> Floats:
        """Return the displacement of the observed DOFs, (samples, observed)."""
        return motion.elastic(self._model, self._case.observed)

    def _trajectory(self, outputs: Floats) -> rom.SlowTrajectory:
        modes = "AB"[: self._model.modes]
        time_, *angles = (
            np.append(0.0, self.column(outputs, name))
            for name in ("time", *(f"theta_{mode}" for mode in modes))
        )
        shape = (self._durations.size, self._model.modes)
        amplitude = amplitudes(self.component, outputs, self._model.modes)
        return rom.SlowTrajectory(
            time=time_,
            amplitude=np.vstack((self._start, amplitude)),
            angle=np.column_stack(angles),
            frequency=np.broadcast_to(self._case.frequency, shape),
            frequency_rate=np.zeros(shape),
            force=np.broadcast_to(self._modal_force, shape),
            force_rate=np.zeros(shape, dtype=complex),
            force_response=self._force_response,
        )


def constant_inputs(component: Component, frequency: Sequence[float], steps: int) -> Floats:
    """Return rows of inputs: all forces 1, constant frequencies, friction limits unchanged."""
    values = {"limit_scale": 1.0}
    for mode, Omega in zip("AB", frequency, strict=False):
        values |= {f"force_{mode}": 1.0, f"frequency_{mode}": Omega}
    return np.tile([values.get(name, 0.0) for name in component.input_names], (steps, 1))


def amplitudes(component: Component, outputs: Floats, modes: int = 2) -> Complexes:
    """Return the amplitudes (steps, modes) in rows of outputs."""
    real, imaginary = (
        [component.output_names.index(f"{mode}_{part}") for mode in "AB"[:modes]]
        for part in ("re", "im")
    )
    return np.asarray(outputs[:, real] + 1j * outputs[:, imaginary])


def steady_displacement(model: rom.Model, case: Case, amplitude: Complexes) -> Complexes:
    """Return the carrier of each mode in the DOF that observes it, (modes,): x = Phi a + X P."""
    reduced, modulus = model.reduced, np.abs(amplitude)
    grid = Discretisation(model.accuracy.steps, model.accuracy.lines)
    P = ContactProblem(reduced, case.law).on(grid).solve(modulus[np.newaxis]).P[0]
    turned = P * (amplitude / np.where(modulus > 0, modulus, 1.0))[:, np.newaxis]
    dofs = list(case.observed)
    own = reduced.mode_shapes[dofs, np.arange(model.modes)] * amplitude
    return np.asarray(own + np.einsum("jc,jc->j", reduced.contact_shapes[dofs], turned))


def _reach(case: Case, reduced: rom.Reduced) -> list[float]:
    """Amplitude range of a case with a margin; the range of a coarse table grows as needed."""
    tried = np.full(len(case.force), 4.0)
    while True:
        coarse = rom.tabulate(reduced, case.law, tried.tolist(), _COARSE)
        march = Marcher(SlowCase(case, coarse, 0.0), 1.0, 1e-4)
        try:
            outputs = march()
        except StoppedError:
            tried *= 2.0
            continue
        largest = np.abs(amplitudes(march.component, outputs, tried.size)).max(axis=0)
        return [float(each) for each in np.maximum(_MARGIN * largest, 0.05 * tried)]
