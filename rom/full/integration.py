"""Time integration of M x'' + C x' + K x + W g = f(t), g the forces on the contacts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.coordinates import ModalCoordinates
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.full.time_steps import Run, Schedule, checked_times
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.structure.structure import Structure


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
    """Return the motion of a structure by time integration of all equations of motion.

    Parameters
    ----------
    structure : Structure
        Structure with free contacts: its stiffness does not include the contacts.
    law : Tanh, Coulomb, or an elastic law
        Elastic laws are Jenkins, Iwan, Sliders, FrictionalContact and Contacts.
    excitation : Excitation
        Harmonic forces with amplitudes, frequencies and phases over time.
    times : (samples,) array_like or float
        Increasing times of the samples [s]. A number is the end, with a sample at every step.
        Evenly spaced times are the fastest.
    steps_per_period : float, default 64
        Smallest number of steps per period of the fastest forcing.
    step : float, optional
        Largest time step [s], instead of `steps_per_period`. Steps are the longest that divide
        the time between samples and starts of segments.
    outputs : sequence of int, or (outputs, n) array_like, optional
        DOFs whose displacement is returned, or rows that combine DOFs. Default: all DOFs.
    start : State, optional
        Initial state. Default: undeformed and at rest when the excitation starts.

    Returns
    -------
    FullMotion
        Displacements, velocities and contact forces at the samples, and the final state.

    Raises
    ------
    SlipmodeError
        If an argument is not allowed, or the motion grows without bound.

    Notes
    -----
    Rigid friction uses the L-stable six-stage method ESDIRK4(3)6L[2]SA (Kennedy and Carpenter). It
    is of fourth order for friction that is smooth over a step, and of about second order for exact
    Coulomb friction. Each stage is a convex minimisation over the contact velocities, which always
    has a solution. A stage costs O(n N_c) with modal damping, otherwise O(n^2).

    Elastic contacts are return maps. Each step has four substeps of the trapezoidal rule
    (Newmark's average acceleration), at a cost of O(n N_c). The rule is prewarped (Oppenheim and
    Schafer): motion at the forcing frequencies is exact at any step, other motion is of second
    order. Modes that turn by more than 1 rad in a substep use backward Euler and do not oscillate
    numerically.

    Relative errors on the two-mass structure with two slipping modes::

        steps_per_period   elastic displacement   contact displacement   contact velocity
        20                 1e-3                   1e-2                   0.2
        64                 5e-5                   1e-3                   3e-2

    On a blade with 12 Jenkins contacts, displacements have an error of 5e-4 with 24 steps and of
    1e-4 with 64 steps. `full.converged` measures the error of a given case.

    References
    ----------
    Kennedy, C. A., M. H. Carpenter, Additive Runge-Kutta schemes for
    convection-diffusion-reaction equations, Applied Numerical Mathematics 44 (2003).

    Oppenheim, A. V., R. W. Schafer, Discrete-Time Signal Processing, section 7.1: the bilinear
    transformation.

    Examples
    --------
    >>> structure = rom.two_mass()
    >>> excitation = full.Excitation.harmonic(structure, [{0: 0.15}], [0.98])
    >>> motion = full.integrate(structure, rom.Coulomb(2.0), excitation, [0.0, 50.0, 100.0])
    >>> motion.displacement.shape
    (3, 4)
    """
    integrator = Integrator(structure, law, excitation, outputs, steps_per_period, step)
    return integrator.run(times, start)


class Integrator:
    """One problem for several runs; the parameters are those of `integrate`."""

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
        self._elastic: kernel.Structure | None = None
        self._memory_size, self._substeps = 0, 1
        if isinstance(law, Elastic):
            self._elements = law.elements(structure.n_contacts)
            self._elastic = self._elements.kernel()
            self._memory_size = int(kernel.lib.sm_elastic_memory(self._elastic))
            self._substeps = 4  # of one stage each, per step
        else:
            limits(law, structure.n_contacts)  # refuses a wrong number of limits
        self._output = _output_rows(outputs, structure.n_dofs)
        middle = np.exp(np.log(excitation.frequency).mean(axis=0))
        self._coordinates = ModalCoordinates.of(structure, middle)
        self._inputs = excitation.inputs()
        self._steps_per_period = steps_per_period
        self._step = step

    def at_rest(self) -> State:
        """Return the undeformed state when the excitation starts."""
        zero = np.zeros(self._structure.n_dofs)
        return State(float(self.excitation.start[0]), zero, zero)

    def slowest_decay(self) -> float:
        """Return the rate of structural decay of the modes within an octave of the carriers [1/s].

        Of all modes if there is none; 0 for self-excited ones. Amplitudes decay by exp(-rate t).
        """
        of, carriers = self._coordinates, self.excitation.frequency
        near = of.squares >= (0.5 * carriers.min()) ** 2
        near &= of.squares <= (2.0 * carriers.max()) ** 2
        damping = of.damping if of.damping.ndim == 1 else np.diag(of.damping)
        return max(0.5 * float(damping[near if near.any() else slice(None)].min()), 0.0)

    def run(self, times: ArrayLike, start: State | None = None, refine: int = 1) -> FullMotion:
        """Integrate, every step divided by `refine`."""
        first = self.at_rest() if start is None else start
        time = checked_times(times, first.time, float(self.excitation.start[0]))
        longest = self._step
        if longest is None:
            fastest = self.excitation.fastest(float(time.max()))
            longest = 2 * np.pi / (fastest * self._steps_per_period)
        refine *= self._substeps
        schedule = Schedule.plan(time, first.time, longest, self.excitation.start, refine)
        state = self._pack(first)
        samples, outputs = schedule.time.size, len(self._output)
        n, contacts = self._coordinates.squares.size, self._structure.n_contacts
        displacement, velocity = np.empty((2, samples, outputs))
        contact, dissipated = np.empty((samples, 3, contacts)), np.empty(samples)
        record = (displacement, velocity, contact, dissipated)
        row = 0
        if schedule.samples_start:
            displacement[0] = self._output @ first.displacement
            velocity[0] = self._output @ first.velocity
            contact[0] = state[2 * n : 2 * n + 3 * contacts].reshape(3, -1)
            dissipated[0] = 0.0
            row = 1
        for run in schedule.runs:
            rows = slice(row, row + run.samples)
            unread = [np.empty_like(each[:1]) for each in record]
            self._march(run, state, [each[rows] for each in record] if run.sampled else unread)
            row += run.samples * run.sampled
        return FullMotion(
            time=schedule.time,
            displacement=displacement,
            velocity=velocity,
            contact_displacement=contact[:, 0],
            contact_velocity=contact[:, 1],
            contact_force=contact[:, 2],
            dissipated=dissipated,
            end=self._unpack(float(schedule.time[-1]), state),
            steps=sum(run.samples * run.every for run in schedule.runs),
        )

    def _march(self, run: Run, state: Floats, record: list[Floats]) -> None:
        """Advance the state through a run; the core writes its samples into the record."""
        segment = run.segment
        problem = self._coordinates.kernel(
            self._law,
            self.excitation.patterns,
            self._output,
            run.step,
            self.excitation.frequency[segment],
        )
        elapsed = run.begin - self.excitation.start[segment]
        samples = kernel.FullSamples(run.samples, run.every, *record)
        inputs = self._inputs[segment:]
        status = kernel.lib.sm_full_march(problem, inputs, elapsed, state, samples)
        kernel.check(status, "full-order integration")

    def _pack(self, start: State) -> Floats:
        """Return modal state, contact motion and force, dissipated energy and contact memory."""
        n = self._structure.n_dofs
        x = _state_vector("displacement", start.displacement, n)
        v = _state_vector("velocity", start.velocity, n)
        W = self._structure.directions.T
        x_c, v_c = np.asarray(W @ x), np.asarray(W @ v)
        memory = np.zeros(self._memory_size)
        if self._elastic is None:
            force = self._friction(start, v_c)
        else:
            if start.contact_memory is not None:
                memory = _state_vector("contact_memory", start.contact_memory, memory.size)
            (force,), memory = self._elements.march(x_c[np.newaxis], memory)
        to_modal = self._coordinates.to_modal
        return np.concatenate([to_modal @ x, to_modal @ v, x_c, v_c, force, [0.0], memory])

    def _friction(self, start: State, v_c: Floats) -> Floats:
        """Return the given force of rigid friction, or the law's force at velocities v_c."""
        if start.contact_force is not None:
            return _state_vector("contact_force", start.contact_force, v_c.size)
        assert not isinstance(self._law, Elastic)
        alpha = self._law.alpha
        return limits(self._law, v_c.size) * (np.tanh(v_c / alpha) if alpha > 0 else np.sign(v_c))

    def _unpack(self, time: float, state: Floats) -> State:
        contacts, shapes = self._structure.n_contacts, self._coordinates.shapes
        n = shapes.shape[1]
        q, v, _, force, _, memory = np.split(state, np.cumsum([n, n, 2 * contacts, contacts, 1]))
        kept = None if self._elastic is None else memory.copy()
        return State(time, shapes @ q, shapes @ v, force.copy(), kept)


def _output_rows(outputs: Sequence[int] | ArrayLike | None, n_dofs: int) -> Floats:
    """Return rows (outputs, n) that act on the DOFs."""
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
