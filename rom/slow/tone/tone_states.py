"""Steady states and transients of several modes on one tone.

A steady state with local contacts is put into the equations of all contacts together, solved
there, and put into these equations again with twice the time steps and harmonics.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import carrier_findings, check_carrier
from slipmode.rom.kernel import Structure
from slipmode.rom.reduction.force_response import phasor
from slipmode.rom.reduction.force_vector import force_vectors
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.slow.tone.contact_balance import ContactBalance
from slipmode.rom.slow.tone.core_tone import core_tone
from slipmode.rom.slow.tone.coupled_contacts import CoupledContacts
from slipmode.rom.slow.tone.tone_flow import ToneFlow
from slipmode.rom.slow.tone.tone_modes import ToneModes
from slipmode.rom.slow.tone.tone_response import ToneResponse
from slipmode.rom.table.local.local_contacts import STEPS, LocalContacts
from slipmode.rom.table.local.tone_model import ToneModel, local_contacts
from slipmode.rom.validity import Finding, warn

ToneForce = Mapping[int, complex] | ArrayLike

# Error of amplitudes from rest relative to the share of stiffness due to contacts, 0.02 to 0.1,
# and to the response of a mode to a harmonic, 0.06 where that mode is at 1:3
# (tests/rom/slow/test_one_tone.py). Errors are reported beyond _LARGE.
_AVERAGING, _LARGE = 0.1, 0.01
_TINY = np.finfo(float).tiny
_FINEST = 8  # factor of the steps and harmonics of the contacts
# Error by the end of the search for a state, 1e-5, and by modes that follow statically, relative
# to the largest amplitude. Beams of 80 to 400 DOFs were within 2e-5 of harmonic balance.
_CLOSEST = 3e-5


@frozen
class ToneState:
    """A steady state at one frequency.

    Attributes
    ----------
    modal : (modes + nonresonant,) complex ndarray
        Amplitudes of all modes [kg^1/2 m].
    error : (modes,) ndarray
        Of the amplitudes of the retained modes [kg^1/2 m].
    deficit : (N_c,) complex ndarray
        Force deficits of the contacts at the carrier [N].
    """

    modal: Complexes
    error: Floats
    deficit: Complexes


@frozen
class ForcedTone:
    """A model under one force.

    Attributes
    ----------
    model : ToneModel
    response : ToneResponse
    """

    model: ToneModel
    response: ToneResponse

    @classmethod
    def of(
        cls, model: ToneModel, force: Sequence[ToneForce], phase: ArrayLike, frequency: Floats
    ) -> Self:
        """Return a model under a force, at frequencies (points,) [rad/s] that are checked."""
        if not isinstance(model, ToneModel):
            raise SlipmodeError("model: must be of modes that share a tone (rom.reduce(tones=))")
        vector = _complex_vector(force, model.reduced.n_dofs)
        angle = as_floats("phase", phase)
        if angle.size != 1 or not np.isfinite(angle).all():
            raise SlipmodeError(f"phase: must be a finite number [rad], got {in_one_line(phase)}")
        if not np.all(np.isfinite(frequency) & (frequency > 0.0)):
            raise SlipmodeError("frequency: must be finite and > 0 [rad/s]")
        middle = float(np.median(model.reduced.frequency))
        check_carrier("frequency", "A", middle, frequency)
        own = np.array([middle])
        warn(carrier_findings("frequency", "A", own, frequency[:, np.newaxis]), stacklevel=5)
        return cls(model, ToneResponse(model.reduced, phasor(vector, angle.ravel())))

    def steady(self, frequency: Floats) -> list[ToneState]:
        """Return steady states at frequencies (points,) [rad/s], in their order."""
        found = []
        x: Complexes | None = None
        for each in frequency.tolist():
            balance = self._balance(each)
            x, y = balance.with_local_contacts(x)
            found.append(self._together(balance, x, y))
        return found

    def with_local_contacts(self, frequency: Floats) -> Complexes:
        """Return amplitudes (points, modes) with local contacts alone."""
        found = []
        x: Complexes | None = None
        for each in frequency.tolist():
            x, y = self._balance(each).with_local_contacts(x)
            found.append(self.response.modal(each, y[0])[: self.model.modes])
        return np.array(found)

    def flow(self, frequency: float, tolerance: float) -> ToneFlow:
        """Return the structure at rest, near a reference frequency [rad/s]."""
        return ToneFlow(*self._parts(frequency), frequency, tolerance)

    def core(self, frequency: float, elastic: Sequence[int], contact: bool) -> Structure:
        """Return the core's structure near a reference frequency [rad/s], with outputs."""
        outputs = self.response.outputs(elastic, contact_motion=contact)
        return core_tone(*self._parts(frequency), frequency, outputs)

    def _parts(self, frequency: float) -> tuple[ToneModes, LocalContacts, Complexes]:
        """Return modes, contacts and the own flexibilities of the contacts."""
        modes = self.response.tone_modes(frequency)
        own = np.diag(modes.flexibility(frequency))
        return modes, local_contacts(self.model.reduced, self.model.law, frequency, own), own

    def transient_findings(self, frequency: float) -> list[Finding]:
        """Report that transients near a frequency [rad/s] have large errors."""
        reduced, at = self.model.reduced, np.array([frequency])
        assert reduced.contacts is not None
        squares = (reduced.frequency**2)[:, np.newaxis]
        share = float((reduced.spring**2 / squares @ reduced.contacts.reference).max())
        local, exact = self.with_local_contacts(at)[0], self.steady(at)[0].modal
        off = np.abs(local - exact[: local.size]).max() / max(np.abs(local).max(), _TINY)
        gain = self.response.harmonic_gain(frequency)
        error = float(_AVERAGING * (share + gain) + off)
        if error <= _LARGE:
            return []
        reason = (
            f"contacts have {percentage(share)} of the stiffness of a mode, their harmonics move "
            f"a mode by {percentage(gain)}, and the action of contacts on each other at "
            "harmonics, which transients neglect, changes steady states by "
            f"{percentage(float(off))}. Steady states (rom.steady) include it; compare transients "
            "with rom.full"
        )
        choice = f"have errors of about {percentage(error)}"
        return [Finding("transients", choice, reason, "warning")]

    def _balance(self, frequency: float) -> ContactBalance:
        try:
            G, moved = self.response.flexibility(frequency), self.response.moved(frequency)
        except np.linalg.LinAlgError:
            raise SlipmodeError(
                f"frequency = {frequency:g} rad/s: is the natural frequency of a mode without "
                "damping; give the structure damping, or another frequency"
            ) from None
        stuck = np.zeros(moved.size)  # G contains the springs of the contacts
        return ContactBalance(frequency, G[np.newaxis], moved[np.newaxis], self.model.local, stuck)

    def _together(self, balance: ContactBalance, x: Complexes, y: Complexes) -> ToneState:
        """Return the state with all contacts together, from the one with local contacts.

        The last correction, by equations with twice the steps and harmonics, is the error.
        """
        own, tolerance, finer = slice(self.model.modes), self.model.tolerance, 1
        frequency = balance.frequency
        contacts = self._contacts(frequency, finer)
        while finer < _FINEST:
            x, y = balance.with_coupled_contacts([contacts], x)
            finer *= 2
            contacts = self._contacts(frequency, finer)
            better = balance.corrected(contacts, x[0], y[0])
            modal = self.response.modal(frequency, better)
            size = max(float(np.abs(modal[own]).max()), _TINY)
            error = np.abs(modal - self.response.modal(frequency, y[0]))[own] + _CLOSEST * size
            off = float(error.max()) / size
            if off <= tolerance:
                return ToneState(modal, error, better)
        raise SlipmodeError(
            f"tolerance = {tolerance:g}: the contacts at {frequency:.6g} rad/s need more than "
            f"{finer * STEPS} steps per period; a tolerance of {2.0 * off:.1g} is within reach"
        )

    def _contacts(self, frequency: float, finer: int) -> CoupledContacts:
        response, law = self.response, self.model.law
        return CoupledContacts.of(law, response.fast, response.flexibility, frequency, finer)


