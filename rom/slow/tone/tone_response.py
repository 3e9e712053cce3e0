"""Linear response of a reduced structure with stuck contacts to one force, at any frequency.

With the modal displacements q of all modes, their dynamic stiffness D(nu) and coupling B(nu) to
the contacts, and the contact shapes X,

    D q = f_modal / 2 - B y,    x = X^T f / 2 - B^T q + (R + following) y.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.interaction.internal_resonance import (
    harmonic_decay,
    harmonic_gain,
    mode_gains,
)
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.tone.core_tone import ToneOutputs
from slipmode.rom.slow.tone.coupled_contacts import FastModes
from slipmode.rom.slow.tone.tone_modes import ToneModes
from slipmode.rom.table.local.local_contacts import LocalContacts

# Square of the natural frequency that rigid-body modes have instead of 0, relative to the carrier:
# it changes their response by this much, and the poles of a mode differ.
_RIGID = 1e-6


@frozen
class ToneResponse:
    """A reduced structure under the force f cos(Omega t).

    Attributes
    ----------
    reduced : Reduced
    force : (n,) complex ndarray
        f, with its phase [N].
    """

    reduced: Reduced
    force: Complexes

    def flexibility(self, frequency: float) -> Complexes:
        """Return G of the contacts at a frequency [rad/s], (N_c, N_c) [m/N]."""
        return np.asarray(self.reduced.reaction(frequency) - self.reduced.stiffness)

    def moved(self, frequency: float) -> Complexes:
        """Return the displacement of the contacts by the force alone, (N_c,) [m]."""
        q, B = self.modal(frequency), self.reduced.modal_coupling(frequency)
        return np.asarray(0.5 * self.force @ self.reduced.contact_shapes - B.T @ q)

    def modal(self, frequency: float, deficit: Complexes | None = None) -> Complexes:
        """Return q (modes + nonresonant,) [kg^1/2 m] under the force and force deficits (N_c,)."""
        reduced = self.reduced
        loads = self._on_modes
        if deficit is not None:
            loads = loads - reduced.modal_coupling(frequency) @ deficit
        return reduced.response(frequency, loads[:, np.newaxis])[:, 0]

    def displacement(self, modal: Complexes, deficit: Complexes, dof: int | slice) -> Complexes:
        """Return displacements of DOFs under the force [m]."""
        reduced = self.reduced
        x = reduced.all_shapes[dof] @ modal + reduced.contact_shapes[dof] @ deficit
        return np.asarray(x + self._static[dof])

    def harmonic_gain(self, carrier: Floats) -> float:
        """Return the largest gain of a mode at odd harmonics of each of the carriers [rad/s].

        See `slipmode.rom.reduction.interaction.internal_resonance`; without the retained modes.
        """
        h = np.arange(3.0, LocalContacts.HIGHEST + 1.0, 2.0)
        every = np.outer(carrier, h).ravel()
        gain, _ = mode_gains(self.reduced, every, np.tile(h**2, carrier.size))
        return float(gain[:, len(self.reduced.modes) :].max(initial=0.0))

    def mode_gain(self, orders: Sequence[Order], carrier: Floats) -> Floats:
        """Return the largest gain of any mode at harmonics of carriers [rad/s], (orders,).

        See `slipmode.rom.reduction.interaction.internal_resonance`.
        """
        assert self.reduced.contacts is not None
        stiffness = (self._motion**2 * self.reduced.contacts.reference).max(axis=1)
        D = self.reduced.modal_stiffness(np.array(orders) @ carrier)
        decay = harmonic_decay(orders)[:, np.newaxis]
        gain = harmonic_gain(stiffness, np.einsum("...kk->...k", D), decay)
        return np.asarray(gain.max(axis=1))

    @cached_property
    def fast(self) -> FastModes:
        """Modes far above the modes of the tone, which are marched with the contacts."""
        reduced, nonresonant = self.reduced, len(self.reduced.modes)
        inertia = reduced.nonresonant_frequency[:, np.newaxis] * reduced.nonresonant_inertia
        static = -reduced.stiffness - inertia.T @ inertia
        frequency = reduced.nonresonant_frequency
        highest = float(reduced.frequency.max())
        return FastModes.of(static, frequency, self._motion[nonresonant:], highest)

    def tone_modes(self, frequency: float) -> ToneModes:
        """Return the amplitudes of first order near a frequency [rad/s]."""
        reduced, psi, others = self.reduced, self._motion, slice(len(self.reduced.modes), None)
        square = np.append(reduced.frequency, reduced.nonresonant_frequency) ** 2
        own = np.append(reduced.modal_damping, reduced.nonresonant_damping)
        # Static besides the modes, with the inertia of the modes that follow at this frequency.
        D = reduced.modal_stiffness(frequency)[others, others]
        retained = np.ones(len(reduced.modes), dtype=bool)
        without = reduced.reaction(frequency, retained) - reduced.stiffness
        beyond = self._by_contacts

        def expand(modal: Complexes, magnitude: complex, deficit: Complexes) -> Complexes:
            x = reduced.all_shapes @ modal + beyond @ deficit
            return np.asarray(x + magnitude * self._static)

        return ToneModes.of(
            np.diag(np.maximum(square, _RIGID * frequency**2)),
            np.diag(own) + reduced.damping_coupling,
            psi.T,
            self._on_modes,
            self._on_modes.conj(),
            frequency,
            static_flexibility=without - psi[others].T @ np.linalg.solve(D, psi[others]),
            static_displacement=0.5 * self.force @ beyond,
            expand=expand,
        )

    def outputs(
        self, modes: slice, elastic: Sequence[int], *, contact_motion: bool
    ) -> ToneOutputs:
        """Return the amplitudes of retained modes, and displacements of DOFs, as outputs."""
        reduced, amplitudes = self.reduced, modes.stop - modes.start
        assert reduced.contacts is not None

        def rows(values: Complexes | Floats, of_amplitudes: Floats) -> Complexes:
            return np.concatenate(
                (of_amplitudes, values[list(elastic)], self.force[np.newaxis].conj() @ values)
            )

        shapes, static = reduced.all_shapes, self._static[:, np.newaxis]
        return ToneOutputs(
            amplitudes,
            len(elastic),
            contact_motion,
            rows(shapes, np.eye(shapes.shape[1])[modes]),
            rows(self._by_contacts, np.zeros((amplitudes, reduced.n_contacts))),
            rows(static, np.zeros((amplitudes, 1)))[:, 0],
            reduced.contacts.reference,
        )

    @cached_property
    def _by_contacts(self) -> Floats:
        """Displacements besides all modes by force deficits of the contacts, (n, N_c) [m/N]."""
        reduced = self.reduced
        inertia = reduced.nonresonant_shapes @ reduced.nonresonant_inertia
        return np.asarray(reduced.contact_shapes - inertia)

    @cached_property
    def _on_modes(self) -> Complexes:
        """Half the force on every mode, (modes + nonresonant,) [N kg^-1/2]."""
        return np.asarray(0.5 * self.force @ self.reduced.all_shapes)

    @cached_property
    def _motion(self) -> Floats:
        """Displacement of the contacts in every mode, (modes + nonresonant, N_c) [kg^-1/2]."""
        reduced = self.reduced
        omega = reduced.nonresonant_frequency[:, np.newaxis]
        others = omega**2 * reduced.nonresonant_inertia - reduced.nonresonant_spring
        return np.vstack((-reduced.spring, others))

    @cached_property
    def _static(self) -> Complexes:
        """Static displacement besides modes and contact shapes under half the force, (n,) [m]."""
        reduced = self.reduced
        if reduced.structure is None:
            return np.zeros_like(self.force)
        omega = np.append(reduced.frequency, reduced.nonresonant_frequency)
        shapes, omega = reduced.all_shapes[:, omega > 0.0], omega[omega > 0.0]
        held, half = reduced.held(reduced.structure), 0.5 * self.force
        every = held.solve(np.column_stack((half.real, half.imag))) @ np.array([1.0, 1j])
        return np.asarray(every - (shapes / omega**2) @ (shapes.T @ half))
