"""slipmode on a case: the friction table, the slow flow, and the motion that it gives."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from slipmode import rom
from slipmode.fmu import Component, StoppedError
from slipmode.rom import Model, SlowTrajectory
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.contact.torus.motion import contact_harmonics
from slipmode.rom.reduction.force_response import ForceResponse
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.reduction import Formulation
from slipmode.rom.slow.motion import Motion
from slipmode.runner.report.cases.cases import Case

_COARSE = 0.05  # tolerance of the table that finds the range
_MARGIN = 1.15


@dataclass(frozen=True, eq=False)
class SlowCase:
    """A case with its friction table.

    Attributes
    ----------
    case : Case
    model : Model
    seconds : float
        What reduction, range and table took.
    """

    case: Case
    model: Model
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
        reached = _reach(case, reduced)
        model = rom.tabulate(
            reduced,
            case.law,
            reached,
            tolerance,
            harmonics=RESPONSE_ORDER if formulation == "consistent" else 0,
        )
        return cls(case, model, time.perf_counter() - started)

    def march(self, step: float, tolerance: float = 1e-6) -> Marcher:
        """The slow flow from rest, ready to be timed."""
        return Marcher(self, step, tolerance)


class Marcher:
    """The slow flow of a case in equal communication steps.

    Parameters
    ----------
    slow : SlowCase
    step : float
        [s]
    tolerance : float
        Of the slow flow.
    """

    def __init__(self, slow: SlowCase, step: float, tolerance: float) -> None:
        self._case, self._model = slow.case, slow.model
        self._component = Component(slow.model, slow.case.force, tolerance=tolerance)
        self._durations = np.full(round(slow.case.duration / step), step)
        self._force_response = ForceResponse.of(
            slow.model.reduced, slow.case.force, slow.case.structure
        )
        self._start = self._force_response.free_vibration(
            slow.model.reduced, self._modal_force(), np.asarray(slow.case.frequency)
        )
        self._inputs = _constant_inputs(self._component, slow.case, self._durations.size)

    def __call__(self) -> Floats:
        """Outputs after every step, (steps, outputs): what is timed."""
        self._component.reset(amplitude=self._start)
        return self._component.run(self._durations, self._inputs)

    def column(self, outputs: Floats, name: str) -> Floats:
        """One output after every step."""
        return outputs[:, self._component.output_names.index(name)]

    def trajectory(self, outputs: Floats) -> SlowTrajectory:
        """The slow trajectory through the outputs."""
        modes = "AB"[: self._model.modes]
        time_, *angles = (
            np.append(0.0, self.column(outputs, name))
            for name in ("time", *(f"theta_{mode}" for mode in modes))
        )
        amplitude = np.column_stack(
            [self.column(outputs, f"{m}_re") + 1j * self.column(outputs, f"{m}_im") for m in modes]
        )
        shape = (self._durations.size, self._model.modes)
        return SlowTrajectory(
            time=time_,
            amplitude=np.vstack((self._start, amplitude)),
            angle=np.column_stack(angles),
            frequency=np.broadcast_to(self._case.frequency, shape),
            frequency_rate=np.zeros(shape),
            force=np.broadcast_to(self._modal_force(), shape),
            force_rate=np.zeros(shape, dtype=complex),
            force_response=self._force_response,
        )

    def _modal_force(self) -> Complexes:
        reduced, force = self._model.reduced, self._case.force
        modal = [reduced.modal_force(j, pattern) for j, pattern in enumerate(force)]
        return np.asarray(modal, dtype=complex)

    def motion(self, outputs: Floats, times: Floats) -> Motion:
        """Fast motion at some times, the contacts marched."""
        return rom.reconstruct(self._model, self.trajectory(outputs), times)

    def sums(self, outputs: Floats, times: Floats) -> Motion:
        """Fast motion at some times, summed from harmonics."""
        return rom.sum_harmonics(self._model, self.trajectory(outputs), times)

    def elastic(self, motion: Motion) -> Floats:
        """Displacement of the observed DOFs, (samples, observed)."""
        return motion.elastic(self._model, self._case.observed)


def steady_displacement(model: Model, case: Case, amplitude: Complexes) -> Complexes:
    """Carrier of each mode in the DOF that observes it, (modes,): x = Phi a + X P."""
    reduced, grid = model.reduced, _grid(model)
    modulus = np.abs(amplitude)
    P = contact_harmonics(reduced, case.law, modulus[np.newaxis], grid).P[0]
    turned = P * (amplitude / np.where(modulus > 0, modulus, 1.0))[:, np.newaxis]
    modes = np.arange(model.modes)
    dofs = list(case.observed)
    own = reduced.mode_shapes[dofs, modes] * amplitude
    return np.asarray(own + np.einsum("jc,jc->j", reduced.contact_shapes[dofs], turned))


def _grid(model: Model) -> Discretisation:
    return Discretisation(model.accuracy.steps, model.accuracy.lines)


def _reach(case: Case, reduced: rom.Reduced) -> tuple[float, ...]:
    """Amplitudes that the case reaches on a coarse table, grown as needed, with a margin."""
    tried = np.full(len(case.force), 4.0)
    while True:
        coarse = rom.tabulate(reduced, case.law, tried.tolist(), _COARSE)
        try:
            outputs = Marcher(SlowCase(case, coarse, 0.0), 1.0, 1e-4)()
        except StoppedError:
            tried *= 2.0
            continue
        modulus = np.hypot(outputs[:, 1:5:2], outputs[:, 2:5:2])[:, : tried.size].max(axis=0)
        return tuple(float(value) for value in np.maximum(_MARGIN * modulus, 0.05 * tried))


def _constant_inputs(component: Component, case: Case, steps: int) -> Floats:
    values = {"force": (1.0,) * len(case.force), "frequency": case.frequency}
    names = component.input_names
    inputs = np.tile([float(name == "limit_scale") for name in names], (steps, 1))
    for quantity, per_mode in values.items():
        for mode, value in zip("AB", per_mode, strict=False):
            inputs[:, names.index(f"{quantity}_{mode}")] = value
    return inputs
