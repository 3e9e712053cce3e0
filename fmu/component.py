"""The step-able component, FMU style: set inputs, step, read outputs.

Variables are named <quantity>_<mode>, mode A or B:

inputs    force [N], frequency [rad/s], phase [rad], and force_rate, frequency_rate, phase_rate
          per second; where the law is Coulomb's also limit_scale, the friction limits relative to
          the model's, and limit_scale_rate
outputs   time; A_re, A_im, B_re, B_im; theta_A, theta_B (carrier angles);
          input_power, dissipated_power [W], dissipated_energy [J] (mean over the fast cycles, at
          the contacts); with contact motion also contact_<i>_x, _v, _f and x_<dof>

An input holds its value, and moves at its rate, until it is set again; so sweeps are exact and
continuous in phase whatever the step.
"""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rom import Coulomb, Model, SlipmodeError, _kernel
from rom.amplitude import slow_flow
from rom.answer_plane import answer_plane
from rom.torus import contact_problem

MODE_NAMES = ("A", "B")
STEPS_PER_PERIOD = 40
MEMORY_PERIODS = 8.0

Floats = NDArray[np.float64]


class StoppedError(SlipmodeError):
    """A step that could not be taken; the component is as it was before it.

    Attributes
    ----------
    time : float
        Where the component stands [s].
    outputs : (steps, outputs) ndarray
        Outputs of the steps of the same call that succeeded.
    left_table : bool
        Whether an amplitude leaves the friction table; a larger one helps then.
    """

    def __init__(
        self, message: str, time: float, outputs: Floats, left_table: bool = False
    ) -> None:
        super().__init__(message)
        self.time = time
        self.outputs = outputs
        self.left_table = left_table


class Steppable(Protocol):
    """What the runner drives: `Component`, or an FMU behind the same names."""

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; the others keep their values."""

    def do_step(self, time: float, duration: float) -> None:
        """Advance from `time` by `duration` > 0."""

    def outputs(self) -> dict[str, float]:
        """Outputs at the present time."""
        ...

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Many steps: inputs (steps, inputs) before each, outputs (steps, outputs) after."""
        ...


