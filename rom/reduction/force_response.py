"""Effects of the forces besides the excitation of their own mode.

A point force drives every mode. The mode that is near resonance with it has its slow flow. The
force also acts on the other modes, off resonance; on the contacts directly; and statically on all
that neither modes nor contact shapes represent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.force_vector import force_vectors
from slipmode.rom.structure.structure import Structure

# One {DOF: amplitude} or (n,) array per mode: amplitudes [N], or a pattern, the force per unit of
# a scalar amplitude.
Forces = Sequence[Mapping[int, float] | ArrayLike]
ForcePatterns = Forces


def phasor(force: ArrayLike, phase: ArrayLike) -> Complexes:
    """Return F exp(i phase) of forces F cos(theta + phase), broadcast."""
    return np.asarray(force * np.exp(1j * np.asarray(phase)), dtype=complex)


@frozen
class AppliedForces:
    """Forces on a reduced structure, one per mode, and their effects per unit of modal force."""

    reduced: Reduced
    force: Floats  # f_j (modes, n) [N], or patterns: effects per F_j do not depend on the scale
    # What was reduced. None: `reduced.structure`.
    structure: Structure | None = None

    @classmethod
    def of(cls, reduced: Reduced, force: Forces, structure: Structure | None = None) -> Self:
        """Return the forces of one {DOF: amplitude} or (n,) array per tone."""
        return cls(reduced, forces_on_modes(reduced, force), structure)

    @cached_property
    def modal(self) -> Floats:
        """Modal forces F_j, (modes,) [N kg^-1/2]."""
        return np.array([self.reduced.modal_force(j, f) for j, f in enumerate(self.force)])

    def excitation(self, phase: ArrayLike) -> Complexes:
        """Return F_j exp(i phase_j), (modes,), for one phase or one phase per tone [rad]."""
        angle = as_floats("phase", phase)
        if angle.shape not in ((), (self.reduced.tones,)) or not np.isfinite(angle).all():
            raise SlipmodeError(
                f"phase: must be a finite number or {self.reduced.tones}, one per mode [rad], "
                f"got {in_one_line(phase)}"
            )
        return phasor(self.modal, angle)

    @cached_property
    def per_modal_force(self) -> Floats:
        """f_j / F_j, (modes, n); 0 without a force."""
        own = self.modal[:, np.newaxis]
        return np.divide(self.force, own, out=np.zeros_like(self.force), where=own != 0.0)

    @cached_property
    def on_modes(self) -> Floats:
        """Force phi_k^T f_j on every mode per unit of F_j, (modes, modes + nonresonant) [-]."""
        return np.asarray(self.per_modal_force @ self.reduced.all_shapes)

    @cached_property
    def contact(self) -> Floats:
        """Force X^T f_j on the contacts per unit of F_j, (modes, N_c) [kg^1/2]."""
        return np.asarray(self.per_modal_force @ self.reduced.contact_shapes)

    @cached_property
    def past_mode(self) -> Complexes:
        """`contact` plus the force through all modes but j, at carrier j; (modes, N_c)."""
        through = np.einsum("jm,jmc->jc", self.on_modes, self.reduced.response_to_contacts)
        return np.asarray(self.contact - through)

    @cached_property
    def off_resonance(self) -> Complexes:
        """Displacement of every mode but j at carrier j per unit of F_j, (modes, all modes).

        0 in the paper's formulation.
        """
        if self.reduced.formulation == "paper":
            return np.zeros_like(self.on_modes, dtype=complex)
        return self.reduced.others_response(0.5 * self.on_modes[..., np.newaxis])[..., 0]

    @property
    def cross_response(self) -> Complexes:
        """Displacement of mode k off resonance per unit of F_j, (modes, modes) [k, j]."""
        return self.off_resonance[:, : self.modal.size].T

    @cached_property
    def other_modes(self) -> Complexes:
        """Displacement of the loaded DOFs by all modes but j, (modes, 2): per F_j and per a_j.

        It is the work-conjugate displacement f_j^T x / F_j at carrier j, without the contacts.
        """
        if self.reduced.formulation == "paper":
            return np.zeros((self.modal.size, 2), dtype=complex)
        by_amplitude = self.reduced.response_by_dampers
        moved = np.stack((self.off_resonance, by_amplitude), axis=1)
        return np.asarray(np.einsum("jm,jkm->jk", self.on_modes, moved))

    @cached_property
    def through_dampers(self) -> Complexes:
        """Force on mode j through dampers from other modes that F_j moves, per F_j, (modes,).

        The amplitude equations neglect it: 2 sum_k -i Omega_j C_jk q_k at the carriers, with the
        modal displacements q_k of the other modes.
        """
        modes = np.arange(self.modal.size)
        D = self.reduced.modal_stiffness(self.reduced.carrier)[modes, modes]
        return np.asarray(-2.0 * np.einsum("jk,jk->j", D, self.off_resonance))

    @cached_property
    def shift(self) -> Complexes:
        """Shift of the amplitude at the contacts per F_j, (modes,); 0 in the paper's formulation.

        Force j acts on the contacts directly, and through the other modes off resonance. The
        effective amplitude at the contacts is a_j + shift_j F_j exp(i phase_j). The force on
        several contacts is not along L_j: the shift has the same effect on the mode as that force,
        with friction linearised about `contact_motion`.
        """
        shift = np.zeros(self.modal.size, dtype=complex)
        if self.reduced.formulation == "paper":
            return shift
        acting, coupled = (
            np.einsum("jc,jc->j", self.reduced.contact_motion, each)
            for each in (self.past_mode, self.reduced.coupling)
        )
        return np.asarray(np.divide(-0.5 * acting, coupled, out=shift, where=coupled != 0.0))

    @cached_property
    def static(self) -> Floats:
        """Displacement by the static flexibility besides modes and contact shapes, (n, modes).

        Per F_j [kg^1/2 m/N]; 0 if the structure is not known, as of models from files.
        """
        reduced, f = self.reduced, self.per_modal_force.T
        structure = reduced.structure if self.structure is None else self.structure
        if structure is None or reduced.formulation == "paper":
            return np.zeros_like(f)
        omega = np.append(reduced.structural_frequency, reduced.nonresonant_frequency)
        shapes, omega = reduced.all_shapes[:, omega > 0.0], omega[omega > 0.0]
        return reduced.held(structure).solve(f) - (shapes / omega**2) @ (shapes.T @ f)

    def residual(self, on_contacts: Complexes | Floats) -> Complexes:
        """Return forces on contacts per F_j without the part that the shift has, (modes, N_c)."""
        return np.asarray(on_contacts + 2.0 * self.shift[:, np.newaxis] * self.reduced.coupling)

    def free_vibration(
        self, discontinuity: Complexes, frequency: Floats, angle: Floats | float = 0.0
    ) -> Complexes:
        """Return the amplitudes (..., modes) that a jump of the forces adds.

        The motion of the modes is continuous, so free vibration compensates the jump of their
        forced response; the core does the same, see rom/kernel/slow/discontinuity.h.
        `discontinuity` (..., modes) is the jump of the modal F_j exp(i phase_j) [N kg^-1/2],
        frequency and angle belong to the carriers at the jump.
        """
        if self.reduced.formulation == "paper":
            return np.zeros_like(discontinuity)
        rotated = discontinuity * np.exp(1j * np.asarray(angle))
        gamma, omega = self.reduced.modal_damping, self.reduced.frequency
        damped = np.sqrt(np.maximum(omega**2 - 0.25 * gamma**2, 0.0))
        vibrates = damped > 0.0
        damped = np.where(vibrates, damped, 1.0)
        q = self.cross_response * rotated[..., np.newaxis, :]
        displacement = q.real.sum(axis=-1)
        velocity = -(q.imag * frequency[..., np.newaxis, :]).sum(axis=-1)
        own = (rotated / (gamma + 2j * (frequency + damped))).real
        free = -displacement + 1j * (own + 0.5 * gamma * displacement + velocity) / damped
        return np.where(vibrates, free * np.exp(-1j * np.asarray(angle)), 0.0)


def forces_on_modes(reduced: Reduced, force: Forces, key: str = "force") -> Floats:
    """Return forces (modes, n) of one per tone, or per mode with 0 for a second one on a tone."""
    tones, modes = reduced.tones, len(reduced.modes)
    entries = modes if np.iterable(force) and len(force) == modes else tones
    given = force_vectors(force, entries, reduced.n_dofs, key)
    if given[tones:].any():
        raise SlipmodeError(
            f"{key}: must be 0 for mode B, which is on the tone of mode A (rom.reduce(ratio=)); "
            "add it to the force on A if it has this frequency"
        )
    return np.pad(given[:tones], ((0, modes - tones), (0, 0)))


@lru_cache(maxsize=8)
def steady_force(reduced: Reduced) -> tuple[Complexes, Complexes]:
    """Return force on the contacts per dynamic stiffness force D_j c_j + L_j^T P_j, and D_j.

    In a steady state the force on mode j follows from its amplitude: with effective amplitudes
    c_j = a_j + shift_j F_j and the force of the contacts on the mode, -L_j^T P_j,

        F_j (1 + 2 shift_j D_j) = 2 (D_j c_j + L_j^T P_j),
        D_j = omega_j^2 - Omega_j^2 + i gamma_j Omega_j  at the carrier.

    So the contact problem can include the force on the contacts without the part that the shift
    has, residual_j F_j / 2: it changes the coupling L_j, and the reaction to P_j.

    The force (modes, N_c) is 0 without `force_patterns`, and for a mode whose force moves the
    contacts about as much directly as through the mode: its amplitude does not determine the
    force. D_j (modes,) includes the damping that returns from other modes [rad^2/s^2].
    """
    modes = np.arange(len(reduced.modes))
    D = reduced.modal_stiffness(reduced.carrier)[modes, modes, modes] + reduced.indirect_damping
    if reduced.force_patterns is None:
        return _read_only(np.zeros_like(reduced.coupling)), _read_only(D)
    applied = AppliedForces(reduced, reduced.force_patterns)
    residual = applied.residual(applied.past_mode)
    force = residual / (1.0 + 2.0 * (applied.shift * D)[:, np.newaxis])
    direct = np.linalg.norm(D[:, np.newaxis] * force, axis=1)
    determined = direct <= 0.5 * np.linalg.norm(reduced.coupling, axis=1)
    return _read_only(np.where(determined[:, np.newaxis], force, 0.0)), _read_only(D)


@lru_cache(maxsize=8)
def steady_coupling(reduced: Reduced) -> Complexes:
    """Return L_j of a mode that its force holds steady, (modes, N_c)."""
    force, D = steady_force(reduced)
    return _read_only(reduced.coupling - D[:, np.newaxis] * force)


def steady_reaction(reduced: Reduced) -> Complexes:
    """Return force on the contacts per P_j by the force that holds a_j, (modes, N_c, N_c)."""
    force, _ = steady_force(reduced)
    return np.asarray(np.einsum("jc,jd->jcd", force, reduced.coupling))


def _read_only(values: Complexes) -> Complexes:
    """Protect an array that a cache returns again."""
    values.flags.writeable = False
    return values