def _complex_vector(force: Any, n_dofs: int) -> Complexes:
    """Return amplitudes (n,) of a list of one {DOF: amplitude} or array of complex numbers."""

    def of(part: Callable[[Any], Any]) -> Floats:
        given = force
        if isinstance(force, Sequence | np.ndarray) and not isinstance(force, str):
            given = [
                {dof: part(amplitude) for dof, amplitude in each.items()}
                if isinstance(each, Mapping)
                else part(each)
                for each in force
            ]
        return np.asarray(force_vectors(given, 1, n_dofs)[0])

    return np.asarray(of(np.real) + 1j * of(np.imag))


def tone_flow(
    model: ToneModel,
    frequency: float,
    force: ToneForce,
    phase: float = 0.0,
) -> ToneFlow:
    """Return a structure at rest whose modes share a tone, for stepping in time.

    Parameters
    ----------
    model : ToneModel
        Model of modes that share a tone.
    frequency : float
        Forcing frequency at the start [rad/s]; it may change by 10 %.
    force : {DOF: amplitude} or (n,) array_like
        Force amplitudes f [N] of Re(f exp(i Omega t)), complex where DOFs have phases of their
        own. `ToneFlow.step` multiplies them by a magnitude, which is 0 at the start.
    phase : float, default 0.0
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
    Omega = float(as_floats("frequency", frequency))
    forced = ForcedTone.of(model, [force], phase, np.array([Omega]))
    warn(forced.transient_findings(Omega))
    return forced.flow(Omega, model.tolerance)
