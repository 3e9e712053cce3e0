"""The reduced matrices: modes that have a slow flow, modes that only respond, and the contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements
from slipmode.rom.representable import ALLOWED, LARGEST, SMALLEST

Formulation = Literal["consistent", "paper"]

_IDLE = 2.0**-100  # of the largest force: modal force of forces that do no work on their mode
_ROUNDING = 1e-12  # of the work that forces on single DOFs do: none in sum
_WHATEVER_CARRIER = "_modal_parts", "_coupling_parts"  # worked out once for all carriers


@dataclass(frozen=True, eq=False)
class Reduced:
    """One or two bonded modes coupled to the contact problem.

    x = mode_shapes q + nonresonant_shapes p + contact_shapes x_c, q_j = a_j exp(i theta_j) + c.c.,
    and mass x_c'' + damping x_c' + stiffness x_c + g(x_c') = -2 Re sum_j L_j a_j exp(i theta_j)
    with L_j(nu) = spring_j + i nu damper_j at the frequency nu of the motion, and the response of
    the modes to each harmonic of x_c. Nonresonant modes do nothing else: no force is near their
    resonance. All other modes follow the contacts statically, their inertia being carried_mass.

    Attributes
    ----------
    formulation : {"consistent", "paper"}
    modes : tuple of int
        Indices of the retained bonded modes, by ascending frequency.
    frequency : (modes,) ndarray
        Natural frequencies omega_j of the bonded structure, with aerodynamics [rad/s].
    carrier : (modes,) ndarray
        Frequencies at which the contact problem is solved [rad/s]: those of the forcing, as far
        as they are known, or the natural frequencies.
    modal_damping : (modes,) ndarray
        phi_j^T C phi_j [1/s], and what aerodynamics add: negative of a self-excited mode.
    mode_shapes : (n, modes) ndarray
        Bonded modes in the structure's DOFs, normalised to unit modal mass [kg^-1/2].
    contact_shapes : (n, N_c) ndarray
        Motion of the structure per unit contact displacement (constraint modes; with residual
        flexibility in the consistent formulation) [-].
    mass, damping, stiffness : (N_c, N_c) ndarray
        Of the contact problem, Eq. (13) [kg], [N s/m], [N/m]; the mass is what resists a blow at
        the contacts, (W^T M^-1 W)^-1. The paper has stiffness alone.
    contact_motion : (modes, N_c) complex ndarray
        Carrier of the contacts per a_j [kg^-1/2]: without friction, or in a tabulated model at
        its largest amplitudes, unless it knows the force patterns. By reciprocity it weighs what
        a force on each contact does to the mode.
    carried_mass : (N_c, N_c) ndarray
        Inertia of what follows the contacts [kg]. It acts at the harmonics that the modes respond
        to: beyond, where those masses stay behind, it would ring against the stiffness.
    spring, damper : (modes, N_c) ndarray
        Coupling of the modes to the contacts. The paper has springs alone.
    nonresonant_frequency, nonresonant_damping : (nonresonant,) ndarray
        Natural frequencies [rad/s] and modal damping [1/s] of the nonresonant modes.
    nonresonant_shapes : (n, nonresonant) ndarray
        Like mode_shapes.
    nonresonant_spring, nonresonant_inertia, nonresonant_damper : (nonresonant, N_c) ndarray
        Their coupling to the contacts: by springs, by phi^T M X and phi^T C X.
    damping_coupling : (modes + nonresonant, modes + nonresonant) ndarray
        phi_j^T C phi_k between different modes [1/s]; 0 on the diagonal.
    contacts : Elements or None
        Elastic contacts, which the modes have stuck: the contact problem is the dual one then, see
        `slipmode.rom.reduction.stuck`. None: rigid contacts, which the modes have bonded.
    force_patterns : (modes, n) ndarray or None
        Where the forces that hold the modes steady act [-]: their scale does not matter. What
        they do past their own mode is in the contact problem (`steady_force`).
    aerodynamics : (modes,) complex ndarray or None
        Coefficients c_j of the aerodynamic forces on the modes [rad^2/s^2]; see
        `slipmode.rom.reduce`. None: no such forces.
    """

    formulation: Formulation
    modes: tuple[int, ...]
    frequency: Floats
    carrier: Floats
    modal_damping: Floats
    mode_shapes: Floats
    contact_shapes: Floats
    mass: Floats
    damping: Floats
    stiffness: Floats
    spring: Floats
    damper: Floats
    contact_motion: Complexes
    carried_mass: Floats
    nonresonant_frequency: Floats
    nonresonant_damping: Floats
    nonresonant_shapes: Floats
    nonresonant_spring: Floats
    nonresonant_inertia: Floats
    nonresonant_damper: Floats
    damping_coupling: Floats
    contacts: Elements | None = None
    force_patterns: Floats | None = None
    aerodynamics: Complexes | None = None

    def __repr__(self) -> str:
        modes = ", ".join(
            f"{number} at {omega:.4g} rad/s"
            for number, omega in zip(self.modes, self.frequency, strict=True)
        )
        return (
            f"Reduced({self.formulation}, mode {modes}, {self.n_contacts} contacts, "
            f"{self.nonresonant_frequency.size} nonresonant modes, {self.n_dofs} DOFs)"
        )

    @cached_property
    def coupling(self) -> Complexes:
        """L_j at the carrier of its mode, (modes, N_c).

        With what dampers between the modes make the others do.
        """
        (_, B), retained = self._at_carriers, np.arange(len(self.modes))
        return np.asarray(
            B[retained, retained] + np.einsum("jm,jmc->jc", self.response_by_dampers, B)
        )

    @cached_property
    def coupling_coefficients(self) -> Complexes:
        """c_k, (modes, 2): L(nu) is nearest to (1 + c_0 + i nu c_1) L(carrier)."""
        L = self.coupling
        rotated = 1j * self.carrier[:, np.newaxis] * self.damper
        parts = np.stack((-rotated, self.damper), axis=1)
        norm = np.sum(np.abs(L) ** 2, axis=1)[:, np.newaxis]
        c = np.einsum("jkc,jc->jk", parts, L.conj())
        return np.asarray(c / np.where(norm > 0, norm, 1.0))

    @property
    def response_by_dampers(self) -> Complexes:
        """What all modes do per a_j at its carrier, by dampers; (modes, modes + nonresonant)."""
        return self._others_at_carriers[..., 0]

    @property
    def response_to_contacts(self) -> Complexes:
        """What all but mode j do at its carrier by forces B_j, (modes, modes + nonresonant, N_c).

        Transposed, forces on the contacts per forces on these modes.
        """
        return self._others_at_carriers[..., 1:]

    @cached_property
    def _others_at_carriers(self) -> Complexes:
        """Both, side by side."""
        (D, B), retained = self._at_carriers, np.arange(len(self.modes))
        by_dampers = -D[retained, :, retained, np.newaxis]
        force = np.concatenate((by_dampers, B), axis=-1)
        return self._moved(D, _own(D, retained), force)

    @cached_property
    def _at_carriers(self) -> tuple[Complexes, Complexes]:
        """D and B at the carrier of each mode."""
        return self.modal_stiffness(self.carrier), self.modal_coupling(self.carrier)

    def others_response(
        self, mode: ArrayLike, frequency: ArrayLike, force: Complexes | Floats
    ) -> Complexes:
        """Displacement of all modes but the given one, (..., modes + nonresonant, forces).

        By modal forces of that shape at frequencies (...) [rad/s], with dampers between them; 0 of
        the mode (...).
        """
        D = self.modal_stiffness(frequency)
        return self._moved(D, _own(D, mode), force)

    def _moved(self, D: Complexes, held: Flags, force: Complexes | Floats) -> Complexes:
        """As `others_response`, with any modes (..., modes + nonresonant) held."""
        apart = held[..., np.newaxis] | held[..., np.newaxis, :]
        stiffness = np.where(apart, np.eye(held.shape[-1]), D)
        on_others = np.where(held[..., np.newaxis], 0.0, force)
        return np.asarray(np.linalg.solve(stiffness, on_others), dtype=complex)

    @cached_property
    def indirect_damping(self) -> Complexes:
        """Force on mode j per a_j that comes back through dampers from the others, (modes,)."""
        retained = np.arange(len(self.modes))
        back = self._at_carriers[0][retained, retained]
        return np.asarray(np.sum(self.response_by_dampers * back, axis=1))

    @property
    def structural_frequency(self) -> Floats:
        """Natural frequencies without aerodynamics [rad/s], (modes,)."""
        if self.aerodynamics is None:
            return self.frequency
        return np.asarray(np.sqrt(self.frequency**2 - self.aerodynamics.real))

    @property
    def aerodynamic_damping(self) -> Floats:
        """What aerodynamics add to the modal damping [1/s], (modes,)."""
        if self.aerodynamics is None:
            return np.zeros(len(self.modes))
        return np.asarray(self.aerodynamics.imag / self.structural_frequency)

    @property
    def n_dofs(self) -> int:
        """Number of DOFs of the structure."""
        return int(self.mode_shapes.shape[0])

    @property
    def n_contacts(self) -> int:
        """Number of contact DOFs N_c."""
        return int(self.stiffness.shape[0])

    @property
    def even(self) -> bool:
        """Whether the contacts move at even harmonics too, and about another mean."""
        return self.contacts is not None and not self.contacts.odd

    @cached_property
    def all_shapes(self) -> Floats:
        """Shapes of the retained and of the nonresonant modes, (n, modes + nonresonant)."""
        return np.hstack((self.mode_shapes, self.nonresonant_shapes))

    def modal_stiffness(self, frequency: ArrayLike) -> Complexes:
        """D(nu), (..., modes + nonresonant, modes + nonresonant), at frequencies nu (...) [rad/s].

        omega_j^2 - nu^2 + i gamma_j nu on the diagonal, dampers between the modes off it. A
        rigid-body mode, which contacts do not move, gets a unit static stiffness.
        """
        nu = np.asarray(frequency, dtype=float)[..., np.newaxis, np.newaxis]
        at_rest, unit, free, dampers = self._modal_parts
        stiffness: Complexes = at_rest - nu**2 * unit + (nu == 0.0) * free + 1j * nu * dampers
        return stiffness

    @cached_property
    def _modal_parts(self) -> tuple[Floats, Floats, Floats, Floats]:
        """What D(nu) is made of: omega_j^2, 1, 1 where a mode is free, and dampers."""
        omega = np.append(self.frequency, self.nonresonant_frequency)
        own = np.diag(np.append(self.modal_damping, self.nonresonant_damping))
        unit = np.eye(omega.size)
        return np.diag(omega**2), unit, (omega == 0.0) * unit, own + self.damping_coupling

    def modal_coupling(self, frequency: ArrayLike) -> Complexes:
        """Coupling of every mode to the contacts at frequencies nu (...) [rad/s].

        Returns
        -------
        (..., modes + nonresonant, N_c) complex ndarray
            The mode responds to x_c exp(i nu t) by q = -D^-1 B x_c, and reacts by -B^T q.
        """
        nu = np.asarray(frequency, dtype=float)[..., np.newaxis, np.newaxis]
        at_rest, inertia, dampers = self._coupling_parts
        return np.asarray(at_rest - nu**2 * inertia + 1j * nu * dampers, dtype=complex)

    @cached_property
    def _coupling_parts(self) -> tuple[Floats, Floats, Floats]:
        """What couples every mode to the contacts: springs, inertia, dampers."""
        return (
            np.vstack((self.spring, self.nonresonant_spring)),
            np.vstack((np.zeros_like(self.spring), self.nonresonant_inertia)),
            np.vstack((self.damper, self.nonresonant_damper)),
        )

    def reaction(self, frequency: ArrayLike, held: ArrayLike = False) -> Complexes:
        """Force on the contacts per x_c exp(i nu t) at frequencies nu (...), (..., N_c, N_c).

        By all modes but those of (..., modes) that are `held`, and by the inertia that follows
        the contacts.
        """
        B = self.modal_coupling(frequency)
        still = np.zeros(B.shape[:-1], dtype=bool)
        still[..., : len(self.modes)] = held
        response = self._moved(self.modal_stiffness(frequency), still, B)
        return np.asarray(B.swapaxes(-1, -2) @ response + self.following(frequency))

    def following(self, frequency: ArrayLike) -> Complexes:
        """The same by what follows the contacts, (..., N_c, N_c): its inertia.

        And its dampers, where the contacts are elastic: no march has these.
        """
        nu = np.asarray(frequency, dtype=float)[..., np.newaxis, np.newaxis]
        dampers = 0.0 if self.contacts is None else 1j * nu * self.damping
        return np.asarray(nu**2 * self.carried_mass - dampers, dtype=complex)

    def at_carrier(self, carrier: Sequence[float]) -> Reduced:
        """Return the model with its contact problem at other carrier frequencies [rad/s].

        Raises
        ------
        SlipmodeError
            In the paper's formulation, whose slow flow has the natural frequencies alone; or if
            the frequencies are not positive numbers, one per mode.
        """
        if self.formulation == "paper":
            raise SlipmodeError(
                'carrier: the "paper" formulation solves contacts at the natural frequencies; '
                'leave carrier out or use formulation="consistent"'
            )
        frequencies = as_floats("carrier", carrier)
        if frequencies.shape != self.frequency.shape or not np.all(
            (frequencies >= SMALLEST) & (frequencies <= LARGEST)
        ):
            raise SlipmodeError(
                f"carrier: must be {self.frequency.size} numbers, {SMALLEST:g} to {LARGEST:g} "
                f"[rad/s], got {carrier}"
            )
        other = replace(self, carrier=frequencies)
        vars(other).update({name: getattr(self, name) for name in _WHATEVER_CARRIER})
        return other

    def moving(self, contact_motion: Complexes) -> Self:
        """The same model with another `contact_motion`; what else was worked out of it is kept."""
        other = copy(self)
        object.__setattr__(other, "contact_motion", contact_motion)
        return other

    def modal_force(self, mode: int, force: Mapping[int, float] | ArrayLike) -> float:
        """Modal force phi_j^T f of the `mode`-th retained mode [N kg^-1/2].

        What forces do past their mode is told per unit of it (ForceResponse), and forces on the
        contacts alone do nothing else. Theirs is therefore not 0 but too small to drive anything.

        Parameters
        ----------
        mode : int
            0 for mode A, 1 for mode B.
        force : {DOF: amplitude} or (n,) array_like
            Force amplitudes [N].
        """
        return self.modal_force_of(mode, force_vector(force, self.n_dofs))

    def modal_force_of(self, mode: int, vector: Floats) -> float:
        """The same of a force (n,) that is checked."""
        modal = float(self.mode_shapes[:, mode] @ vector)
        least = _IDLE * float(np.abs(vector).max())
        return modal if abs(modal) > least else least

    def is_moved_by(self, mode: int, force: Mapping[int, float] | ArrayLike) -> bool:
        """Whether a force does work on a mode, or (consistent) on contacts of the mode."""
        f = force_vector(force, self.n_dofs)
        largest, shape = np.abs(f).max(), self.mode_shapes[:, mode]
        modal = abs(self.modal_force_of(mode, f))
        own = modal > max(_ROUNDING * float(np.abs(shape) @ np.abs(f)), _IDLE * largest)
        shapes = self.contact_shapes[:, (self.spring[mode] != 0) | (self.damper[mode] != 0)]
        on_contacts = np.abs(shapes.T @ f).max(initial=0.0)
        through_contacts = on_contacts > _ROUNDING * largest * np.abs(shapes).max(initial=0.0)
        return bool(own or (through_contacts and self.formulation == "consistent"))


def _own(D: Complexes, mode: ArrayLike) -> Flags:
    """Which of all modes each of these is, by the matrices (..., all modes, all modes)."""
    return np.asarray(np.arange(D.shape[-1]) == np.asarray(mode)[..., np.newaxis])


def force_vector(
    force: Mapping[int, float] | ArrayLike, n_dofs: int, key: str = "force"
) -> Floats:
    """Force amplitudes (n,) from {DOF: amplitude} or from an array; a refusal names `key`."""
    if isinstance(force, Mapping):
        vector = np.zeros(n_dofs)
        for dof, amplitude in force.items():
            if not (isinstance(dof, int | np.integer) and 0 <= dof < n_dofs):
                raise SlipmodeError(
                    f"{key}: DOF {dof!r} is out of range, allowed: 0 to {n_dofs - 1}"
                )
            number = as_floats(key, amplitude)
            if number.ndim:
                raise SlipmodeError(f"{key}: must be one number at DOF {dof}, got {amplitude}")
            vector[dof] = number
    else:
        vector = as_floats(key, force)
    largest = float(np.abs(vector).max(initial=0.0))
    if vector.shape != (n_dofs,) or not (largest == 0.0 or SMALLEST <= largest <= LARGEST):
        raise SlipmodeError(
            f"{key}: must be {n_dofs} finite numbers, one per DOF, the largest {ALLOWED}"
        )
    return vector


def force_vectors(forces: Any, modes: int, n_dofs: int, key: str = "force") -> Floats:
    """Return the forces (modes, n) of one {DOF: amplitude} or array per mode.

    Raises
    ------
    SlipmodeError
        If there is not one entry per mode, or an entry is not a force. The message names `key`.
    """
    is_list = isinstance(forces, Sequence | np.ndarray) and not isinstance(forces, str)
    if not is_list or len(forces) != modes:
        raise SlipmodeError(
            f"{key}: needs one entry per mode ({modes}), each {{DOF: amplitude}} or an array of "
            f"{n_dofs} numbers, got {in_one_line(forces)}"
        )
    return np.array([force_vector(each, n_dofs, key) for each in forces])