class Component:
    """A model in slow time that is advanced step by step.

    Parameters
    ----------
    model : Model
    force : sequence of {DOF: amplitude} or (n,) array_like, one per mode, optional
        Where a force input of 1 N acts. Default: the input is the modal force [N kg^-1/2].
    contact : bool
        Compute the contact motion at every communication point. It costs a march over the last
        few periods, so it is off unless asked for. In the consistent formulation the modes
        answer to the harmonics of the contacts, so the model must keep some:
        `rom.tabulate(..., harmonics=5)`. The answer is that at the model's carriers: reduce it
        with those of the forcing.
    elastic : sequence of int
        DOFs whose displacement is computed; needs `contact`.
    mode_names : sequence of str
        What the model's modes are called, of "A" and "B": ("B",) where mode B alone is modelled.
    tolerance : float
        Relative tolerance of the slow flow per internal step.

    Raises
    ------
    SlipmodeError
        On arguments that are not allowed.
    """

    def __init__(
        self,
        model: Model,
        force: Sequence[Mapping[int, float] | ArrayLike] | None = None,
        *,
        contact: bool = False,
        elastic: Sequence[int] = (),
        mode_names: Sequence[str] = MODE_NAMES,
        tolerance: float = 1e-6,
    ) -> None:
        if not 1e-13 <= tolerance <= 1e-2:
            raise SlipmodeError(f"tolerance: must be 1e-13 to 1e-2, got {tolerance}")
        if elastic and not contact:
            raise SlipmodeError("elastic: needs contact=True, for the contacts move the DOFs too")
        n_dofs = model.reduced.n_dofs
        if not all(0 <= dof < n_dofs for dof in elastic):
            raise SlipmodeError(f"elastic: DOFs must be 0 to {n_dofs - 1}, got {list(elastic)}")
        self.model = model
        self._force_factor = force_factors(model, force)
        present = present_modes(model, mode_names)
        self._mode_names = (*present, *(name for name in MODE_NAMES if name not in present))
        self.input_names = tuple(
            f"{quantity}_{mode}" for mode in present for quantity in _kernel.INPUT_FIELDS
        )
        if isinstance(model.law, Coulomb):
            self.input_names += _kernel.SCALE_FIELDS
        self.output_names = _output_names(model, self._mode_names, contact, elastic)
        self._handle = _create(model, force, contact, elastic, tolerance)
        self._inputs = _kernel.inputs(1)
        self._inputs["frequency"][0, : model.modes] = model.reduced.frequency
        self.reset()

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self.outputs()["time"]

    def reset(self, time: float = 0.0, amplitude: ArrayLike = 0.0) -> None:
        """Start anew at `time` with complex amplitudes (modes,), contacts at rest.

        The inputs stay as they are.

        Raises
        ------
        SlipmodeError
            If the time or an amplitude is not finite, or outside the friction table.
        """
        given = np.atleast_1d(np.asarray(amplitude, dtype=complex))
        if given.ndim > 1 or np.any(given[self.model.modes :]):
            raise SlipmodeError(f"amplitude: the model has {self.model.modes} modes, got {given}")
        given = given[: self.model.modes]
        for name, value in (("time", time), ("amplitude", given)):
            if not np.all(np.isfinite(value)):
                raise SlipmodeError(f"{name}: must be finite, got {value}")
        start = np.zeros(_kernel.MODES, dtype=complex)
        start[: given.size] = given
        status = _kernel.lib.sm_component_reset(self._handle, time, start.ctypes.data)
        if status == _kernel.OUTSIDE_TABLE:
            raise SlipmodeError(
                f"amplitude: {np.abs(given)} is outside the friction table, whose limit is "
                f"{self._inputs['limit_scale'][0] * self.model.table.limit}"
            )
        _kernel.check(status, "reset")

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; the others keep their values.

        Raises
        ------
        SlipmodeError
            If a name is unknown, a value not finite or a frequency not positive.
        """
        changed = self._inputs.copy()
        for name, value in values.items():
            if name not in self.input_names:
                raise SlipmodeError(f"{name}: {self._why_not(name)}")
            self._column(changed, name)[:] = value
        if refusal := self._refusal(changed):
            raise SlipmodeError(refusal)
        scaled = self._scaled(changed)
        _kernel.check(
            _kernel.lib.sm_component_set_inputs(self._handle, scaled.ctypes.data), "inputs"
        )
        self._inputs = changed

    def do_step(self, time: float, duration: float) -> None:
        """Advance from `time`, where the component must stand, by `duration` > 0 [s].

        Raises
        ------
        StoppedError
            If the step cannot be taken; the message says why.
        """
        now = self.time
        if not abs(time - now) <= 1e-9 * max(1.0, abs(now)):
            raise SlipmodeError(f"time: the component stands at {now:g} s, not at {time:g} s")
        status = _kernel.lib.sm_component_step(self._handle, duration)
        if status != _kernel.OK:
            none = np.empty((0, len(self.output_names)))
            raise self._stopped(status, duration, self._inputs, none)
        self._inputs = _moved_on(self._inputs, duration)

    def outputs(self) -> dict[str, float]:
        """Outputs at the present time, by name."""
        values = np.empty(len(self.output_names))
        _kernel.check(
            _kernel.lib.sm_component_outputs(self._handle, values.ctypes.data), "outputs"
        )
        return dict(zip(self.output_names, values.tolist(), strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Many steps in one call.

        Parameters
        ----------
        durations : (steps,) ndarray
            Length of each step [s].
        inputs : (steps, inputs) ndarray
            Inputs at the start of each step, in the order of `input_names`.

        Returns
        -------
        (steps, outputs) ndarray
            In the order of `output_names`.

        Raises
        ------
        StoppedError
            If a step cannot be taken; it carries the outputs up to there.
        SlipmodeError
            If the arrays have other shapes.
        """
        lengths, values = _kernel.contiguous(durations), np.asarray(inputs, dtype=float)
        expected = (lengths.size, len(self.input_names))
        if lengths.ndim != 1 or values.shape != expected:
            raise SlipmodeError(f"inputs: must have shape {expected}, got {values.shape}")
        packed = _kernel.inputs(lengths.size)
        for column, name in enumerate(self.input_names):
            self._column(packed, name)[:] = values[:, column]
        scaled = self._scaled(packed)
        outputs = np.empty((len(lengths), len(self.output_names)))
        done = ctypes.c_size_t()
        status = _kernel.lib.sm_component_run(
            self._handle,
            *(len(lengths), lengths.ctypes.data, scaled.ctypes.data, outputs.ctypes.data),
            ctypes.byref(done),
        )
        if done.value:
            last = done.value - 1
            self._inputs = _moved_on(packed[last : last + 1], float(lengths[last]))
        if status != _kernel.OK:
            failed = packed[done.value : done.value + 1]
            stop = self._stopped(status, float(lengths[done.value]), failed, outputs[: done.value])
            own = self._scaled(self._inputs)
            _kernel.lib.sm_component_set_inputs(self._handle, own.ctypes.data)
            raise stop
        return outputs

    def get_state(self) -> Floats:
        """Everything that continues the run, as an array that `set_state` takes."""
        state = np.empty(_kernel.lib.sm_component_state_count(self._handle))
        _kernel.check(_kernel.lib.sm_component_get_state(self._handle, state.ctypes.data), "state")
        return np.concatenate((state, self._inputs.view(float).ravel()))

    def set_state(self, state: Floats) -> None:
        """Continue from a state of this component, or of another of the same model."""
        given = _kernel.contiguous(state)
        count = _kernel.lib.sm_component_state_count(self._handle)
        own = self._inputs.view(float).size
        if given.shape != (count + own,):
            raise SlipmodeError(f"state: must have {count + own} entries, got {given.size}")
        if not np.isfinite(given).all():
            raise SlipmodeError("state: must be finite")
        _kernel.check(_kernel.lib.sm_component_set_state(self._handle, given.ctypes.data), "state")
        self._inputs = given[count:].copy().view(_kernel.INPUTS)

    def work(self) -> tuple[int, int]:
        """Accepted and rejected internal steps since creation."""
        accepted, rejected = ctypes.c_uint64(), ctypes.c_uint64()
        _kernel.lib.sm_component_work(self._handle, ctypes.byref(accepted), ctypes.byref(rejected))
        return accepted.value, rejected.value

    def _column(self, inputs: np.ndarray, name: str) -> Floats:
        """Where inputs (n,) hold an input, (n,)."""
        if name in _kernel.SCALE_FIELDS:
            scales: Floats = inputs[name]
            return scales
        quantity, mode = name.rsplit("_", 1)
        of_mode: Floats = inputs[quantity][:, self._mode_names.index(mode)]
        return of_mode

    def _why_not(self, name: str) -> str:
        """Why a name is not an input."""
        if name not in _kernel.SCALE_FIELDS:
            return f"not an input; inputs are {', '.join(self.input_names)}"
        return (
            "only the Coulomb law scales with its limit, for the tanh law has a velocity alpha "
            "besides; tabulate a model with the other limit"
        )

    def _scaled(self, inputs: np.ndarray) -> np.ndarray:
        """Inputs with forces in newtons turned into modal forces."""
        scaled = inputs.copy()
        for name in ("force", "force_rate"):
            scaled[name] *= self._force_factor
        return scaled

    def _refusal(self, inputs: np.ndarray) -> str:
        """Why inputs (1,) are refused, naming one; "" if they are not."""
        for name in self.input_names:
            value = self._column(inputs, name)[0]
            if not np.isfinite(value):
                return f"{name}: must be finite, got {value:g}"
            if name.rpartition("_")[0] == "frequency" and value <= 0:
                return f"{name}: must be > 0 rad/s, got {value:g}"
            if name == "limit_scale" and value <= 0:
                return f"{name}: must be > 0, got {value:g}"
        return ""

    def _stopped(
        self, status: int, duration: float, inputs: np.ndarray, outputs: Floats
    ) -> StoppedError:
        now = self.outputs()
        reason = _kernel.message(status)
        if not (np.isfinite(duration) and duration > 0):
            reason = f"step: must be finite and > 0 s, got {duration:g}"
        elif refusal := self._refusal(inputs):
            reason = refusal
        elif refusal := self._refusal(_moved_on(inputs, duration)):
            reason = f"{refusal} at the end of the step"
        elif status == _kernel.OUTSIDE_TABLE:
            reason = self._departure(duration)
        message = f"stopped at t = {now['time']:g} s: {reason}"
        return StoppedError(message, now["time"], outputs, status == _kernel.OUTSIDE_TABLE)

    def _departure(self, duration: float) -> str:
        """Which amplitude leaves the table during a step, and when, found by bisection."""
        state = self.get_state()
        for _ in range(40):
            duration *= 0.5
            _kernel.lib.sm_component_step(self._handle, duration)  # refused where it would leave
        last = self.outputs()
        self.set_state(state)
        reached = [np.hypot(last[f"{m}_re"], last[f"{m}_im"]) for m in self._mode_names]
        scale = _moved_on(self._inputs, last["time"] - self.time)["limit_scale"][0]
        limit = scale * self.model.table.limit
        mode = int(np.argmax(reached[: self.model.modes] / limit))
        return (
            f"amplitude |{self._mode_names[mode]}| leaves the friction table, whose limit is "
            f"{limit[mode]:g} kg^0.5 m, at t = {last['time']:g} s; "
            "tabulate a larger range or lower the force"
        )


