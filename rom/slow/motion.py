"""Contact and elastic motion from the slow amplitudes, in two ways.

Marched: the contact problem (12) along the slow trajectory, with the reaction of the modal
response to its harmonics. Right at every corner of the motion; the cost is that of the time
marched.

Summed: the tabulated harmonics (14), each with the modal response to it. Any instant by itself, at
a cost that does not depend on the time between them; blind to what the harmonics leave out.

Friction forgets within a few periods, so either has any window without going through t = 0.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.nonresonant.response import ModalResponse, modal_response
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.table.model import Model

SPIN_UP_PERIODS = 10.0
_STEPS, _ELASTIC_STEPS = 128, 64


@dataclass(frozen=True, eq=False)
class Motion:
    """Fast motion at given times.

    Attributes
    ----------
    time : (n,) ndarray
        [s]
    displacement, velocity, force : (n, N_c) ndarray
        Of the contacts: x_c [m], x_c' [m/s], friction force [N].
    modal : (n, modes + nonresonant) ndarray
        Modal displacements q_j [kg^1/2 m], those of nonresonant modes last.
    load : (n, modes) ndarray
        Modal forces F_j cos(theta_j + phase_j) [N kg^-1/2].
    static : (n_dofs, modes) ndarray
        Displacement of the structure per unit of them that neither modes nor contacts have:
        ForceResponse.static.
    """

    time: Floats
    displacement: Floats
    velocity: Floats
    force: Floats
    modal: Floats
    load: Floats
    static: Floats

    __repr__ = short_repr

    def elastic(self, model: Model, dofs: Sequence[int]) -> Floats:
        """Displacement of DOFs of the structure, (n, dofs) [m]."""
        rows = list(dofs)
        shapes = model.reduced.all_shapes[rows], model.reduced.contact_shapes[rows]
        contacts = model.reduced.contacts
        moved = self.displacement
        if contacts is not None:  # they draw at the structure with what they lack in force
            moved = contacts.reference * self.displacement - self.force
        x = self.modal @ shapes[0].T + moved @ shapes[1].T
        return np.asarray(x + self.load @ self.static[rows].T)


def reconstruct(
    model: Model,
    trajectory: SlowTrajectory,
    times: ArrayLike,
    *,
    steps_per_period: int | None = None,
    spin_up: float = SPIN_UP_PERIODS,
) -> Motion:
    """Contact and modal motion at increasing times inside a slow trajectory, marched.

    Parameters
    ----------
    model : Model
    trajectory : SlowTrajectory
        Of that model.
    times : (n,) array_like
        [s]
    steps_per_period : int, optional
        Least number of time steps per period of the faster carrier. Default: 128, of elastic
        contacts, which have no motion of their own within a step, 64.
    spin_up : float
        Periods of the slower carrier, as it is at the times, marched before the first of them, at
        most from the trajectory's start, where the contacts rest.

    Raises
    ------
    SlipmodeError
        If the times are not increasing or lie outside the trajectory.
    """
    sample = _sample_times(trajectory, times)
    slowest = trajectory.between(sample[0], sample[-1]).frequency.min()
    part = trajectory.between(sample[0] - spin_up * 2 * np.pi / slowest, sample[-1])
    part = part.resolved(model)
    response = modal_response(model, part)
    reaction = np.ascontiguousarray(2.0 * response.reaction)
    segments = part.segments(model)
    effective = part.contact_segments(segments, reaction)
    shape = (sample.size, model.reduced.n_contacts)
    x, v, f = np.empty(shape), np.empty(shape), np.empty(shape)
    problem = contact_problem(model.reduced, model.law, response.orders)
    if steps_per_period is None:
        steps_per_period = _STEPS if model.reduced.contacts is None else _ELASTIC_STEPS
    samples = kernel.ContactSamples(
        sample.size, *(array.ctypes.data for array in (sample, x, v, f))
    )
    status = kernel.lib.sm_contact_motion(
        problem, len(effective), effective.ctypes.data, None, steps_per_period, samples
    )
    kernel.check(status, "contact motion")
    scale = part.scale_at(sample)[:, np.newaxis]
    x, v, f = scale * x, scale * v, scale * f
    coefficients = np.concatenate((response.modal, _loads(response, part)), axis=2)
    signals = _summed(segments, response, coefficients, _carriers(model, 0), sample)
    modal, load = np.split(signals, [response.modal.shape[2]], axis=1)
    return Motion(sample, x, v, f, modal, load, _static(model, part))


def sum_harmonics(model: Model, trajectory: SlowTrajectory, times: ArrayLike) -> Motion:
    """Contact and modal motion at increasing times inside a slow trajectory, summed.

    `model.harmonics.truncation` says what is left out of the displacement. Velocity and force
    have corners, and miss more of them.

    Parameters
    ----------
    model : Model
    trajectory : SlowTrajectory
        Of that model.
    times : (n,) array_like
        [s]

    Raises
    ------
    SlipmodeError
        As `reconstruct`, and if the model keeps no harmonics.
    """
    if model.harmonics is None:
        raise SlipmodeError("harmonics: this model keeps none; tabulate it with harmonics=7")
    sample = _sample_times(trajectory, times)
    part = trajectory.between(sample[0], sample[-1]).resolved(model)
    response = modal_response(model, part)
    velocity = 1j * response.frequency[..., np.newaxis] * response.contact
    force = _friction_force(model, part, response)
    displacement = response.contact
    if model.reduced.contacts is not None:
        # what balances the lack of force is the displacement
        displacement, lack = force, displacement
        velocity = 1j * response.frequency[..., np.newaxis] * displacement
        force = model.reduced.contacts.reference * displacement - lack
    parts = (displacement, velocity, force, response.modal, _loads(response, part))
    coefficients = np.concatenate(parts, axis=2)
    contacts = model.reduced.n_contacts
    segments, shape = part.segments(model), _carriers(model, 3 * contacts)
    signals = _summed(segments, response, coefficients, shape, sample)
    x, v, f, modal, load = np.split(signals, np.cumsum([p.shape[2] for p in parts[:-1]]), axis=1)
    return Motion(sample, x, v, f, modal, load, _static(model, part))


def _sample_times(trajectory: SlowTrajectory, times: ArrayLike) -> Floats:
    sample = kernel.contiguous(times)
    first, last = trajectory.time[[0, -1]]
    if sample.size == 0 or not np.all(np.isfinite(sample)) or np.any(np.diff(sample) <= 0):
        raise SlipmodeError("times: must be finite and increasing, at least one")
    if sample[0] < first or sample[-1] > last + 1e-9 * (last - first):
        raise SlipmodeError(f"times: must lie within the run, {first:g} to {last:g} s")
    return sample


def _carriers(model: Model, before: int) -> Floats:
    """Which signals have a carrier, (modes, signals).

    `before` of them have none, then come the modal displacements and the loads.
    """
    signals = before + model.reduced.all_shapes.shape[1] + model.modes
    return np.eye(model.modes, signals, before)


def _loads(response: ModalResponse, part: SlowTrajectory) -> Complexes:
    """Harmonics of the modal forces (points, orders, modes): that of its carrier for each."""
    loads = np.zeros((*response.contact.shape[:2], part.force.shape[1]), dtype=complex)
    for j, own in enumerate(CARRIERS[: loads.shape[2]]):
        if own in response.orders:
            loads[:, response.orders.index(own), j] = 0.5 * part.point_force[:, j]
    return loads


def _static(model: Model, part: SlowTrajectory) -> Floats:
    nothing = np.zeros((model.reduced.n_dofs, model.modes))
    return part.force_response.static if part.force_response else nothing


def _friction_force(model: Model, part: SlowTrajectory, response: ModalResponse) -> Complexes:
    """Harmonics of the friction force (points, orders, N_c): it balances all others, Eq. (12)."""
    reduced, nu = model.reduced, response.frequency[..., np.newaxis]
    P = response.contact
    force = response.reaction - P @ reduced.stiffness - 1j * nu * (P @ reduced.damping)
    force += nu**2 * (P @ reduced.mass)
    effective = part.effective(model)
    for j, own in enumerate(CARRIERS[: model.modes]):
        force[:, response.orders.index(own)] -= reduced.coupling[j] * effective[:, j, np.newaxis]
    return np.asarray(force)


def _summed(
    segments: np.ndarray,
    response: ModalResponse,
    coefficients: Complexes,
    shape: Floats,
    times: Floats,
) -> Floats:
    """Signals 2 Re(shape^T a exp(i theta) + sum_nm c_nm exp(i (n theta_A + m theta_B))).

    coefficients (points, orders, signals), shape (modes, signals); returns (times, signals).
    """
    by_signal = coefficients.transpose(0, 2, 1)
    rows = kernel.contiguous(np.stack((by_signal.real, by_signal.imag), axis=2))
    orders = np.ascontiguousarray(response.orders, dtype=np.int32)
    weights = kernel.contiguous(shape)
    harmonic_sum = kernel.HarmonicSum(
        modes=len(weights),
        orders_count=len(response.orders),
        orders=orders.ctypes.data,
        signals=weights.shape[1],
        shape=weights.ctypes.data,
        coefficient=rows.ctypes.data,
    )
    motion = np.empty((times.size, weights.shape[1]))
    status = kernel.lib.sm_harmonic_motion(
        ctypes.byref(harmonic_sum),
        len(segments),
        segments.ctypes.data,
        times.size,
        times.ctypes.data,
        motion.ctypes.data,
    )
    kernel.check(status, "sum of harmonics")
    return motion
