"""A structure of equal sectors: the matrices of one, and how it meets the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import Rayleigh, SlipmodeError, Structure
from slipmode.rom.common import Complexes, Finding, as_complexes, in_one_line, warn
from slipmode.rom.cyclic.aerodynamics import Aerodynamics
from slipmode.rom.structure import (
    Elimination,
    Matrix,
    MatrixLike,
    as_csc,
    as_matrix,
    as_symmetric,
    checked_damping,
    eliminate,
)


@dataclass(frozen=True, init=False, eq=False, repr=False)
class CyclicStructure:
    """Represent a ring of equal sectors with friction contacts, by the matrices of one sector.

    Sector j has the displacements u_j (n,) [m]. Its DOFs `right` are the DOFs `left` of sector
    j + 1. Its contact displacements are x_c = contact^T u_j + next_contact^T u_(j+1).

    Parameters
    ----------
    mass : (n, n) array or sparse matrix
        Mass matrix of one sector [kg], symmetric, and positive definite after `right` is joined to
        `left`.
    stiffness : (n, n) array or sparse matrix
        Stiffness matrix of one sector without contacts [N/m], symmetric.
    sectors : int
        Number of sectors N, at least 3.
    damping : float, Rayleigh or (n, n) array or sparse matrix, default 0.0
        A number is beta [s] of C = beta K. `Rayleigh` stands for C = alpha M + beta K. A matrix is
        C [N s/m] of one sector.
    contact : sequence of int, or (n, N_c) array or sparse matrix
        Contact DOFs of each sector, or their directions [-].
    next_contact : (n, N_c) array or sparse matrix, optional
        Directions of the contacts on the next sector [-]. For relative displacements they have the
        opposite sign of `contact`; in scenes `next_contacts` has this sign. Default: contacts
        within each sector only.
    blade : (n, n) array or sparse matrix, optional
        Part of the stiffness that differs between the blades of a mistuned disk [N/m], symmetric.
        Default: the complete stiffness.
    left, right : sequence of int, optional
        DOFs on the two sides of the sector, in corresponding order and in the directions of the
        sector. Default: neighbouring sectors are connected by contacts only.

    Attributes
    ----------
    sectors : int
        Number of sectors N.
    mass, stiffness, damping, blade : (n, n) CSC matrix
        Matrices of one sector [kg], [N/m], [N s/m], [N/m].
    beta : float
        Stiffness-proportional damping [s], also of `blade`; 0 if a matrix C was given.
    own_directions, next_directions : (n, N_c) CSC matrix
        Directions of the contacts on a sector and on the next sector [-].
    aerodynamics : Aerodynamics or None
        Aerodynamic forces from `with_aerodynamics`.
    left, right : (pairs,) ndarray of int
        DOFs on the two sides.

    Raises
    ------
    SlipmodeError
        If the sides have different numbers of DOFs, or a DOF is on both sides or occurs twice. If
        a matrix has a wrong shape, is not symmetric, or has a DOF without mass.

    Warns
    -----
    ValidityWarning
        If `next_contact` has the sign of `contact`, so that the displacements are added.
    """

    sectors: int
    mass: Matrix
    stiffness: Matrix
    damping: Matrix
    blade: Matrix
    beta: float
    own_directions: Matrix
    next_directions: Matrix
    left: NDArray[np.intp]
    right: NDArray[np.intp]
    aerodynamics: Aerodynamics | None

    def __init__(
        self,
        mass: MatrixLike,
        stiffness: MatrixLike,
        sectors: int,
        damping: float | Rayleigh | MatrixLike = 0.0,
        *,
        contact: MatrixLike,
        next_contact: MatrixLike | None = None,
        blade: MatrixLike | None = None,
        left: Sequence[int] = (),
        right: Sequence[int] = (),
    ) -> None:
        sectors = checked_integer("sectors", sectors, ">= 3", 3)
        M = as_csc(as_symmetric("mass", mass))
        size = M.shape[0]
        K = as_csc(as_symmetric("stiffness", stiffness, size))
        C: Any = checked_damping(damping, size)
        beta = 0.0
        if isinstance(C, Rayleigh):
            C, beta = C.alpha * M + C.beta * K, C.beta
        sides = [distinct(name, dofs, size) for name, dofs in (("left", left), ("right", right))]
        both = np.intersect1d(sides[0], sides[1]).size
        if len(sides[0]) != len(sides[1]) or both:
            raise SlipmodeError(
                f"left, right: must be as many DOFs on either side, none on both, got "
                f"{len(sides[0])} and {len(sides[1])}, {both} on both"
            )
        W = _directions("contact", contact, size)
        following = (
            W * 0.0 if next_contact is None else _directions("next_contact", next_contact, size)
        )
        if following.shape != W.shape:
            raise SlipmodeError(
                f"next_contact: must have shape {W.shape} like contact, got {following.shape}"
            )
        vars(self).update(
            sectors=sectors,
            mass=M,
            stiffness=K,
            damping=as_csc(C),
            blade=K if blade is None else as_csc(as_symmetric("blade", blade, size)),
            beta=beta,
            own_directions=W,
            next_directions=following,
            left=sides[0],
            right=sides[1],
            aerodynamics=None,
        )
        if np.any(self.of_diameter(0)[0].diagonal().real <= 0.0):
            raise SlipmodeError("mass: every DOF must have mass after right is joined to left")
        warn(_added(W, following))

    def __repr__(self) -> str:
        return (
            f"CyclicStructure({self.sectors} sectors of {self.free_dofs.size} DOFs, "
            f"{self.n_contacts} contacts each)"
        )

    def with_aerodynamics(
        self, directions: MatrixLike, influence: Mapping[int, ArrayLike], frequency: float
    ) -> CyclicStructure:
        """Return the structure with aerodynamic forces between its blades.

        Blade j has the displacements q_j = D^T u_j. The forces are -D sum_d l_d q_(j+d) while all
        blades move at the frequency omega_0. A wave of nodal diameter k has the coefficient c_k =
        sum_d l_d exp(i k d 2 pi / N). Re c_k > 0 adds stiffness, and Im c_k > 0 adds damping.

        Parameters
        ----------
        directions : sequence of int, or (n, m) array or sparse matrix
            Matrix D, or DOFs. With DOFs, q are displacements [m] and the coefficients are in N/m.
            With D = M phi and mass-normalised modes phi, q are modal amplitudes and the
            coefficients are modal [rad^2/s^2].
        influence : {distance: complex or (m, m) array_like}
            Influence l_d of blade j + d on blade j [N/m] or [rad^2/s^2], for instance for d = -2
            to 2. If coefficients L are defined by forces +L q, give -L.
            `rom.influence_coefficients` converts coefficients of nodal diameters.
        frequency : float
            Frequency omega_0 [rad/s], near the natural frequency of the mode family.

        Returns
        -------
        CyclicStructure
            Structure with these forces.

        Raises
        ------
        SlipmodeError
            If an argument has a wrong shape or is not finite.

        Notes
        -----
        At other frequencies the forces are -D sum_d (Re l_d + Im l_d / omega_0 d/dt) q_(j+d), with
        a real stiffness and damping between sectors. They are equivalent to l_d at omega_0 only.
        """
        D = _directions("directions", directions, self.mass.shape[0])
        other = copy(self)
        vars(other)["aerodynamics"] = Aerodynamics.of(D, influence, frequency, self.sectors)
        return other

    @property
    def n_contacts(self) -> int:
        """Number N_c of contact DOFs of one sector."""
        return int(self.own_directions.shape[1])

    @cached_property
    def free_dofs(self) -> NDArray[np.intp]:
        """DOFs of a sector without `right`, (n_s,) ndarray of int, ascending."""
        return np.setdiff1d(np.arange(self.mass.shape[0]), self.right)

    @cached_property
    def condensed(self) -> Elimination:
        """The sector's stiffness, condensed to its sides and contacts."""
        own: Any = abs(self.own_directions)
        motion = own + abs(self.next_directions)
        moving = np.flatnonzero(motion.sum(axis=1))
        boundary = np.unique(np.concatenate((self.left, self.right, moving)))
        return eliminate(self.stiffness, boundary)

    @property
    def highest_diameter(self) -> int:
        """Largest nodal diameter, N // 2."""
        return self.sectors // 2

    def angle(self, nodal_diameter: int) -> float:
        """Return the phase of the next sector in a travelling wave.

        Parameters
        ----------
        nodal_diameter : int
            Nodal diameter k.

        Returns
        -------
        float
            k 2 pi / N [rad], 0 for multiples of N.
        """
        return 2.0 * np.pi * (nodal_diameter % self.sectors) / self.sectors

    def expansion(self, nodal_diameter: int) -> Any:
        """Return the displacements of sector 0 in a travelling wave, from its free DOFs.

        Sector j moves as exp(i k 2 pi j / N) times sector 0.

        Parameters
        ----------
        nodal_diameter : int
            Nodal diameter k.

        Returns
        -------
        (n, n_s) complex CSC array
            Matrix T of u_0 = T u_free [-].
        """
        size = self.mass.shape[0], self.free_dofs.size
        later, columns = divmod(self._places, size[1])
        values = np.exp(1j * self.angle(nodal_diameter) * later)
        return scipy.sparse.csc_array((values, (np.arange(size[0]), columns)), shape=size)

    @cached_property
    def _places(self) -> NDArray[np.intp]:
        """Place of each DOF of sector 0 among the free DOFs of sectors 0 and 1, (n,)."""
        places = np.empty(self.mass.shape[0], dtype=np.intp)
        places[self.free_dofs] = np.arange(self.free_dofs.size)
        places[self.right] = places[self.left] + self.free_dofs.size
        return places

    def force_on_sector(self, force: Mapping[int, complex] | ArrayLike) -> Complexes:
        """Return a force as amplitudes on the free DOFs of a sector.

        Parameters
        ----------
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes [N].

        Returns
        -------
        (n_s,) complex ndarray
            Amplitudes [N].

        Raises
        ------
        SlipmodeError
            If a DOF does not exist, or an amplitude is not finite.
        """
        size = self.free_dofs.size
        if isinstance(force, Mapping):
            vector = np.zeros(size, dtype=complex)
            for dof, value in force.items():
                if not (isinstance(dof, int | np.integer) and 0 <= dof < size):
                    raise SlipmodeError(f"force: DOFs must be 0 to {size - 1}, got {dof}")
                vector[dof] = value
        else:
            vector = as_complexes("force", force)
        if vector.shape != (size,) or not np.isfinite(vector).all():
            raise SlipmodeError(
                f"force: must be {{DOF: amplitude}} or {size} finite numbers, got "
                f"{in_one_line(force)}"
            )
        return vector

    def of_diameter(self, nodal_diameter: int) -> tuple[Any, Any, Any]:
        """Return the matrices of a nodal diameter.

        Parameters
        ----------
        nodal_diameter : int
            Nodal diameter k.

        Returns
        -------
        mass, damping, stiffness : (n_s, n_s) CSC array
            T^H M T [kg], T^H C T [N s/m] and T^H K T [N/m], Hermitian.
        """
        T = self.expansion(nodal_diameter)
        matrices = (self.mass, self.damping, self.stiffness)
        return tuple((T.conj().T @ (each @ T)).tocsc() for each in matrices)

    def contact_motion(self, nodal_diameter: int) -> Any:
        """Return the contact displacements of sector 0 per displacement of its free DOFs.

        Parameters
        ----------
        nodal_diameter : int
            Nodal diameter k of the travelling wave.

        Returns
        -------
        (N_c, n_s) complex CSC array
            Contact displacements [-].
        """
        turned = np.exp(1j * self.angle(nodal_diameter)) * self.next_directions
        return ((self.own_directions + turned).T @ self.expansion(nodal_diameter)).tocsc()

    def annulus(self, deviation: ArrayLike | None = None) -> Structure:
        """Return all sectors as one structure.

        Parameters
        ----------
        deviation : (N,) array_like, optional
            Relative stiffness deviation of each blade [-]: sector j has the additional stiffness
            deviation_j times `blade`. Default: equal blades.

        Returns
        -------
        Structure
            Structure with n_s N DOFs and N_c N contact DOFs, sector by sector.

        Raises
        ------
        SlipmodeError
            If the structure has aerodynamic forces, whose matrices are not symmetric.
        """
        self.refuse_aerodynamics("annulus")
        N, (n, size) = self.sectors, (self.mass.shape[0], self.free_dofs.size)
        of_blade = np.zeros(N) if deviation is None else np.asarray(deviation, dtype=float)
        sector = np.arange(N)
        # Displacements of all sectors, with both sides, from the displacements of the annulus
        places = (self._places + size * sector[:, np.newaxis]).ravel() % (N * size)
        T: Any = scipy.sparse.csc_array(
            (np.ones(n * N), (np.arange(n * N), places)), shape=(n * N, size * N)
        )

        def around(matrix: Any, between: Any) -> Any:
            """Return the matrix of all sectors from one sector's, with factors (N, N) between."""
            return T.T @ scipy.sparse.kron(between, matrix, format="csc")

        one = scipy.sparse.eye_array(N)
        before = scipy.sparse.coo_array((np.ones(N), ((sector + 1) % N, sector)))
        M, K, C = (around(each, one) @ T for each in (self.mass, self.stiffness, self.damping))
        further = around(self.blade, scipy.sparse.diags_array(of_blade)) @ T
        contact = around(self.own_directions, one) + around(self.next_directions, before)
        return Structure(M, K + further, C + self.beta * further, contact=contact)

    def refuse_aerodynamics(self, name: str) -> None:
        """Check that the structure has no aerodynamic forces.

        Parameters
        ----------
        name : str
            Name of the function that does not include them, for the message.

        Raises
        ------
        SlipmodeError
            If the structure has aerodynamic forces.
        """
        if self.aerodynamics is not None:
            raise SlipmodeError(
                f"aerodynamics: {name} does not include these forces; give the structure without "
                "aerodynamics"
            )

    def around(self, wave: Complexes, nodal_diameter: int) -> Complexes:
        """Return a travelling wave at all DOFs of the annulus.

        Parameters
        ----------
        wave : (n_s, ...) complex ndarray
            Displacements of sector 0 [m].
        nodal_diameter : int
            Nodal diameter k.

        Returns
        -------
        (n_s N, ...) complex ndarray
            Displacements of all sectors [m].
        """
        turn = np.exp(1j * self.angle(nodal_diameter) * np.arange(self.sectors))
        return np.concatenate([each * wave for each in turn])