def _moved_on(inputs: np.ndarray, duration: float) -> np.ndarray:
    """Inputs after they moved at their rates for `duration`."""
    later = inputs.copy()
    for name in (*_kernel.INPUT_QUANTITIES, "limit_scale"):
        later[name] += later[f"{name}_rate"] * duration
    return later


def present_modes(model: Model, mode_names: Sequence[str]) -> tuple[str, ...]:
    """What the model's modes are called; names past their number are left out."""
    present = tuple(mode_names)[: model.modes]
    if len(set(present)) < model.modes or not set(present) <= set(MODE_NAMES):
        raise SlipmodeError(f"mode_names: must be distinct, of A and B, got {present}")
    return present


def _output_names(
    model: Model, mode_names: Sequence[str], contact: bool, elastic: Sequence[int]
) -> tuple[str, ...]:
    names = ["time", *(f"{mode}_{part}" for mode in mode_names for part in ("re", "im"))]
    names += [f"theta_{mode}" for mode in mode_names]
    names += ["input_power", "dissipated_power", "dissipated_energy"]
    if contact:
        contacts = range(model.reduced.n_contacts)
        names += [f"contact_{i}_{quantity}" for quantity in "xvf" for i in contacts]
        names += [f"x_{dof}" for dof in elastic]
    return tuple(names)


