"""What the forces do past their own mode: to the other modes, the contacts, and statically.

A point force on one DOF drives every mode. The one it is near resonance with has its slow flow;
the others respond off resonance, it acts on the contacts directly, and what neither modes nor
contacts have follows it statically.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.reduced import Reduced, force_vectors
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.held import bonded, stuck
from slipmode.rom.structure.structure import Structure

# One {DOF: amplitude} or (n,) array per mode: amplitudes [N], or a pattern, which is the force per
# unit of a scalar amplitude.
Forces = Sequence[Mapping[int, float] | ArrayLike]
ForcePatterns = Forces

_MOST_ASIDE = 0.5  # of the force on the contacts through the mode


def phasor(force: ArrayLike, phase: ArrayLike) -> Complexes:
    """F exp(i phase) of forces F cos(theta + phase), in whatever shape they come."""
    return np.asarray(force * np.exp(1j * np.asarray(phase)), dtype=complex)


@dataclass(frozen=True, eq=False)
class AppliedForces:
    """Forces on a reduced structure, one per mode, and what follows from them.

    Attributes
    ----------
    reduced : Reduced
    force : (modes, n) ndarray
        f_j [N], or a pattern: what is per unit of F_j does not depend on its scale.
    """

    reduced: Reduced
    force: Floats

    __repr__ = short_repr

    @classmethod
    def of(cls, reduced: Reduced, force: Forces) -> Self:
        """Of one {DOF: amplitude} or (n,) array per mode."""
        return cls(reduced, force_vectors(force, len(reduced.modes), reduced.n_dofs))

    @cached_property
    def modal(self) -> Floats:
        """F_j, (modes,) [N kg^-1/2]."""
        return np.array([self.reduced.modal_force_of(j, f) for j, f in enumerate(self.force)])

    def excitation(self, phase: ArrayLike) -> Complexes:
        """Return F_j exp(i phase_j), (modes,), for one phase or one phase per mode [rad]."""
        angle = as_floats("phase", phase)
        if angle.shape not in ((), self.modal.shape) or not np.isfinite(angle).all():
            raise SlipmodeError(
                f"phase: must be a finite number or {self.modal.size}, one per mode [rad], "
                f"got {in_one_line(phase)}"
            )
        return phasor(self.modal, angle)

    @cached_property
    def per_modal_force(self) -> Floats:
        """f_j / F_j, (modes, n); 0 where there is none."""
        own = self.modal[:, np.newaxis]
        return np.divide(self.force, own, out=np.zeros_like(self.force), where=own != 0.0)

    @cached_property
    def on_modes(self) -> Floats:
        """Force phi_k^T f_j on every mode per unit of F_j, (modes, modes + nonresonant) [-]."""
        shapes = self.reduced.mode_shapes, self.reduced.nonresonant_shapes
        return np.hstack([self.per_modal_force @ each for each in shapes])

    @cached_property
    def contact(self) -> Floats:
        """Force X^T f_j on the contacts per unit of F_j, (modes, N_c) [kg^1/2]."""
        return np.asarray(self.per_modal_force @ self.reduced.contact_shapes)

    @cached_property
    def past_mode(self) -> Complexes:
        """The same past mode j, at its carrier: that, and what comes through the other modes."""
        through = np.einsum("jm,jmc->jc", self.on_modes, self.reduced.response_to_contacts)
        return np.asarray(self.contact - through)

    @cached_property
    def through_dampers(self) -> Complexes:
        """Force on mode j by dampers from other modes, per unit of F_j that moves them, (modes,).

        The amplitude equations neglect it: 2 sum_k -i Omega_j C_jk q_k at the carriers, with the
        modal displacements q_k of the other modes.
        """
        modes = np.arange(self.modal.size)
        if self.reduced.formulation == "paper":
            return np.zeros(modes.size, dtype=complex)
        carrier = self.reduced.carrier
        half = 0.5 * self.on_modes[..., np.newaxis]
        moved = self.reduced.others_response(modes, carrier, half)[..., 0]
        D = self.reduced.modal_stiffness(carrier)[modes, modes]
        return np.asarray(-2.0 * np.einsum("jk,jk->j", D, moved))

    @cached_property
    def shift(self) -> Complexes:
        """`off_resonance_shift`, (modes,)."""
        shift = np.zeros(self.modal.size, dtype=complex)
        if self.reduced.formulation == "paper":
            return shift
        acting, coupled = (
            np.einsum("jc,jc->j", self.reduced.contact_motion, each)
            for each in (self.past_mode, self.reduced.coupling)
        )
        return np.asarray(np.divide(-0.5 * acting, coupled, out=shift, where=coupled != 0.0))

    def residual(self, on_contacts: Complexes | Floats) -> Complexes:
        """Such a force on the contacts less what they have of it by the shift, (modes, N_c)."""
        return _residual(on_contacts, self.shift, self.reduced)


@dataclass(frozen=True, eq=False)
class ForceResponse:
    """Forces past their own mode, each per unit of its modal force F_j; 0 where there is none.

    Attributes
    ----------
    modal : (modes, modes + nonresonant) ndarray
        Force phi_k^T f_j on every mode [-].
    contact : (modes, N_c) ndarray
        Force X^T f_j on the contacts [kg^1/2].
    static : (n, modes) ndarray
        Displacement by the static flexibility that modes and contact shapes leave over
        [kg^1/2 m/N]; 0 where the structure is not known.
    shift : (modes,) complex ndarray
        The part that the amplitude equations have: `off_resonance_shift`.
    cross_response : (modes, modes) complex ndarray
        Displacement of mode k off resonance, [k, j]: the function of that name.
    """

    modal: Floats
    contact: Floats
    static: Floats
    shift: Complexes
    cross_response: Complexes

    __repr__ = short_repr

    @classmethod
    def of(
        cls,
        reduced: Reduced,
        patterns: ForcePatterns,
        structure: Structure | None = None,
    ) -> Self:
        """Of force patterns on the structure that was reduced; their scale does not matter.

        Without the structure the displacement of DOFs lacks the static part.
        """
        applied = AppliedForces.of(reduced, patterns)
        f = applied.per_modal_force.T
        static = np.zeros_like(f)
        if structure is not None and reduced.formulation == "consistent":
            static = _left_over(structure, reduced, f)
        return cls(
            modal=applied.on_modes,
            contact=applied.contact,
            static=static,
            shift=applied.shift,
            cross_response=cross_response(reduced, patterns),
        )

    def residual_force(self, reduced: Reduced) -> Complexes:
        """Force on the contacts less what they have of it by the shift, (modes, N_c)."""
        return _residual(self.contact, self.shift, reduced)

    def free_vibration(
        self,
        reduced: Reduced,
        discontinuity: Complexes,
        frequency: Floats,
        angle: Floats | float = 0.0,
    ) -> Complexes:
        """Amplitudes (..., modes) that a force discontinuity adds: the modes go on as they were.

        From rest they hold the modes at rest as forces set in. It is what the core does in a step
        that begins with other forces than those it had: see rom/kernel/slow/discontinuity.h.

        Parameters
        ----------
        discontinuity : (..., modes) complex ndarray
            Of F_j exp(i phase_j), modal [N kg^-1/2].
        frequency, angle : (..., modes) ndarray
            Of the carriers at that time [rad/s], [rad].
        """
        if reduced.formulation == "paper":
            return np.zeros_like(discontinuity)
        rotated = discontinuity * np.exp(1j * np.asarray(angle))
        gamma, omega = reduced.modal_damping, reduced.frequency
        damped = np.sqrt(np.maximum(omega**2 - 0.25 * gamma**2, 0.0))
        vibrates = damped > 0.0
        damped = np.where(vibrates, damped, 1.0)
        q = self.cross_response * rotated[..., np.newaxis, :]
        responded = q.real.sum(axis=-1)
        moving = (q.imag * frequency[..., np.newaxis, :]).sum(axis=-1)
        own = (rotated / (gamma + 2j * (frequency + damped))).real
        left = -responded + 1j * (own + 0.5 * gamma * responded - moving) / damped
        return np.where(vibrates, left * np.exp(-1j * np.asarray(angle)), 0.0)


def _residual(on_contacts: Complexes | Floats, shift: Complexes, reduced: Reduced) -> Complexes:
    return np.asarray(on_contacts + 2.0 * shift[:, np.newaxis] * reduced.coupling)


def cross_response(reduced: Reduced, patterns: ForcePatterns) -> Complexes:
    """Displacement of mode k by the force of another mode j, per unit of F_j, at the carriers.

    Returns
    -------
    (modes, modes) complex ndarray
        [k, j]; 0 on the diagonal, and in the paper's formulation.
    """
    modes = np.arange(len(reduced.modes))
    if reduced.formulation == "paper":
        return np.zeros((modes.size, modes.size), dtype=complex)
    modal = 0.5 * AppliedForces.of(reduced, patterns).on_modes
    response = reduced.others_response(modes, reduced.carrier, modal[..., np.newaxis])
    return response[:, : modes.size, 0].T


def off_resonance_shift(reduced: Reduced, patterns: ForcePatterns) -> Complexes:
    """What the forces do to the contacts past their own mode, as a shift of its amplitude.

    Force j also acts on the contacts directly, by contact_shapes^T f, and through the other modes,
    which respond off resonance. The effective amplitude at the contacts is
    a_j + shift_j F_j exp(i phase_j), F_j modal. The force on several contacts is not along L_j:
    the shift does to the mode what that force does, with friction as linear as it is where the
    contacts move as in `contact_motion`.

    Parameters
    ----------
    patterns : sequence of {DOF: amplitude} or (n,) array_like, one per mode
        Where the forces act; their scale does not matter.

    Returns
    -------
    (modes,) complex ndarray
        0 in the paper's formulation.
    """
    return AppliedForces.of(reduced, patterns).shift


@lru_cache(maxsize=8)
def steady_force(reduced: Reduced) -> tuple[Complexes, Complexes]:
    """Force on the contacts per dynamic stiffness force D_j c_j + L_j^T P_j, and D_j.

    In a steady state the force on mode j follows from its amplitude: with effective amplitudes
    c_j = a_j + shift_j F_j and what the contacts do to the mode, -L_j^T P_j,

        F_j (1 + 2 shift_j D_j) = 2 (D_j c_j + L_j^T P_j),
        D_j = omega_j^2 - Omega_j^2 + i gamma_j Omega_j  at the carrier.

    Of the force on the contacts that `off_resonance_shift` leaves over, residual_j F_j / 2, the
    contact problem thus knows all: it changes the coupling L_j, and what comes back from P_j.

    Returns
    -------
    (modes, N_c) complex ndarray
        0 where the reduction knows no `force_patterns`, and for a mode whose force moves the
        contacts past it about as much as through it: its amplitude does not tell the force then.
    (modes,) complex ndarray
        With the damping that comes back from other modes [rad^2/s^2].
    """
    modes = np.arange(len(reduced.modes))
    D = reduced.modal_stiffness(reduced.carrier)[modes, modes, modes] + reduced.indirect_damping
    if reduced.force_patterns is None:
        return _kept(np.zeros_like(reduced.coupling)), _kept(D)
    applied = AppliedForces.of(reduced, list(reduced.force_patterns))
    residual = applied.residual(applied.past_mode)
    force = residual / (1.0 + 2.0 * (applied.shift * D)[:, np.newaxis])
    aside, through = (
        np.linalg.norm(part, axis=1) for part in (D[:, np.newaxis] * force, reduced.coupling)
    )
    held = (aside <= _MOST_ASIDE * through)[:, np.newaxis]
    return _kept(np.where(held, force, 0.0)), _kept(D)


@lru_cache(maxsize=8)
def steady_coupling(reduced: Reduced) -> Complexes:
    """L_j of a mode that its force holds steady, (modes, N_c)."""
    if reduced.force_patterns is None:
        return reduced.coupling
    force, D = steady_force(reduced)
    return _kept(reduced.coupling - D[:, np.newaxis] * force)


def steady_reaction(reduced: Reduced) -> Complexes:
    """Force on the contacts per carrier P_j (modes, N_c, N_c), by the force that answers it."""
    force, _ = steady_force(reduced)
    return np.asarray(np.einsum("jc,jd->jcd", force, reduced.coupling))


def _kept(values: Complexes) -> Complexes:
    """An array that a cache gives to everybody."""
    values.flags.writeable = False
    return values


def _left_over(structure: Structure, reduced: Reduced, f: Floats) -> Floats:
    """Static displacement (n, forces) with stuck contacts, less that of all modes kept."""
    squares = np.append(reduced.structural_frequency, reduced.nonresonant_frequency) ** 2
    elastic = squares > 0.0
    shapes, squares = reduced.all_shapes[:, elastic], squares[elastic]
    contacts = reduced.contacts
    held = bonded(structure) if contacts is None else stuck(structure, contacts.reference)
    return held.solve(f) - (shapes / squares) @ (shapes.T @ f)
