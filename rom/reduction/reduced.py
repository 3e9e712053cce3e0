"""The reduced matrices: modes with a slow flow, modes that only respond, and the contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements
from slipmode.rom.reduction.structural_damping import beside_equivalent, dampers_at
from slipmode.rom.reduction.tones import modes_of_tones, names_on_tones
from slipmode.rom.representable import LARGEST, SMALLEST
from slipmode.rom.structure.force_vector import force_vector
from slipmode.rom.structure.held import Held, bonded, stuck
from slipmode.rom.structure.structure import Structure

Formulation = Literal["consistent", "paper"]

# The arrays that every `Reduced` has, and the axes of each: n DOFs, m modes, c contacts,
# p nonresonant modes, q all modes.
REDUCED_ARRAYS = {
    **dict.fromkeys(("frequency", "carrier", "modal_damping"), "m"),
    **dict.fromkeys(("mass", "damping", "stiffness", "carried_mass"), "cc"),
    **dict.fromkeys(("spring", "damper", "contact_motion"), "mc"),
    **dict.fromkeys(("nonresonant_frequency", "nonresonant_damping"), "p"),
    **dict.fromkeys(("nonresonant_spring", "nonresonant_inertia", "nonresonant_damper"), "pc"),
    **{"mode_shapes": "nm", "contact_shapes": "nc", "nonresonant_shapes": "np"},
    "damping_coupling": "qq",
}

# Modal force of forces that do no work on their mode, relative to the largest force: not 0.
_NO_WORK = 2.0**-100
_ROUNDING = 1e-12  # work that is rounding, relative to the work of the forces on single DOFs


@dataclass(frozen=True, eq=False)
class Reduced:
    """Hold a few modes coupled to the contact problem.

    The displacements are x = mode_shapes q + nonresonant_shapes p + contact_shapes x_c, with the
    retained modes q_j = a_j exp(i theta_j) + c.c. and the nonresonant modes p. The contacts obey::

        mass x_c'' + damping x_c' + stiffness x_c + g = r - 2 Re sum_j L_j a_j exp(i theta_j)

    with the contact forces g, L_j(nu) = spring_j + i nu damper_j, and the response r of the modes
    to each harmonic of x_c. All other modes follow the contacts statically, with the inertia
    `carried_mass`. See "The contact problem" in docs/theory.md, source Eqs. (8), (12) and (13).

    Attributes
    ----------
    formulation : {"consistent", "paper"}
        Formulation, as given to `rom.reduce`.
    modes : tuple of int
        Indices of the retained modes, as given to `rom.reduce`.
    frequency : (modes,) ndarray
        Natural frequencies omega_j with stuck contacts and aerodynamics [rad/s].
    carrier : (modes,) ndarray
        Reference frequencies at which the contact problem is solved [rad/s].
    modal_damping : (modes,) ndarray
        phi_j^T C phi_j plus aerodynamic damping [1/s]; negative for a self-excited mode.
    mode_shapes : (n, modes) ndarray
        Mass-normalised mode shapes [kg^-1/2].
    contact_shapes : (n, N_c) ndarray
        Displacements X of the structure per unit contact displacement [-]: constraint modes, with
        residual flexibility in the consistent formulation.
    mass, damping, stiffness : (N_c, N_c) ndarray
        Matrices of the contact problem [kg], [N s/m], [N/m]; the mass is (W^T M^-1 W)^-1.
    contact_motion : (modes, N_c) complex ndarray
        Contact displacement at the carrier of mode j per amplitude a_j [kg^-1/2], without
        friction; in a table without force patterns, at its largest amplitudes. By reciprocity it
        weights the effect of a force at each contact on the mode.
    carried_mass : (N_c, N_c) ndarray
        Inertia that follows the contacts at the harmonics of the modal response [kg].
    spring, damper : (modes, N_c) ndarray
        Coupling of the retained modes to the contacts [N/m kg^-1/2], [N s/m kg^-1/2]. The
        formulation "paper" has springs alone.
    nonresonant_frequency, nonresonant_damping : (nonresonant,) ndarray
        Natural frequencies [rad/s] and modal damping [1/s] of the nonresonant modes.
    nonresonant_shapes : (n, nonresonant) ndarray
        Mass-normalised shapes of the nonresonant modes [kg^-1/2].
    nonresonant_spring, nonresonant_inertia, nonresonant_damper : (nonresonant, N_c) ndarray
        Coupling to the contacts by springs [N/m kg^-1/2], phi^T M X and phi^T C X.
    damping_coupling : (modes + nonresonant, modes + nonresonant) ndarray
        Modal damping couplings phi_j^T C phi_k [1/s]; 0 on the diagonal.
    contacts : Elements or None
        Elastic contacts, stuck in the modes, with the dual contact problem ("Elastic contacts" in
        docs/theory.md). None: rigid contacts, bonded in the modes.
    force_patterns : (modes, n) ndarray or None
        Force on each mode [-], in any scale, whose quasi-static response is included.
    aerodynamics : (modes,) complex ndarray or None
        Aerodynamic influence coefficients c_j [rad^2/s^2].
    quadratic, cubic : (modes,) * 3, (modes,) * 4 ndarray or None
        Coefficients of `rom.with_nonlinear_stiffness`.
    loss : (modes + nonresonant + N_c, modes + nonresonant + N_c) ndarray or None
        Structural damping K'' on all shapes, whose equivalent at the carriers the damping has.
    spin : (modes, 4) ndarray or None
        Of a rotor (`rom.reduce_rotating`): rise of omega_j^2 per rise of Omega_j^2 from the
        carrier [-], engine order [-], lowest and highest forcing frequency Omega_j [rad/s].
    structure : Structure or None
        Structure that was reduced, for the static response of DOFs. It is not in files.
    tone_numbers : tuple of int
        Tone of each mode if several modes share a tone, otherwise ().
    ratio : float
        Carrier of B relative to A if both are on one tone; otherwise 0.
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
    quadratic: Floats | None = None
    cubic: Floats | None = None
    loss: Floats | None = None
    spin: Floats | None = None
    structure: Structure | None = None
    tone_numbers: tuple[int, ...] = ()
    ratio: float = 0.0

    def __repr__(self) -> str:
        each = zip(self.modes, self.frequency, strict=True)
        modes = ", ".join(f"{number} at {omega:.4g} rad/s" for number, omega in each)
        return (
            f"Reduced({self.formulation}, mode {modes}, {self.n_contacts} contacts, "
            f"{self.nonresonant_frequency.size} nonresonant modes, {self.n_dofs} DOFs)"
        )

    @property
    def mode_names(self) -> list[str]:
        """Names of the modes: A and B, or A, A2, ..., B, B2, ... if they share a tone."""
        return names_on_tones(self.on_tones)

    @property
    def shares_tone(self) -> bool:
        """Whether several modes share a tone, with one force and one carrier."""
        return bool(self.tone_numbers)

    @property
    def on_tones(self) -> list[slice]:
        """The modes of each carrier."""
        return modes_of_tones(self.tone_numbers or range(len(self.modes)))

    @property
    def tones(self) -> int:
        """Number of tones, each with a force and a frequency."""
        return 1 if self.ratio else len(self.on_tones)

    def carriers(self, frequency: Floats) -> Floats:
        """Return the carriers (..., modes) at frequencies of the tones (..., tones) [rad/s]."""
        return frequency * np.array([1.0, self.ratio]) if self.ratio else frequency

    def refuse_shared_tone(self, refusal: str) -> None:
        """Raise SlipmodeError, with this beginning, if the modes share a tone."""
        if self.tones < len(self.modes):
            raise SlipmodeError(f"{refusal}, because the modes share a tone, see rom.reduce")

    def natural_at(self, frequency: Floats) -> Floats:
        """Return omega_j at forcing frequencies (..., modes), or (modes,) if constant [rad/s]."""
        if self.spin is None:
            return self.frequency
        rise = self.spin[:, 0] * (frequency**2 - self.carrier**2)
        return np.asarray(np.sqrt(self.frequency**2 + rise))

    @property
    def n_dofs(self) -> int:
        """Number n of DOFs of the structure."""
        return int(self.mode_shapes.shape[0])

    @property
    def n_contacts(self) -> int:
        """Number N_c of contact DOFs."""
        return int(self.stiffness.shape[0])

    @property
    def even(self) -> bool:
        """Whether the contact motion has even harmonics, including a mean."""
        return self.contacts is not None and not self.contacts.odd

    @cached_property
    def all_shapes(self) -> Floats:
        """Shapes of the retained and the nonresonant modes, (n, modes + nonresonant) [kg^-1/2]."""
        return np.hstack((self.mode_shapes, self.nonresonant_shapes))

    @property
    def structural_frequency(self) -> Floats:
        """Natural frequencies without aerodynamics, (modes,) [rad/s]."""
        if self.aerodynamics is None:
            return self.frequency
        return np.asarray(np.sqrt(self.frequency**2 - self.aerodynamics.real))

    @property
    def aerodynamic_damping(self) -> Floats:
        """Modal damping due to aerodynamics, (modes,) [1/s]."""
        c = np.zeros(len(self.modes)) if self.aerodynamics is None else self.aerodynamics.imag
        return np.asarray(c / self.structural_frequency)

    def held(self, structure: Structure) -> Held:
        """Return what was reduced, with contacts bonded (rigid laws) or stuck (elastic laws)."""
        elements = self.contacts
        return stuck(structure, elements.reference) if elements else bonded(structure)

    def modal_stiffness(self, frequency: ArrayLike) -> Complexes:
        """Return the dynamic stiffness D(nu) of the modes.

        D has omega_j^2 - nu^2 + i gamma_j nu on its diagonal and modal damping couplings
        elsewhere. A rigid-body mode has a unit static stiffness, because contacts do not move it.

        Parameters
        ----------
        frequency : (...) array_like
            Frequencies nu [rad/s].

        Returns
        -------
        (..., modes + nonresonant, modes + nonresonant) complex ndarray
            D(nu) [rad^2/s^2].
        """
        nu = np.asarray(frequency, dtype=float)[..., np.newaxis, np.newaxis]
        at_rest, unit, free, dampers = self._modal_parts
        inertia = nu**2 * unit - (nu == 0.0) * free
        return np.asarray(at_rest - inertia + 1j * nu * dampers + beside_equivalent(self, nu)[0])

    @cached_property
    def _modal_parts(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Parts of D(nu): omega_j^2, 1, 1 for rigid-body modes, and dampers; (all modes)^2."""
        omega = np.append(self.frequency, self.nonresonant_frequency)
        own = np.diag(np.append(self.modal_damping, self.nonresonant_damping))
        unit = np.eye(omega.size)
        return np.diag(omega**2), unit, (omega == 0.0) * unit, own + self.damping_coupling

    def modal_coupling(self, frequency: ArrayLike) -> Complexes:
        """Return the coupling B(nu) of the modes to the contacts.

        The modal response to x_c exp(i nu t) is q = -D^-1 B x_c; the force on the contacts is -B^T
        q.

        Parameters
        ----------
        frequency : (...) array_like
            Frequencies nu [rad/s].

        Returns
        -------
        (..., modes + nonresonant, N_c) complex ndarray
            B(nu) [N/m kg^-1/2].
        """
        nu = np.asarray(frequency, dtype=float)[..., np.newaxis, np.newaxis]
        springs, inertia, dampers = self.coupling_parts
        moved = springs - nu**2 * inertia + 1j * nu * dampers
        return np.asarray(moved + beside_equivalent(self, nu)[1])

    @cached_property
    def coupling_parts(self) -> tuple[Floats, Floats, Floats]:
        """Coupling of all modes to the contacts by springs, inertia, dampers, (all modes, N_c)."""
        return (
            np.vstack((self.spring, self.nonresonant_spring)),
            np.vstack((np.zeros_like(self.spring), self.nonresonant_inertia)),
            np.vstack((self.damper, self.nonresonant_damper)),
        )

    def response(
        self, frequency: ArrayLike, force: Complexes | Floats, held: ArrayLike = False
    ) -> Complexes:
        """Return modal displacements due to modal forces.

        Parameters
        ----------
        frequency : (...) array_like
            Frequencies nu [rad/s].
        force : (..., modes + nonresonant, forces) array
            Modal forces [N kg^-1/2].
        held : (..., modes) or (..., modes + nonresonant) array_like of bool, default False
            Modes whose displacement is 0.

        Returns
        -------
        (..., modes + nonresonant, forces) complex ndarray
            Modal displacements [kg^1/2 m].
        """
        D = self.modal_stiffness(frequency)
        all_held = np.zeros(D.shape[:-1], dtype=bool)
        flags = np.asarray(held)
        all_held[..., : flags.shape[-1] if flags.ndim else len(self.modes)] = flags
        decoupled = all_held[..., np.newaxis] | all_held[..., np.newaxis, :]
        stiffness = np.where(decoupled, np.eye(D.shape[-1]), D)
        on_others = np.where(all_held[..., np.newaxis], 0.0, force)
        return np.asarray(np.linalg.solve(stiffness, on_others), dtype=complex)

    def others_response(self, force: Complexes | Floats) -> Complexes:
        """Return displacements of all modes except j due to modal forces at carrier j, for each j.

        Forces [N kg^-1/2] and displacements [kg^1/2 m] are (modes, modes + nonresonant, forces)
        arrays; the first axis is j.
        """
        return self.response(self.carrier, force, np.eye(len(self.modes), dtype=bool))

    def reaction(self, frequency: ArrayLike, held: ArrayLike = False) -> Complexes:
        """Return the force H(nu) on contacts that move by x_c exp(i nu t), of modes and inertia.

        Parameters
        ----------
        frequency : (...) array_like
            Frequencies nu [rad/s].
        held : (..., modes) or (..., modes + nonresonant) array_like of bool, default False
            Modes that are omitted.

        Returns
        -------
        (..., N_c, N_c) complex ndarray
            H(nu) [N/m].
        """
        B = self.modal_coupling(frequency)
        response = self.response(frequency, B, held)
        return np.asarray(B.swapaxes(-1, -2) @ response + self.following(frequency))

    def following(self, frequency: ArrayLike) -> Complexes:
        """Return the part of `reaction` due to the carried mass, (..., N_c, N_c) [N/m].

        For elastic contacts, whose contact problem has no dampers, it includes `damping`.
        `frequency` (...) are frequencies nu [rad/s].
        """
        nu = np.asarray(frequency, dtype=float)[..., np.newaxis, np.newaxis]
        dampers: Complexes | float = 0.0
        if self.contacts is not None:
            dampers = 1j * nu * self.damping + beside_equivalent(self, nu)[2]
        of_modes = self.nonresonant_inertia.T @ self.nonresonant_inertia
        # Modes that follow statically do so with their inertia below their own frequencies, which
        # are above all others. Beyond, the inertia would be far larger than their response.
        inertia = nu**2 * of_modes
        inertia += np.minimum(nu**2, self.highest_frequency**2) * (self.carried_mass - of_modes)
        return np.asarray(inertia - dampers, dtype=complex)

    @property
    def highest_frequency(self) -> float:
        """Highest natural frequency of the modes that do not follow statically [rad/s]."""
        return float(np.append(self.frequency, self.nonresonant_frequency).max())

    # The modes at their carriers

    @cached_property
    def _at_carriers(self) -> tuple[Complexes, Complexes]:
        """Row D_jk (modes, all modes) and coupling B (modes, all modes, N_c) at carrier j."""
        retained = np.arange(len(self.modes))
        D = self.modal_stiffness(self.carrier)[retained, retained]
        return D, self.modal_coupling(self.carrier)

    @cached_property
    def response_by_dampers(self) -> Complexes:
        """Response of the other modes per a_j by dampers, (modes, modes + nonresonant)."""
        return self.others_response(-self._at_carriers[0][..., np.newaxis])[..., 0]

    @cached_property
    def response_to_contacts(self) -> Complexes:
        """Response of all modes except j to modal forces B_j, (modes, modes + nonresonant, N_c).

        Its transpose gives the forces on the contacts per force on these modes.
        """
        return self.others_response(self._at_carriers[1])

    @cached_property
    def coupling(self) -> Complexes:
        """L_j at its carrier with the response of the other modes, (modes, N_c) [N/m kg^-1/2]."""
        _, B = self._at_carriers
        retained = np.arange(len(self.modes))
        through_others = np.einsum("jm,jmc->jc", self.response_by_dampers, B)
        return np.asarray(B[retained, retained] + through_others)

    @cached_property
    def coupling_coefficients(self) -> Complexes:
        """Coefficients c (modes, 2) that fit L(nu) = (1 + c_0 + i nu c_1) L(carrier) best."""
        L = self.coupling
        rotated = 1j * self.carrier[:, np.newaxis] * self.damper
        parts = np.stack((-rotated, self.damper), axis=1)
        norm = np.sum(np.abs(L) ** 2, axis=1)[:, np.newaxis]
        c = np.einsum("jkc,jc->jk", parts, L.conj())
        return np.asarray(c / np.where(norm > 0, norm, 1.0))

    @cached_property
    def indirect_damping(self) -> Complexes:
        """Force on mode j per a_j through the damping couplings, (modes,) [rad^2/s^2]."""
        return np.asarray(np.sum(self.response_by_dampers * self._at_carriers[0], axis=1))

    # Other models of the same structure

    def at_carrier(self, carrier: Sequence[float]) -> Reduced:
        """Return the model with its contact problem at other reference frequencies.

        Parameters
        ----------
        carrier : sequence of float
            Reference frequencies [rad/s], one per mode.

        Returns
        -------
        Reduced
            Model with these carriers.

        Raises
        ------
        SlipmodeError
            If the formulation is "paper", or a frequency is not positive.
        """
        if self.formulation == "paper":
            raise SlipmodeError(
                'carrier: the "paper" formulation solves contacts at the natural frequencies; '
                'leave carrier out or use formulation="consistent"'
            )
        frequencies = as_floats("carrier", carrier)
        fit = (frequencies >= SMALLEST) & (frequencies <= LARGEST)
        if frequencies.shape != self.frequency.shape or not fit.all():
            raise SlipmodeError(
                f"carrier: must be {self.frequency.size} numbers, {SMALLEST:g} to {LARGEST:g} "
                f"[rad/s], got {carrier}"
            )
        moved = {"frequency": self.natural_at(frequencies), **dampers_at(self, frequencies)}
        return replace(self, carrier=frequencies, **moved)

    def moving(self, contact_motion: Complexes) -> Self:
        """Return the model with another `contact_motion`, and its properties computed so far."""
        other = copy(self)
        object.__setattr__(other, "contact_motion", contact_motion)
        return other

    def modal_force(self, mode: int, force: Mapping[int, float] | ArrayLike) -> float:
        """Return the modal force phi_j^T f on a retained mode.

        Parameters
        ----------
        mode : int
            0 for A, 1 for B.
        force : {DOF: amplitude} or (n,) array_like
            Force amplitudes f [N].

        Returns
        -------
        float
            Modal force [N kg^-1/2]. A force that does no work on the mode has a tiny value instead
            of 0, because its other effects are stated per unit of modal force.

        Raises
        ------
        SlipmodeError
            If a DOF does not exist, or a force is not finite.
        """
        vector = force_vector(force, self.n_dofs)
        modal = float(self.mode_shapes[:, mode] @ vector)
        least = _NO_WORK * float(np.abs(vector).max())
        return modal if abs(modal) > least else least

    def is_moved_by(self, mode: int, force: Mapping[int, float] | ArrayLike) -> bool:
        """Return whether a force acts on a mode, directly or through its contacts.

        Parameters
        ----------
        mode : int
            0 for A, 1 for B.
        force : {DOF: amplitude} or (n,) array_like
            Force amplitudes f [N].

        Returns
        -------
        bool
            True if the force does work on the mode. In the consistent formulation also if it moves
            contacts that are coupled to the mode.
        """
        f = force_vector(force, self.n_dofs)
        largest, shape = float(np.abs(f).max()), self.mode_shapes[:, mode]
        rounding = max(_ROUNDING * float(np.abs(shape) @ np.abs(f)), _NO_WORK * largest)
        if abs(self.modal_force(mode, f)) > rounding:
            return True
        shapes = self.contact_shapes[:, (self.spring[mode] != 0) | (self.damper[mode] != 0)]
        on_contacts = np.abs(shapes.T @ f).max(initial=0.0)
        through_contacts = on_contacts > _ROUNDING * largest * np.abs(shapes).max(initial=0.0)
        return bool(through_contacts and self.formulation == "consistent")
