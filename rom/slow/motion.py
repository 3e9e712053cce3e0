"""Contact and elastic motion from the slow amplitudes, in two ways.

`reconstruct` marches the contact problem (12) along the slow trajectory, with the reaction of the
modal response to its harmonics. It resolves every corner of the motion; the cost is proportional
to the time.

`sum_harmonics` sums the tabulated harmonics (14), each with the modal response to it. The cost is
proportional to the number of instants; the neglected harmonics are missing.

Friction forgets its past within a few periods, so both compute any window of a run by itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import CARRIERS, Order
from slipmode.rom.reduction.modes_alone import modes_alone
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.nonresonant.response import ModalResponse, modal_response
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.table.model import Model

SPIN_UP_PERIODS = 10.0
_ELASTIC_STEPS = 64  # steps per period: elastic contacts have no motion of their own within one


@frozen
class Motion:
    """Hold the fast motion of contacts and modes at given times.

    Attributes
    ----------
    time : (n,) ndarray
        Times [s].
    displacement, velocity, force : (n, N_c) ndarray
        Contact displacements x_c [m], velocities [m/s] and friction forces [N].
    modal : (n, modes + nonresonant) ndarray
        Modal displacements q_j [kg^1/2 m]; nonresonant modes are last. For travelling waves the
        coordinates of `Model.dof_response` follow.
    load : (n, modes) ndarray
        Modal forces F_j cos(theta_j + psi_j) [N kg^-1/2].
    static : (n_dofs, modes) ndarray
        Quasi-static displacement of each DOF per modal force [kg^1/2 m/N], without modes and
        contacts.
    """

    time: Floats
    displacement: Floats
    velocity: Floats
    force: Floats
    modal: Floats
    load: Floats
    static: Floats

    def elastic(self, model: Model, dofs: Sequence[int]) -> Floats:
        """Return the displacement of DOFs of the structure.

        Parameters
        ----------
        model : Model
            Model of the simulation.
        dofs : sequence of int
            Indices of the DOFs.

        Returns
        -------
        (n, dofs) ndarray
            Displacements x [m].
        """
        rows, reduced = list(dofs), model.reduced
        moved = self.displacement
        if reduced.contacts is not None:  # the contact shapes belong to the force deficit
            moved = reduced.contacts.reference * self.displacement - self.force
        x = self.modal @ model.all_shapes[rows].T + moved @ reduced.contact_shapes[rows].T
        return np.asarray(x + self.load @ self.static[rows].T)


def reconstruct(
    model: Model,
    trajectory: SlowTrajectory,
    times: ArrayLike,
    *,
    steps_per_period: int | None = None,
    spin_up: float = SPIN_UP_PERIODS,
) -> Motion:
    """Return the fast motion along a slow trajectory, by time integration of the contacts.

    The contact equation, source Eq. (12), is integrated with the amplitudes of the trajectory.

    Parameters
    ----------
    model : Model
        Model of the simulation.
    trajectory : SlowTrajectory
        Slow trajectory of this model.
    times : (n,) array_like
        Times of the samples [s], increasing, within the trajectory.
    steps_per_period : int, optional
        Smallest number of time steps per period of the faster carrier. Default: 128, or 64 for
        elastic contacts.
    spin_up : float, default 10.0
        Periods of the slower carrier that are integrated before the first sample. The start of the
        trajectory, where the contacts are at rest, limits them.

    Returns
    -------
    Motion
        Contact and modal motion at these times.

    Raises
    ------
    SlipmodeError
        If the times are not increasing, or outside the trajectory.

    Notes
    -----
    The response of the modes to harmonics of the contacts is included if the model stores
    harmonics (`harmonics` of `rom.tabulate`).
    """
    sample = _sample_times(trajectory, times)
    slowest = trajectory.between(sample[0], sample[-1]).frequency.min()
    part = trajectory.between(sample[0] - spin_up * 2 * np.pi / slowest, sample[-1])
    part = part.resolved(model)
    response = modal_response(model, part)
    reaction = np.ascontiguousarray(2.0 * response.reaction)
    segments = part.segments(model)
    effective = part.contact_segments(segments, reaction)
    if steps_per_period is None:
        steps_per_period = 128 if model.reduced.contacts is None else _ELASTIC_STEPS
    problem = contact_problem(model.reduced, model.law, response.orders)
    x, v, f = _integrated(problem, effective, steps_per_period, sample)
    scale = part.scale_at(sample)[:, np.newaxis]
    modal, load = _summed(model, part, response, [], segments, sample)
    return Motion(sample, scale * x, scale * v, scale * f, modal, load, _static(model, part))


def prescribed_motion(
    model: Model,
    trajectory: SlowTrajectory,
    law: Elastic,
    orders: Sequence[Order],
    displacement: Complexes,
    times: Floats,
) -> tuple[Floats, Floats, Floats]:
    """Return displacement, velocity and force of elastic contacts with prescribed displacement.

    The contact law is integrated along the trajectory, from its start.

    Parameters
    ----------
    model : Model
        Model of the simulation.
    trajectory : SlowTrajectory
        Slow trajectory of this model.
    law : elastic law
        Law of the contacts.
    orders : sequence of (n, m)
        Harmonics of the displacement.
    displacement : (steps + 1, orders, N_c) complex ndarray
        Harmonics c_nm of the displacement 2 Re(c_nm exp(i (n theta_A + m theta_B))) at the times
        of the trajectory [m].
    times : (n,) ndarray
        Increasing times of the samples within the trajectory [s].

    Returns
    -------
    displacement, velocity, force : (n, N_c) ndarray
        Contact displacements [m], velocities [m/s] and forces [N].
    """
    # No mode and no flexibility moves these contacts.
    frequency = model.reduced.frequency
    elements = law.elements(displacement.shape[2])
    alone = modes_alone(frequency, 0.0 * frequency, np.zeros((1, frequency.size)), elements)
    moved = np.ascontiguousarray(2.0 * displacement)
    segments = trajectory.contact_segments(trajectory.segments(model), moved)
    return _integrated(contact_problem(alone, law, orders), segments, _ELASTIC_STEPS, times)


def sum_harmonics(model: Model, trajectory: SlowTrajectory, times: ArrayLike) -> Motion:
    """Return the fast motion along a slow trajectory, by a sum of tabulated harmonics.

    The contacts are not integrated in time. `rom.reconstruct` integrates them.

    Parameters
    ----------
    model : Model
        Model that stores harmonics, from `rom.tabulate` with `harmonics` > 0.
    trajectory : SlowTrajectory
        Slow trajectory of this model.
    times : (n,) array_like
        Times of the samples [s], increasing, within the trajectory.

    Returns
    -------
    Motion
        Contact and modal motion at these times.

    Raises
    ------
    SlipmodeError
        If the times are not increasing, or outside the trajectory. If the model stores no
        harmonics.

    Notes
    -----
    `model.harmonics.truncation` returns the error of the displacement. The errors of velocity and
    force, which have corners, are larger.
    """
    if model.harmonics is None:
        raise SlipmodeError("harmonics: this model has none; tabulate it with harmonics=7")
    sample = _sample_times(trajectory, times)
    part = trajectory.between(sample[0], sample[-1]).resolved(model)
    response = modal_response(model, part)
    displacement, force = response.contact, _friction_force(model, part, response)
    if model.reduced.contacts is not None:
        # In the dual problem `contact` is the force deficit, and the force the displacement.
        deficit, displacement = displacement, force
        force = model.reduced.contacts.reference * displacement - deficit
    velocity = 1j * response.frequency[..., np.newaxis] * displacement
    contact = [displacement, velocity, force]
    x, v, f, modal, load = _summed(model, part, response, contact, part.segments(model), sample)
    return Motion(sample, x, v, f, modal, load, _static(model, part))


def _integrated(
    problem: kernel.Structure, segments: np.ndarray, steps_per_period: int, times: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return displacement, velocity and force of the contacts (times, N_c), by time integration.

    `segments` are the result of `SlowTrajectory.contact_segments`.
    """
    x, v, f = (np.empty((times.size, problem.contacts)) for _ in range(3))
    if problem.contacts:
        sample = kernel.contiguous(times)
        samples = kernel.ContactSamples(sample.size, sample, x, v, f)
        status = kernel.lib.sm_contact_motion(
            problem, len(segments), segments, None, steps_per_period, samples
        )
        kernel.check(status, "contact motion")
    return x, v, f