def excited_diameter(engine_order: int, sectors: int) -> int:
    """Return the nodal diameter that an engine order excites.

    Engine orders that differ by a multiple of the number of sectors N are aliased: they excite one
    nodal diameter.

    Parameters
    ----------
    engine_order : int
        Engine order, >= 1.
    sectors : int
        Number of sectors N.

    Returns
    -------
    int
        Nodal diameter, -(N // 2) to N // 2; negative for a backward wave.

    Examples
    --------
    >>> rom.excited_diameter(21, 24)
    -3
    """
    k = engine_order % sectors
    return k if 2 * k <= sectors else k - sectors


def checked_integer(name: str, given: int, allowed: str, least: int, most: int = 2**62) -> int:
    """Return an integer from `least` to `most`; refuse others, saying what is `allowed`."""
    integer = isinstance(given, int | np.integer) and not isinstance(given, bool)
    if not (integer and least <= given <= most):
        raise SlipmodeError(f"{name}: must be an integer {allowed}, got {in_one_line(given)}")
    return int(given)


def distinct(name: str, given: ArrayLike, size: int, of: str = "DOFs") -> NDArray[np.intp]:
    """Return different numbers of DOFs, or of nodes, from 0 to size - 1; refuse others."""
    found = np.asarray(given)
    if found.size == 0:
        return np.zeros(0, dtype=np.intp)
    if found.ndim != 1 or found.dtype.kind not in "iu" or np.unique(found).size != found.size:
        raise SlipmodeError(f"{name}: must be different {of}, got {in_one_line(given)}")
    if found.min() < 0 or found.max() >= size:
        raise SlipmodeError(f"{name}: {of} must be 0 to {size - 1}, got {in_one_line(given)}")
    return found.astype(np.intp)


def _added(own: Matrix, following: Matrix) -> list[Finding]:
    """Report the first contact whose directions on both sectors all have one sign."""
    signs = np.ones(own.shape[1])
    for each in (own, following):
        low, high = (bound(axis=0).toarray().ravel() for bound in (each.min, each.max))
        signs *= np.sign(low + high) * (low * high >= 0.0)
    reason = "their displacements are added; for the relative displacement give the opposite sign"
    return [
        Finding("next_contact", f"has the sign of contact at contact {k}", reason, "warning")
        for k in np.flatnonzero(signs > 0.0)[:1]
    ]


def _directions(name: str, contact: MatrixLike, size: int) -> Any:
    given: Any = contact if scipy.sparse.issparse(contact) else np.asarray(contact)
    if given.ndim == 1:
        dofs = distinct(name, given, size)
        ones = np.ones(dofs.size)
        return scipy.sparse.csc_array((ones, (dofs, np.arange(dofs.size))), (size, dofs.size))
    W = as_csc(as_matrix(name, contact))
    if W.shape[0] != size or W.shape[1] == 0:
        raise SlipmodeError(f"{name}: must have {size} rows and at least 1 column, got {W.shape}")
    return W
