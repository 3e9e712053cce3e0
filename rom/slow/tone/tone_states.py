"""Steady states of several modes on one or two tones, and transients.

A steady state with local contacts is put into the equations of all contacts together, solved
there, and put into these equations again with twice the time steps and harmonics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import carrier_findings, check_carrier
from slipmode.rom.kernel import Structure
from slipmode.rom.reduction.combination import CARRIERS, Order, harmonic_orders
from slipmode.rom.reduction.force_response import phasor
from slipmode.rom.reduction.tones import check_two_carriers
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.tone.contact_balance import ContactBalance
from slipmode.rom.slow.tone.core_tone import core_tone
from slipmode.rom.slow.tone.coupled_contacts import LINES, CoupledContacts
from slipmode.rom.slow.tone.tone_flow import ToneFlow
from slipmode.rom.slow.tone.tone_modes import ToneModes
from slipmode.rom.slow.tone.tone_response import ToneResponse
from slipmode.rom.structure.force_vector import force_vectors
from slipmode.rom.table.local.local_contacts import LocalContacts
from slipmode.rom.table.local.tone_model import ToneModel, contacts_near
from slipmode.rom.validity import Finding, warn

ToneForce = Mapping[int, complex] | ArrayLike

# Error of amplitudes from rest relative to the share of stiffness due to contacts, 0.02 to 0.1,
# and to the response of a mode to a harmonic, 0.06 where that mode is at 1:3
# (tests/rom/slow/test_one_tone.py). Errors are reported beyond _LARGE.
_AVERAGING, _LARGE = 0.1, 0.01
# Motion of DOFs at combinations of two tones relative to contact motion there: 0.6 to 2.5 on
# drawn plates, whose errors in runs were these motions (tests/runner/scene/test_shared_tone.py).
_AT_DOFS = 2.5
_TINY = np.finfo(float).tiny
# Factor of the steps and harmonics of the contacts, on one tone and on two, whose phase lines and
# harmonics increase the work of each doubling by sixteen.
_FINEST = 8, 4
# Contact displacement by a mode at a harmonic of two tones, relative to the carriers', from which
# on Newton's method solves it, and most of these harmonics. On a plate with six harmonics above
# 0.003 the iteration of the torus took 300 periods, and 3 periods without them.
_LARGE_GAIN, _MOST_DRIVEN = 0.002, 20
# Error by the end of the search for a state, 1e-5, and by modes that follow statically, relative
# to the largest amplitude. Beams of 80 to 400 DOFs were within 2e-5 of harmonic balance.
# Under two tones the phase lines close with the ratio of frequencies to 1e-3 or less, and modes
# do not respond to the highest harmonics: drawn plates were within 8e-5 of time integration where
# all resolutions agree (tests/rom/slow/test_two_tones.py).
_CLOSEST = 3e-5, 2e-4


@frozen
class ToneState:
    """A steady state at the frequencies of all tones.

    Attributes
    ----------
    amplitude : (modes,) complex ndarray
        Of the retained modes, at the carrier of their tone [kg^1/2 m].
    error : (modes,) ndarray
        Of `amplitude` [kg^1/2 m].
    modal : (tones, modes + nonresonant) complex ndarray
        Amplitudes of all modes at each carrier [kg^1/2 m].
    deficit : (tones, N_c) complex ndarray
        Force deficits of the contacts at the carriers [N].
    at_harmonics : float
        Largest displacement of a contact at the harmonics of two tones that move modes, in sum,
        relative to that at the carriers [-].
    """

    amplitude: Complexes
    error: Floats
    modal: Complexes
    deficit: Complexes
    at_harmonics: float


@frozen
class ForcedTone:
    """A model under one force on each tone.

    Attributes
    ----------
    model : ToneModel
    responses : sequence of ToneResponse
        Of the same structure, one for each force.
    """

    model: ToneModel
    responses: Sequence[ToneResponse]

    @classmethod
    def of(
        cls, model: ToneModel, force: Sequence[ToneForce], phase: ArrayLike, frequency: Floats
    ) -> Self:
        """Return a model under its forces, at frequencies (points, tones) [rad/s], if allowed."""
        if not isinstance(model, ToneModel):
            raise SlipmodeError("model: must be of modes that share a tone (rom.reduce(tones=))")
        reduced, at = model.reduced, frequency
        if at.shape[1] != reduced.tones:
            raise SlipmodeError(
                f"frequency: must be one for each of {reduced.tones} tones, got {at.shape[1]}"
            )
        vectors = _complex_vectors(force, reduced.tones, reduced.n_dofs)
        angle = as_floats("phase", phase)
        if angle.size not in (1, reduced.tones) or not np.isfinite(angle).all():
            raise SlipmodeError(f"phase: must be a finite number [rad], got {in_one_line(phase)}")
        if not np.all(np.isfinite(at) & (at > 0.0)):
            raise SlipmodeError("frequency: must be finite and > 0 [rad/s]")
        middle = np.array([np.median(reduced.frequency[own]) for own in reduced.on_tones])
        for tone, each in zip("AB", range(reduced.tones), strict=False):
            check_carrier("frequency", tone, float(middle[each]), at[:, each])
        if reduced.tones == 2:
            check_two_carriers(at)
        warn(carrier_findings("frequency", "AB", middle, at), stacklevel=5)
        turned = phasor(vectors, angle.reshape(-1, 1))
        return cls(model, [ToneResponse(reduced, each) for each in turned])

    def steady(self, frequency: Floats) -> list[ToneState]:
        """Return steady states at frequencies (points, tones) [rad/s], in their order."""
        each = self._with_local_contacts(frequency)
        return [self._together(balance.frequency, x[0]) for balance, x, _ in each]

    def with_local_contacts(self, frequency: Floats) -> Complexes:
        """Return amplitudes (points, modes) with local contacts alone."""
        each = self._with_local_contacts(frequency)
        return np.array([self._amplitude(self._modal(at.frequency, y[0])) for at, _, y in each])

    def _with_local_contacts(
        self, frequency: Floats
    ) -> Iterator[tuple[ContactBalance, Complexes, Complexes]]:
        """Yield the balance, x and y (1, tones, N_c) at each frequency, from the x before."""
        x: Complexes | None = None
        for each in frequency:
            balance = self._balance(each, CARRIERS[: each.size])
            x, y = balance.with_local_contacts(x)
            yield balance, x, y

    def _modal(self, frequency: Floats, deficit: Complexes) -> Complexes:
        """Return the amplitudes of all modes at each carrier, see `ToneState`."""
        each = zip(self.responses, frequency.tolist(), deficit, strict=True)
        return np.array([response.modal(nu, y) for response, nu, y in each])

    def _amplitude(self, modal: Complexes) -> Complexes:
        """Return the amplitudes (modes,) of the retained modes, each at its own carrier."""
        own = zip(modal, self.model.reduced.on_tones, strict=True)
        return np.concatenate([each[modes] for each, modes in own])

    def flow(self, frequency: Floats, tolerance: float) -> ToneFlow:
        """Return the structure at rest, near reference frequencies (tones,) [rad/s]."""
        return ToneFlow(*self._parts(frequency), frequency, tolerance)

    def core(self, frequency: Floats, elastic: Sequence[int], contact: bool) -> Structure:
        """Return the core's structure near reference frequencies [rad/s], with outputs."""
        own = zip(self.responses, self.model.reduced.on_tones, strict=True)
        outputs = [each.outputs(modes, elastic, contact_motion=contact) for each, modes in own]
        return core_tone(*self._parts(frequency), frequency, outputs)

    def _parts(self, frequency: Floats) -> tuple[list[ToneModes], LocalContacts, Complexes]:
        """Return modes of each tone, contacts, and the own flexibilities of the contacts."""
        each = zip(self.responses, frequency.tolist(), strict=True)
        modes = [response.tone_modes(nu) for response, nu in each]
        near = zip(modes, frequency.tolist(), strict=True)
        own = np.array([np.diag(each.flexibility(nu)) for each, nu in near])
        return modes, contacts_near(self.model, frequency, own), own

    def transient_findings(self, frequency: Floats) -> list[Finding]:
        """Report that transients near frequencies (tones,) [rad/s] have large errors."""
        reduced, at = self.model.reduced, frequency[np.newaxis]
        assert reduced.contacts is not None
        squares = (reduced.frequency**2)[:, np.newaxis]
        share = float((reduced.spring**2 / squares @ reduced.contacts.reference).max())
        local, state = self.with_local_contacts(at)[0], self.steady(at)[0]
        off = np.abs(local - state.amplitude).max() / max(np.abs(local).max(), _TINY)
        gain = self.responses[0].harmonic_gain(frequency)
        error = float(_AVERAGING * (share + gain) + off + _AT_DOFS * state.at_harmonics)
        if error <= _LARGE:
            return []
        reason = (
            f"contacts have {percentage(share)} of the stiffness of a mode, their harmonics move "
            f"a mode by {percentage(gain)}, and the action of contacts on each other at "
            "harmonics, which transients neglect, changes steady states by "
            f"{percentage(float(off))}. Steady states (rom.steady) include it. Motion at "
            f"combinations of two frequencies is {percentage(state.at_harmonics)} of that at the "
            "frequencies, and neglected; compare transients with rom.full"
        )
        choice = f"have errors of about {percentage(error)}"
        return [Finding("transients", choice, reason, "warning")]

    def _driven(self, frequency: Floats) -> list[Order]:
        """Return the carriers, and harmonics of two tones that move the contacts through a mode.

        Newton's method solves the contacts there. Other harmonics are left to the iteration of
        the torus, which diverges with these.
        """
        carriers = list(CARRIERS[: frequency.size])
        if frequency.size == 1:
            return carriers
        orders = [
            each
            for each in harmonic_orders(LocalContacts.HIGHEST, 2)[2:]
            if 2 * abs(each[1]) < LINES
        ]
        gain = self.responses[0].mode_gain(orders, frequency)
        strongest = np.argsort(-gain, kind="stable")[:_MOST_DRIVEN]
        return carriers + [orders[k] for k in strongest if gain[k] > _LARGE_GAIN]

    def _balance(self, frequency: Floats, driven: Sequence[Order]) -> ContactBalance:
        nu = [float(np.dot(order[: frequency.size], frequency)) for order in driven]
        try:
            G = np.array([[self.responses[0].flexibility(each) for each in nu]])
            moved = np.zeros((1, len(nu), self.model.reduced.n_contacts), dtype=complex)
            for tone, response in enumerate(self.responses):
                moved[0, tone] = response.moved(nu[tone])
        except np.linalg.LinAlgError:
            where = " or ".join(f"{nu:g}" for nu in frequency)
            raise SlipmodeError(
                f"frequency = {where} rad/s: is the natural frequency of a mode without "
                "damping; give the structure damping, or another frequency"
            ) from None
        stuck = np.zeros(moved.shape[-1])  # G contains the springs of the contacts
        return ContactBalance(frequency, G, moved, self.model.local, stuck)

    def _together(self, frequency: Floats, local: Complexes) -> ToneState:
        """Return the state with all contacts together, from x (tones, N_c) with local contacts.

        The last correction, by equations with twice the steps and harmonics, is the error.
        """
        tolerance, finer, driven = self.model.tolerance, 1, self._driven(frequency)
        balance = self._balance(frequency, driven)
        contacts = self._contacts(frequency, finer, driven)
        x = np.zeros((1, len(driven), local.shape[1]), dtype=complex)
        x[0, : frequency.size] = local
        harmonics: Complexes | None = None
        while finer < _FINEST[len(self.responses) - 1]:
            x, harmonics = balance.with_coupled_contacts([contacts], x, harmonics)
            finer *= 2
            contacts = self._contacts(frequency, finer, driven)
            better = balance.corrected(contacts, x[0], harmonics[0])[: frequency.size]
            modal = self._modal(frequency, better)
            amplitude = self._amplitude(modal)
            y = harmonics[0, : frequency.size]
            before = self._amplitude(self._modal(frequency, y))
            size = max(float(np.abs(amplitude).max()), _TINY)
            error = np.abs(amplitude - before) + _CLOSEST[frequency.size - 1] * size
            off = float(error.max()) / size
            if off <= tolerance:
                carriers, others = np.split(np.abs(x[0]), [frequency.size])
                moved = others.sum(axis=0).max() / max(float(carriers.max()), _TINY)
                return ToneState(amplitude, error, modal, better, float(moved))
        where = " and ".join(f"{nu:.6g}" for nu in frequency)
        raise SlipmodeError(
            f"tolerance = {tolerance:g}: the contacts at {where} rad/s need more than "
            f"{contacts.grid.steps} steps per period; a tolerance of {2.0 * off:.1g} is within "
            "reach"
        )

    def _contacts(self, frequency: Floats, finer: int, driven: Sequence[Order]) -> CoupledContacts:
        response, law = self.responses[0], self.model.law
        flexibility = response.flexibility
        return CoupledContacts.of(law, response.fast, flexibility, frequency, finer, driven)