def _sample_times(trajectory: SlowTrajectory, times: ArrayLike) -> Floats:
    sample = kernel.contiguous(times)
    first, last = trajectory.time[[0, -1]]
    if sample.size == 0 or not np.all(np.isfinite(sample)) or np.any(np.diff(sample) <= 0):
        raise SlipmodeError("times: must be finite and increasing, at least one")
    if sample[0] < first or sample[-1] > last + 1e-9 * (last - first):
        raise SlipmodeError(f"times: must lie within the run, {first:g} to {last:g} s")
    return sample


def _loads(response: ModalResponse, part: SlowTrajectory) -> Complexes:
    """Return harmonics of the modal forces (points, orders, modes): each at its carrier."""
    loads = np.zeros((*response.contact.shape[:2], part.force.shape[1]), dtype=complex)
    for j, own in enumerate(CARRIERS[: loads.shape[2]]):
        if own in response.orders:
            loads[:, response.orders.index(own), j] = 0.5 * part.point_force[:, j]
    return loads


def _static(model: Model, part: SlowTrajectory) -> Floats:
    nothing = np.zeros((model.reduced.n_dofs, model.modes))
    return part.force_response.static if part.force_response else nothing


def _friction_force(model: Model, part: SlowTrajectory, response: ModalResponse) -> Complexes:
    """Return harmonics of the friction force (points, orders, N_c), by the balance of Eq. (12)."""
    reduced, nu = model.reduced, response.frequency[..., np.newaxis]
    P = response.contact
    force = response.reaction - P @ reduced.stiffness - 1j * nu * (P @ reduced.damping)
    force += nu**2 * (P @ reduced.mass)
    effective = part.effective(model)
    for j, own in enumerate(CARRIERS[: model.modes]):
        force[:, response.orders.index(own)] -= reduced.coupling[j] * effective[:, j, np.newaxis]
    return np.asarray(force)


