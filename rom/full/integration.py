"""Time integration of M x'' + C x' + K x + W g = f(t), g the forces on the contacts."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.coordinates import ModalCoordinates
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.motion import FullMotion, Record, State
from slipmode.rom.full.time_steps import Run, Schedule, checked_times
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.structure.structure import Structure

_SUBSTEPS = 4  # of one stage each, where contacts are elastic


def integrate(
    structure: Structure,
    law: Friction | Elastic,
    excitation: Excitation,
    times: ArrayLike,
    *,
    steps_per_period: float = 64,
    step: float | None = None,
    outputs: Sequence[int] | ArrayLike | None = None,
    start: State | None = None,
) -> FullMotion:
    """Integrate the full-order equations of motion.

    Parameters
    ----------
    structure : Structure
    law : Tanh or Coulomb, or an elastic law
        Jenkins, Iwan, Sliders, FrictionalContact or Contacts, on the structure with free contacts:
        their stiffness is not to be in the structure's.
    excitation : Excitation
    times : (samples,) array_like or float
        Increasing times of the samples, from the start on [s]; or the end, for a sample at every
        step. Evenly spaced times are the fastest.
    steps_per_period : float, default 64
        Least number of steps per period of the fastest forcing. On the two-mass structure with
        both modes slipping, 20 give the elastic displacements to 1e-3, those of the contacts to
        1e-2 and their velocities to 0.2; 64 give 5e-5, 1e-3 and 3e-2. Elastic contacts: 24 give
        the displacements of a blade with 12 Jenkins contacts to 5e-4, 64 to 1e-4.
    step : float, optional
        Largest time step [s], instead of `steps_per_period`. The steps are the longest ones not
        above it that fit between samples and starts of segments.
    outputs : sequence of int, or (outputs, n) array_like, optional
        DOFs whose displacement is wanted, or rows that combine them; all DOFs by default.
    start : State, optional
        Default: at rest, undeformed, where the excitation starts.

    Raises
    ------
    SlipmodeError
        If an argument does not fit, or the motion grows beyond all bounds.

    Notes
    -----
    The six-stage ESDIRK4(3)6L[2]SA of Kennedy and Carpenter [1]_: L-stable and of fourth order
    where the friction is smooth over a step; about second order under exact Coulomb friction,
    where a step may hold a transition from stick to slip. Each stage is a convex minimisation
    over the contact velocities, so that a step cannot fail. The linear part is solved in modal
    coordinates: O(n N_c) a stage where the damping is modal, O(n^2) otherwise.

    Elastic contacts are return maps from what they remember at the start of a step to the
    displacement at its end. Each step consists of four of the trapezoidal rule (Newmark's average
    acceleration), one implicit solution each, O(n N_c); modes that turn by more than 1 rad in
    such a part follow by backward Euler and do not ring. The rule is prewarped [2]_: motion at
    the forcing frequencies is exact at any step, so that resonances do not move. Second order:
    by harmonics, and a step may hold a transition between stick, slip and gap. Sliders take
    energy at any step.

    References
    ----------
    .. [1] C. A. Kennedy, M. H. Carpenter, Additive Runge-Kutta schemes for
       convection-diffusion-reaction equations, Applied Numerical Mathematics 44 (2003).
    .. [2] A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, section 7.1: the
       bilinear transformation.
    """
    integrator = Integrator(structure, law, excitation, outputs, steps_per_period, step)
    return integrator.run(times, start)


class Integrator:
    """What several runs of one problem share; the parameters are those of `integrate`."""

    def __init__(
        self,
        structure: Structure,
        law: Friction | Elastic,
        excitation: Excitation,
        outputs: Sequence[int] | ArrayLike | None = None,
        steps_per_period: float = 64,
        step: float | None = None,
    ) -> None:
        if excitation.patterns.shape[1] != structure.n_dofs:
            raise SlipmodeError(
                f"excitation: patterns must have {structure.n_dofs} columns, one per DOF, "
                f"got {excitation.patterns.shape[1]}"
            )
        name, given = ("steps_per_period", steps_per_period) if step is None else ("step", step)
        if not (np.isfinite(given) and given > 0):
            raise SlipmodeError(f"{name}: must be a finite number > 0, got {given}")
        self.excitation = excitation
        self._structure = structure
        self._law = law
        if isinstance(law, Elastic):
            self._elastic = law.elements(structure.n_contacts).kernel()
            self._remembered = int(kernel.lib.sm_elastic_memory(ctypes.byref(self._elastic)))
            self._substeps = _SUBSTEPS
        else:
            self._limit = limits(law, structure.n_contacts)
            self._remembered, self._substeps = 0, 1
        self._output = _output_rows(outputs, structure.n_dofs)
        self._coordinates = ModalCoordinates.of(structure)
        self._inputs = excitation.inputs()
        self._steps_per_period = steps_per_period
        self._step = step

    def run(self, times: ArrayLike, start: State | None = None, refine: int = 1) -> FullMotion:
        """Integrate, every step divided by `refine`."""
        first = self._at_rest() if start is None else start
        time = checked_times(times, first.time, float(self.excitation.start[0]))
        longest = self._longest_step(float(time.max()))
        refine *= self._substeps
        schedule = Schedule.plan(time, first.time, longest, self.excitation.start, refine)
        state = self._pack(first)
        record = Record.empty(schedule.time.size, len(self._output), self._structure.n_contacts)
        row = 0
        if schedule.samples_start:
            self._sample_start(first, state, record)
            row = 1
        for run in schedule.runs:
            kept = record.rows(row, run.samples)
            self._march(run, state, kept if run.sampled else record.scratch())
            row += run.samples * run.sampled
        return FullMotion(
            time=schedule.time,
            displacement=record.displacement,
            velocity=record.velocity,
            contact_displacement=record.contact[:, 0],
            contact_velocity=record.contact[:, 1],
            contact_force=record.contact[:, 2],
            dissipated=record.dissipated,
            end=self._unpack(float(schedule.time[-1]), state),
            steps=sum(run.samples * run.every for run in schedule.runs),
        )

    def _longest_step(self, end: float) -> float:
        if self._step is not None:
            return self._step
        return 2 * np.pi / (self.excitation.fastest(end) * self._steps_per_period)

    def _at_rest(self) -> State:
        zero = np.zeros(self._structure.n_dofs)
        return State(float(self.excitation.start[0]), zero, zero)

    def _march(self, run: Run, state: Floats, record: Record) -> None:
        problem = self._coordinates.kernel(
            *(self._law, self.excitation.patterns, self._output, run.step),
            carriers=self.excitation.frequency[run.segment],
        )
        elapsed = run.begin - self.excitation.start[run.segment]
        samples = kernel.FullSamples(run.samples, run.every, *record.addresses())
        inputs = self._inputs[run.segment :].ctypes.data
        status = kernel.lib.sm_full_march(problem, inputs, elapsed, state.ctypes.data, samples)
        kernel.check(status, "full-order integration")

    def _pack(self, start: State) -> Floats:
        """Modal state, contact motion and dissipated energy as the core reads them."""
        x, v = (
            _state_vector(name, value, self._structure.n_dofs)
            for name, value in (("displacement", start.displacement), ("velocity", start.velocity))
        )
        W = self._structure.directions.T
        x_c, v_c = np.asarray(W @ x), np.asarray(W @ v)
        force, memory = self._contacts_at(start, x_c, v_c)
        to_modal = self._coordinates.to_modal
        return np.concatenate([to_modal @ x, to_modal @ v, x_c, v_c, force, [0.0], memory])

    def _contacts_at(self, start: State, x_c: Floats, v_c: Floats) -> tuple[Floats, Floats]:
        """Force on the contacts, and what they remember."""
        contacts = self._structure.n_contacts
        memory = np.zeros(self._remembered)
        if isinstance(self._law, Elastic):
            if start.contact_memory is not None:
                given = _state_vector("contact_memory", start.contact_memory, memory.size)
                memory = given.copy()
            x_c, force = kernel.contiguous(x_c), np.empty(contacts)
            status = kernel.lib.sm_elastic_force(
                *(ctypes.byref(self._elastic), contacts, x_c.ctypes.data),
                *(memory.ctypes.data, force.ctypes.data),
            )
            kernel.check(status, "forces on the contacts")
            return force, memory
        if start.contact_force is not None:
            return _state_vector("contact_force", start.contact_force, contacts), memory
        slope = self._law.alpha
        return self._limit * (np.tanh(v_c / slope) if slope > 0 else np.sign(v_c)), memory

    def _unpack(self, time: float, state: Floats) -> State:
        n, contacts = self._structure.n_dofs, self._structure.n_contacts
        shapes = self._coordinates.shapes
        q, v, _, force, _, memory = np.split(state, np.cumsum([n, n, 2 * contacts, contacts, 1]))
        remembered = memory.copy() if isinstance(self._law, Elastic) else None
        return State(time, shapes @ q, shapes @ v, force.copy(), remembered)

    def _sample_start(self, start: State, state: Floats, record: Record) -> None:
        record.displacement[0] = self._output @ start.displacement
        record.velocity[0] = self._output @ start.velocity
        n, contacts = self._structure.n_dofs, self._structure.n_contacts
        record.contact[0] = state[2 * n : 2 * n + 3 * contacts].reshape(3, -1)
        record.dissipated[0] = 0.0


def _output_rows(outputs: Sequence[int] | ArrayLike | None, n_dofs: int) -> Floats:
    """Rows (outputs, n) that act on the DOFs."""
    if outputs is None:
        return np.eye(n_dofs)
    given = np.asarray(outputs)
    if given.ndim == 1 and given.dtype.kind in "iu":
        if np.any((given < 0) | (given >= n_dofs)):
            raise SlipmodeError(f"outputs: DOFs must be 0 to {n_dofs - 1}, got {outputs}")
        rows: Floats = np.eye(n_dofs)[given]
        return rows
    if given.ndim != 2 or given.shape[1] != n_dofs or given.dtype.kind not in "iuf":
        raise SlipmodeError(f"outputs: must be DOFs, or rows of {n_dofs} numbers")
    return np.asarray(given, dtype=float)


def _state_vector(name: str, value: ArrayLike, size: int) -> Floats:
    vector = np.asarray(value, dtype=float)
    if vector.shape != (size,) or not np.all(np.isfinite(vector)):
        raise SlipmodeError(f"start.{name}: must be {size} finite numbers")
    return vector