def force_factors(model: Model, force: Sequence[Mapping[int, float] | ArrayLike] | None) -> Floats:
    """Modal force per unit of the force input, (MODES,)."""
    factors = np.ones(_kernel.MODES)
    if force is not None:
        if len(force) != model.modes:
            raise SlipmodeError(f"force: needs one entry per mode ({model.modes})")
        for mode, pattern in enumerate(force):
            factors[mode] = model.reduced.modal_force(mode, pattern)
    return factors


def _create(
    model: Model,
    force: Sequence[Mapping[int, float] | ArrayLike] | None,
    contact: bool,
    elastic: Sequence[int],
    tolerance: float,
) -> ctypes.c_void_p:
    """The core's component, freed with the handle's owner."""
    motion = _kernel.Motion(
        steps_per_period=STEPS_PER_PERIOD,
        memory_periods=MEMORY_PERIODS,
    )
    if contact:
        plane = answer_plane(model, elastic)
        contacts_out = _kernel.contiguous(model.reduced.contact_shapes[list(elastic)])
        motion.wanted, motion.elastic = 1, len(elastic)
        motion.modes_out = plane.modes_out.ctypes.data
        motion.contacts_out = contacts_out.ctypes.data
        motion.orders_count = len(plane.orders)
        motion.orders = plane.orders.ctypes.data
        motion.pull, motion.answer = plane.pull.ctypes.data, plane.elastic.ctypes.data
    flow = slow_flow(model, force)
    problem = contact_problem(model.reduced, model.law)
    handle = ctypes.c_void_p()
    status = _kernel.lib.sm_component_create(
        *(ctypes.byref(flow), ctypes.byref(problem), ctypes.byref(motion), tolerance),
        ctypes.byref(handle),
    )
    _kernel.check(status, "component")
    weakref.finalize(handle, _kernel.lib.sm_component_free, handle.value)
    return handle