def _summed(
    model: Model,
    part: SlowTrajectory,
    response: ModalResponse,
    contact: Sequence[Complexes],
    segments: np.ndarray,
    times: Floats,
) -> list[Floats]:
    """Return signals at times: of the contacts, modal displacements, and loads; (times, ...) each.

    A signal is 2 Re(shape^T a exp(i theta) + sum_nm c_nm exp(i (n theta_A + m theta_B))) with
    coefficients c (points, orders, ...), which `contact` are for the contacts. Only modal
    displacements have carriers.
    """
    parts = [*contact, response.modal, _loads(response, part)]
    ends = np.cumsum([each.shape[2] for each in parts])
    weights = np.eye(model.modes, ends[-1], ends[-3] if contact else 0)
    by_signal = np.concatenate(parts, axis=2).transpose(0, 2, 1)
    rows = kernel.contiguous(np.stack((by_signal.real, by_signal.imag), axis=2))
    orders = np.ascontiguousarray(response.orders, dtype=np.int32)
    harmonic_sum = kernel.HarmonicSum(
        modes=len(weights),
        orders_count=len(response.orders),
        orders=orders,
        signals=weights.shape[1],
        shape=weights,
        coefficient=rows,
    )
    motion = np.empty((times.size, weights.shape[1]))
    status = kernel.lib.sm_harmonic_motion(
        harmonic_sum,
        len(segments),
        segments,
        times.size,
        times,
        motion,
    )
    kernel.check(status, "sum of harmonics")
    return np.split(motion, ends[:-1], axis=1)