def _complex_vectors(force: Any, tones: int, n_dofs: int) -> Complexes:
    """Return amplitudes (tones, n) of {DOF: amplitude} or arrays of complex numbers."""

    def of(part: Callable[[Any], Any]) -> Floats:
        given = force
        if isinstance(force, Sequence | np.ndarray) and not isinstance(force, str):
            given = [
                {dof: part(amplitude) for dof, amplitude in each.items()}
                if isinstance(each, Mapping)
                else part(each)
                for each in force
            ]
        return force_vectors(given, tones, n_dofs)

    return np.asarray(of(np.real) + 1j * of(np.imag))


def tone_flow(
    model: ToneModel,
    frequency: ArrayLike,
    force: ToneForce | Sequence[ToneForce],
    phase: ArrayLike = 0.0,
) -> ToneFlow:
    """Return a structure at rest whose modes share one or two tones, for stepping in time.

    Parameters
    ----------
    model : ToneModel
        Model of modes that share a tone.
    frequency : float or (2,) array_like
        Forcing frequency at the start [rad/s], of two tones both; it may change by 10 %.
    force : {DOF: amplitude} or (n,) array_like, or a sequence of two of them for two tones
        Force amplitudes f [N] of Re(f exp(i Omega t)), complex where DOFs have phases of their
        own. `ToneFlow.step` multiplies them by a magnitude, which is 0 at the start.
    phase : float or (2,) array_like, default 0.0
        Phase of the force [rad].

    Returns
    -------
    ToneFlow
        Structure at time 0.

    Raises
    ------
    SlipmodeError
        If an argument is outside its range.

    Warns
    -----
    ValidityWarning
        If errors of transients are above 1 %, because contacts are strong or act on each other at
        higher harmonics.
    """
    Omega = as_floats("frequency", frequency)
    forces: Any = force if Omega.shape else [force]
    Omega = Omega.reshape(1, -1)[0]
    forced = ForcedTone.of(model, forces, phase, Omega[np.newaxis])
    warn(forced.transient_findings(Omega))
    return forced.flow(Omega, model.tolerance)
