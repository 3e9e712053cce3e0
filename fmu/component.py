"""The step-able component, FMU style: set inputs, step, read outputs.

Variables are named <quantity>_<mode>, mode A or B:

inputs    force [N], frequency [rad/s], phase [rad], and force_rate, frequency_rate, phase_rate
          per second; also limit_scale, the friction limits and preloads relative to the model's,
          and limit_scale_rate, unless the law has a parameter that does not scale with them: the
          velocity of tanh, a gap
outputs   time; A_re, A_im, B_re, B_im; theta_A, theta_B (carrier angles);
          input_power, dissipated_power [W], dissipated_energy [J] (mean over the fast cycles, at
          the contacts); with contact motion also contact_<i>_x, _v, _f and x_<dof>

From rest an amplitude may start at a value other than 0 although no force is near its mode: the
force of the other mode moves it off resonance, and when that force sets in, the free vibration
that cancels this response is part of the amplitude. x_<dof> contains both, and starts at 0.

An input holds its value, and moves at its rate, until it is set again; so sweeps are exact and
continuous in phase whatever the step.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.fmu.handle import ComponentOptions, create_component, takes
from slipmode.fmu.inputs import AnyModel, Inputs, limit_scale, moved_on
from slipmode.fmu.outputs import checked_findings, output_names
from slipmode.fmu.stepping import StoppedError
from slipmode.rom import Model, SlipmodeError, kernel, sample_of
from slipmode.rom.arrays import Complexes, Floats, as_complexes, as_floats, as_number
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns, phasor
from slipmode.rom.slow.slow_flow import rates, slow_flow
from slipmode.rom.slow.tone.tone_flow import NOT_CONVERGED
from slipmode.rom.slow.transient import TransientError
from slipmode.rom.table.hermite import outside_table
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.validity import warn

_TRACED_ROWS = 4096  # outputs in memory together


class Component:
    """Step a model in slow time, with forces as inputs and amplitudes as outputs.

    Parameters
    ----------
    model : Model or ToneModel
        Model from `rom.tabulate`, `rom.model_of_rates` or an identification.
    force_patterns : sequence of {DOF: amplitude} or (n,) array_like, one per mode, optional
        Forces [N] for a force input of 1 N. Default: the input is the modal force [N kg^-1/2].
        Modes that share a tone need one per tone, [{DOF: amplitude}], possibly complex.
    contact : bool, default False
        Add the contact motion to the outputs. The model must store harmonics,
        `rom.tabulate(..., harmonics=5)`, except in the formulation "paper".
    elastic : sequence of int
        DOFs whose displacement is an output; needs `contact`.
    mode_names : sequence of str, default ("A", "B")
        Names of the modes; ("B",) if the model has only mode B.
    tolerance : float, default 1e-6
        Relative tolerance of the slow flow in each internal step [-], 1e-13 to 1e-2.
    sample : int, default 0
        Sample of the model whose rates are used, see `rom.sample_of`; 0 is the model itself.
    warned : bool, default True
        Warn of violated assumptions.

    Attributes
    ----------
    input_names : tuple of str
        "force_A" [N] or [N kg^-1/2], "frequency_A" [rad/s], "phase_A" [rad], and "limit_scale" [-]
        if the friction law scales. Each input has a rate, such as "force_rate_A" [N/s]. B has the
        corresponding inputs; modes that share a tone have one force, A, or A and B on two tones.
    output_names : tuple of str
        "time" [s]; "A_re", "A_im" [kg^1/2 m]; "theta_A" [rad]; "input_power", "dissipated_power"
        [W]; "dissipated_energy" [J]. With `contact` also "contact_0_x" [m], "contact_0_v" [m/s]
        and "contact_0_f" [N] for each contact DOF. With `elastic` also "x_0" [m] for each DOF.
        Modes that share a tone are A, A2, A3, ..., and B, B2, ... of another tone. Their motion is
        that at the forcing frequencies.

    Raises
    ------
    SlipmodeError
        If an argument is not allowed. If the table does not include the quasi-static response of
        the contacts to these forces, and the resulting amplitude error exceeds its tolerance.

    Warns
    -----
    ValidityWarning
        If contacts or friction violate an assumption of the method at the largest amplitudes of
        the table, or a modal frequency is implausible. Once if a frequency input is far from its
        mode.

    Notes
    -----
    Contact motion is integrated when outputs are read, from the previous reading or over the last
    few periods. In the consistent formulation the modes respond to the harmonics of the contacts.
    This response is computed at the carriers of the model, which should be the forcing
    frequencies. Modes that share a tone start from rest, at forcing frequencies within 10 % of the
    middle of their frequencies.

    Examples
    --------
    >>> model = rom.model_of_rates(lambda r: (0.5 + 0 * r, 100.0 + 0 * r), amplitude=[0.1])
    >>> component = fmu.Component(model, [{0: 1.0}], mode_names=("A",))
    >>> component.set_inputs(force_A=1.0, frequency_A=100.0)
    >>> component.do_step(0.0, 10.0)
    >>> round(component.outputs()["A_im"], 5)
    -0.00497
    """

    @takes(ComponentOptions)
    def __init__(
        self, model: AnyModel, force_patterns: ForcePatterns | None = None, **options: Any
    ) -> None:
        chosen, last = ComponentOptions(**options), model.reduced.n_dofs - 1
        if not all(0 <= dof <= last for dof in chosen.elastic):
            raise SlipmodeError(f"elastic: DOFs must be 0 to {last}, got {list(chosen.elastic)}")
        self.model = sampled = sample_of(model, chosen.sample)
        self._force_patterns = force_patterns
        self._named = Inputs(model, force_patterns, chosen.mode_names)
        self.input_names = self._named.names
        self.output_names = output_names(model, self._named, chosen)
        self._slow_count = max(kernel.OUTPUTS_FIXED, len(self.output_names))
        self._handle = create_component(sampled, force_patterns, chosen)
        self._inputs = self._named.at_rest
        self.reset()
        self._check_frequencies = chosen.warned
        if chosen.warned:
            warn(checked_findings(model, force_patterns, self._named.mode_names))

    @property
    def time(self) -> float:
        """Present time [s]."""
        return float(self._slow_outputs("time")[0])

    def reset(self, time: float = 0.0, amplitude: ArrayLike = 0.0) -> None:
        """Set time and amplitudes, with the contacts at rest.

        The inputs keep their values.

        Parameters
        ----------
        time : float, default 0.0
            Time [s].
        amplitude : (modes,) array_like, default 0.0
            Complex amplitudes a_j [kg^1/2 m].

        Raises
        ------
        SlipmodeError
            If the time or an amplitude is not finite, or an amplitude is outside the friction
            table.
        """
        time, given = as_number("time", time), np.atleast_1d(as_complexes("amplitude", amplitude))
        if not isfinite(time):
            raise SlipmodeError(f"time: must be finite, got {time}")
        if isinstance(self.model, ToneModel):
            if given.any():
                raise SlipmodeError("amplitude: must be 0; modes that share a tone start at rest")
            kernel.check(self._handle.reset(time), "reset")
            return
        start, modes = np.zeros(kernel.MODES, dtype=complex), self.model.modes
        too_many = given.size > modes and (given.size > start.size or given[modes:].any())
        if given.ndim > 1 or too_many:
            raise SlipmodeError(f"amplitude: must be at most {modes} numbers, got {given}")
        start[: given.size] = given
        status = self._handle.reset(time, start)
        if status == kernel.OK:
            return
        if not np.isfinite(start).all():
            raise SlipmodeError(f"amplitude: must be finite, got {given}")
        if status == kernel.OUTSIDE_TABLE:
            scale = limit_scale(self._inputs)
            raise outside_table(np.abs(start[:modes]), self.model.table, scale)
        kernel.check(status, "reset")

    def set_amplitude(self, amplitude: Complexes) -> None:
        """Set the amplitudes at the present time.

        Parameters
        ----------
        amplitude : (modes,) complex ndarray
            Amplitudes a_j [kg^1/2 m].

        Raises
        ------
        SlipmodeError
            If an amplitude is not finite, or outside the friction table.
        """
        self._two_modes("set_amplitude")
        given = np.zeros(kernel.MODES, dtype=complex)
        given[: self.model.modes] = as_complexes("amplitude", amplitude)
        status = self._handle.set_amplitude(given)
        kernel.check(status, "amplitude")

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; other inputs keep their values.

        Parameters
        ----------
        **values : float
            Values by name of the input, for instance force_A=0.15 [N].

        Raises
        ------
        SlipmodeError
            If a name is unknown or a value is not finite. If a frequency is outside the range of
            its mode, or equal to the frequency of the other mode.
        """
        changed = self._inputs.copy()
        for name, value in values.items():
            changed[0, self._named.column(name)] = as_number(name, value)
        if refusal := self._named.refusal(changed):
            raise SlipmodeError(refusal)
        scaled = self._named.modal(changed)
        status = self._handle.set_inputs(scaled)
        kernel.check(status, "inputs")
        self._inputs = changed
        if not self._named.natural.keys().isdisjoint(values):
            self._warn_of_frequencies(changed)

    def do_step(self, time: float, duration: float) -> None:
        """Advance by one communication step.

        Parameters
        ----------
        time : float
            Present time of the component [s].
        duration : float
            Length of the step [s], > 0.

        Raises
        ------
        StoppedError, SlipmodeError
            If the step is not possible, or `time` is not the present time.
        """
        now, time, duration = self.time, as_number("time", time), as_number("step", duration)
        if not abs(time - now) <= 1e-9 * max(1.0, abs(now)):
            raise SlipmodeError(
                f"time: must be the present time of the component, {now:g} s, got {time:g} s"
            )
        later = moved_on(self._inputs, duration)
        status = kernel.BAD_ARGUMENT
        if later is self._inputs or not self._named.refusal_later(self._inputs, later):
            status = self._handle.step(duration)
        if status != kernel.OK:
            none = np.empty((0, len(self.output_names)))
            raise self._stopped(status, np.array([duration]), self._inputs, none)
        if later is not self._inputs:
            self._warn_of_frequencies(later)
        self._inputs = later

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the present time.

        Returns
        -------
        dict of str to float
            Values by name, in the order of `output_names`.
        """
        values = np.empty(len(self.output_names))
        kernel.check(self._handle.outputs(values), "outputs")
        return dict(zip(self.output_names, values.tolist(), strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Advance by many communication steps in one call.

        Parameters
        ----------
        durations : (steps,) ndarray
            Length of each step [s].
        inputs : (steps, inputs) ndarray
            Inputs at the start of each step, in the order and units of `input_names`.

        Returns
        -------
        (steps, outputs) ndarray
            Outputs at the end of each step, in the order and units of `output_names`.

        Raises
        ------
        StoppedError, SlipmodeError
            If a step is not possible, or an array has a wrong shape. `StoppedError.outputs` has
            the outputs of the previous steps.
        """
        lengths, records, allowed = self._checked(durations, inputs)
        scaled = self._named.modal(records)
        outputs = np.empty((len(lengths), len(self.output_names)))
        arrays, done = (lengths, scaled, outputs), ctypes.c_size_t()
        status = self._handle.run(allowed, *arrays, ctypes.byref(done))
        k = done.value
        if k > 0:
            self._inputs = moved_on(records[k - 1 : k].copy(), float(lengths[k - 1]))
        self._warn_of_frequencies(records[:k])
        if status == kernel.OK and allowed < len(lengths):
            status = kernel.BAD_ARGUMENT
        if status != kernel.OK:
            raise self._stopped(status, lengths[k : k + 1], records[k : k + 1], outputs[:k])
        return outputs

    def trace(self, durations: Floats, inputs: Floats) -> Iterator[Floats]:
        """Advance by many communication steps, and yield the outputs after each internal step.

        Internal steps are short where the amplitudes change fast, and long where they are
        constant.

        Parameters
        ----------
        durations : (steps,) ndarray
            Length of each communication step [s].
        inputs : (steps, inputs) ndarray
            Inputs at the start of each step, in the order and units of `input_names`.

        Yields
        ------
        (rows, outputs) ndarray
            Outputs after further internal steps, in the order and units of `output_names`.

        Raises
        ------
        StoppedError, SlipmodeError
            If a step is not possible, or an array has a wrong shape. `StoppedError.outputs` has
            the outputs that were not yielded.
        """
        self._two_modes("trace")
        lengths, records, allowed = self._checked(durations, inputs)
        scaled = self._named.modal(records)
        trace, k = kernel.Trace(capacity=_TRACED_ROWS), 0
        while trace.done < lengths.size:
            outputs = np.empty((_TRACED_ROWS, len(self.output_names)))
            trace.outputs = outputs
            status = self._handle.trace(allowed, lengths, scaled, trace)
            before, k = k, trace.done
            self._warn_of_frequencies(records[before:k])
            if trace.elapsed > 0.0:
                self._inputs = moved_on(records[k : k + 1].copy(), trace.elapsed)
            elif k > 0:
                self._inputs = moved_on(records[k - 1 : k].copy(), float(lengths[k - 1]))
            if status == kernel.OK and k == allowed < lengths.size:
                status = kernel.BAD_ARGUMENT
            if status != kernel.OK:
                failed = self._inputs if trace.elapsed > 0.0 else records[k : k + 1]
                left = lengths[k : k + 1] - trace.elapsed
                raise self._stopped(status, left, failed, outputs[: trace.count])
            yield outputs[: trace.count]

    def get_state(self) -> Floats:
        """Return the complete state, for `set_state`.

        The state (n,) contains time, amplitudes, contact memory and inputs.
        """
        state = np.empty(self._handle.state_count())
        kernel.check(self._handle.get_state(state), "state")
        return np.concatenate((state, self._inputs.ravel()))

    def set_state(self, state: Floats) -> None:
        """Continue from a state of this component, or of another component of one model.

        Parameters
        ----------
        state : (n,) ndarray
            Result of `get_state`.

        Raises
        ------
        SlipmodeError
            If the array has a wrong size or is not finite.
        """
        given = kernel.contiguous(as_floats("state", state))
        count = self._handle.state_count()
        size = count + self._inputs.size
        if given.shape != (size,):
            raise SlipmodeError(f"state: must have {size} entries, got {given.size}")
        if not np.isfinite(given).all():
            raise SlipmodeError("state: must be finite")
        kernel.check(self._handle.set_state(given), "state")
        self._inputs = given[count:].reshape(1, -1).copy()

    def transient_error(self) -> Floats:
        """Return the estimated error of the present amplitudes due to transients.

        Friction after reversals is neglected in slow time, see "What is assumed" in
        docs/theory.md. Steady states do not have this error.

        Returns
        -------
        (modes,) ndarray
            Error of |a_j| [kg^1/2 m].
        """
        model = self._two_modes("transient_error")
        values = self._slow_outputs("transient error")
        modes = slice(0, model.modes)
        amplitude = values[1:5].view(complex)[np.newaxis, modes]
        inputs = self._named.modal(self._inputs).view(kernel.INPUTS).ravel()
        inputs["angle"][0] = values[5:7]
        rate = rates(slow_flow(model, self._force_patterns), inputs, amplitude)
        scale = limit_scale(self._inputs)
        if self._force_patterns is not None:
            shift = AppliedForces.of(model.reduced, self._force_patterns).shift
            amplitude = amplitude + shift * phasor(inputs["force"], inputs["phase"])[:, modes]
        estimate = TransientError.of(model.reduced, model.law)
        error = estimate.at(rate / scale, inputs["frequency"][:, modes], amplitude / scale)
        return np.asarray(scale * error[0])

    def work(self) -> tuple[int, int]:
        """Return the numbers of internal steps since the component was made.

        They are the accepted and the rejected steps, with errors below and above the tolerance.
        """
        accepted, rejected = ctypes.c_uint64(), ctypes.c_uint64()
        self._handle.work(ctypes.byref(accepted), ctypes.byref(rejected))
        return accepted.value, rejected.value

    def _two_modes(self, function: str) -> Model:
        """Return the model; refuse a function where modes share a tone."""
        if isinstance(self.model, ToneModel):
            raise SlipmodeError(f"{function}: is not available for modes that share a tone")
        return self.model

    def _slow_outputs(self, doing: str) -> Floats:
        values = np.empty(self._slow_count)
        status = self._handle.slow_outputs(values)
        kernel.check(status, doing)
        return values

    def _warn_of_frequencies(self, records: Floats) -> None:
        """Warn once of frequency inputs that are far from their mode."""
        if self._check_frequencies and (findings := self._named.findings(records)):
            self._check_frequencies = False
            warn(findings, stacklevel=4)

    def _checked(self, durations: Floats, inputs: Floats) -> tuple[Floats, Floats, int]:
        """Return lengths of steps, inputs at their starts as records, and the number allowed."""
        lengths = kernel.contiguous(as_floats("durations", durations))
        values = as_floats("inputs", inputs)
        expected = (lengths.size, len(self.input_names))
        if lengths.ndim != 1 or values.shape != expected:
            raise SlipmodeError(f"inputs: must have shape {expected}, got {values.shape}")
        records = self._named.records(values)
        return lengths, records, self._named.first_refused(records, lengths)

    def _stopped(self, status: int, left: Floats, inputs: Floats, outputs: Floats) -> StoppedError:
        """Return why a step failed, with these inputs in the core, and put back its own inputs.

        Or why the outputs after the last step cannot be computed; `left` may be empty then.
        """
        if np.isnan(outputs[-1:]).any():
            words = f"outputs at t = {self.time:g} s: {kernel.message(status)}"
            return StoppedError(words, self.time, outputs)
        duration = float(left[0])
        reason, outside = kernel.message(status), status == kernel.OUTSIDE_TABLE
        read = self._handle.slow_outputs(np.empty(self._slow_count))
        if status == kernel.NOT_CONVERGED and isinstance(self.model, ToneModel):
            reason = NOT_CONVERGED
        elif outside and read == kernel.OUTSIDE_TABLE:  # already at the start of the step
            reason = (
                f"limit_scale = {limit_scale(inputs):g} puts the amplitudes outside the friction "
                "table; tabulate a larger range"
            )
        elif not (np.isfinite(duration) and duration > 0):
            reason = f"step: must be finite and > 0 s, got {duration:g}"
        elif refusal := self._named.refusal(inputs) or self._named.refusal_later(
            inputs, moved_on(inputs, duration)
        ):
            reason = refusal
        elif outside:
            reason = self._departure(duration)
        own = self._named.modal(self._inputs)
        self._handle.set_inputs(own)
        words = f"stopped at t = {self.time:g} s: {reason}"
        return StoppedError(words, self.time, outputs, outside)

    def _departure(self, duration: float) -> str:
        """Return which amplitude leaves the table during a step, and when."""
        state, taken = self.get_state(), ctypes.c_double()
        advance = self._handle.advance
        while duration > 0.0:  # by internal steps, which become short near the edge
            if advance(duration, ctypes.byref(taken)) != kernel.OK:
                break
            duration -= taken.value
        last = self.outputs()
        self.set_state(state)
        reached = [np.hypot(last[f"{m}_re"], last[f"{m}_im"]) for m in self._named.mode_names]
        scale = limit_scale(moved_on(self._inputs, last["time"] - self.time))
        amplitude_range = scale * self.model.table.amplitude_range
        mode = int(np.argmax(reached[: self.model.modes] / amplitude_range))
        name = self._named.mode_names[mode]
        advice = "tabulate a larger range or lower the force"
        if self.model.reduced.modal_damping[mode] < 0.0:
            advice = f"mode {name} is self-excited; rom.limit_cycles computes the amplitude limits"
        return (
            f"amplitude |{name}| leaves the friction table, whose range is "
            f"{amplitude_range[mode]:g} kg^0.5 m, at t = {last['time']:g} s; {advice}"
        )
