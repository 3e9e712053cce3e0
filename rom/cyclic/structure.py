"""A structure of equal sectors: the matrices of one, and how it meets the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Complexes, Floats, in_one_line
from slipmode.rom.cyclic.aerodynamics import Aerodynamics
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.damping import Rayleigh
from slipmode.rom.structure.matrices import (
    Matrix,
    MatrixLike,
    as_csc,
    as_matrix,
    as_symmetric,
)
from slipmode.rom.structure.solvers.elimination import Elimination, eliminate
from slipmode.rom.structure.structure import Structure, checked_damping


@dataclass(frozen=True, init=False, eq=False, repr=False)
class CyclicStructure:
    """A ring of equal sectors, with friction contacts inside the sectors or between neighbours.

    Sector j has the displacements u_j (n,). Its DOFs `right` are the DOFs `left` of sector j + 1.
    Its contacts move by x_c = contact^T u_j + next_contact^T u_(j+1).

    Parameters
    ----------
    mass : (n, n) array or sparse matrix
        Of one sector [kg], symmetric; positive definite once `right` is joined to `left`.
    stiffness : (n, n) array or sparse matrix
        Of one sector without contacts [N/m], symmetric.
    sectors : int
        Number of sectors N, at least 3.
    damping : float, Rayleigh or (n, n) array or sparse matrix, default 0.0
        beta [s] of C = beta K, C = alpha M + beta K, or C itself [N s/m].
    left, right : sequence of int, optional
        The same number of DOFs on either side, in the order in which they meet, in the directions
        of their own sector. Default: none, sectors touch at contacts alone.
    contact : sequence of int, or (n, N_c) array or sparse matrix
        DOFs, or directions W [-], of the contacts of each sector.
    next_contact : (n, N_c) array or sparse matrix, optional
        Directions on the next sector, of contacts between neighbours. Default: none.
    blade : (n, n) array or sparse matrix, optional
        Part of the stiffness that differs from blade to blade in a mistuned disk [N/m], symmetric.
        Default: all of it.

    Attributes
    ----------
    sectors : int
    mass, stiffness, damping, blade : (n, n) CSC matrix
        Of one sector.
    beta : float
        Damping [s] per stiffness, also of the part in which blades differ; 0 if C was given.
    own_directions, next_directions : (n, N_c) CSC matrix
        `contact` and `next_contact`.
    aerodynamics : Aerodynamics or None
        See `with_aerodynamics`.
    left, right : (pairs,) ndarray of int

    Raises
    ------
    SlipmodeError
        If sectors do not fit: another number of DOFs on either side, DOFs on both sides or twice;
        if a matrix is not as stated above.
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
        sectors = checked_sectors(sectors)
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
        further = (
            W * 0.0 if next_contact is None else _directions("next_contact", next_contact, size)
        )
        if further.shape != W.shape:
            raise SlipmodeError(
                f"next_contact: must have shape {W.shape} like contact, got {further.shape}"
            )
        fields = {
            "sectors": sectors,
            "mass": M,
            "stiffness": K,
            "damping": as_csc(C),
            "blade": K if blade is None else as_csc(as_symmetric("blade", blade, size)),
            "beta": beta,
            "own_directions": W,
            "next_directions": further,
            "left": sides[0],
            "right": sides[1],
            "aerodynamics": None,
        }
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        if np.any(self.of_diameter(0)[0].diagonal().real <= 0.0):
            raise SlipmodeError("mass: every DOF must have mass after right is joined to left")

    def __repr__(self) -> str:
        return (
            f"CyclicStructure({self.sectors} sectors of {self.free_dofs.size} DOFs, "
            f"{self.n_contacts} contacts each)"
        )

    def with_aerodynamics(
        self, directions: MatrixLike, influence: Mapping[int, ArrayLike], frequency: float
    ) -> CyclicStructure:
        """Return the structure with aerodynamic forces between its blades.

        Blade j has the displacements q_j = D^T u_j, and the forces -D sum_d l_d q_(j+d) while all
        move at the frequency omega_0. In a wave of nodal diameter k the coefficient is
        c_k = sum_d l_d exp(i k d 2 pi / N): Re c_k > 0 stiffens, Im c_k > 0 damps. Coefficients
        with which the force is +L q have the opposite sign, l = -L.

        Parameters
        ----------
        directions : sequence of int, or (n, m) array or sparse matrix
            DOFs, or D. With DOFs q are displacements [m] and coefficients are in N/m. With
            D = M phi of mass-normalised modes phi q are their amplitudes, and coefficients are
            modal [rad^2/s^2].
        influence : {distance: complex or (m, m) array_like}
            l_d: influence of blade j + d on blade j, for instance of d = -2 to 2. See
            `influence_coefficients` for coefficients of nodal diameters.
        frequency : float
            omega_0 [rad/s], about the natural frequency of the family.

        Notes
        -----
        At other frequencies the forces are -D sum_d (Re l_d + Im l_d / omega_0 d/dt) q_(j+d), by a
        real stiffness and damping between sectors. These are equivalent to l_d at omega_0 alone.
        """
        D = _directions("directions", directions, self.mass.shape[0])
        other = copy(self)
        forces = Aerodynamics.of(D, influence, frequency, self.sectors)
        object.__setattr__(other, "aerodynamics", forces)
        return other

    @property
    def n_contacts(self) -> int:
        """Number N_c of contact directions of a sector."""
        return int(self.own_directions.shape[1])

    @cached_property
    def free_dofs(self) -> NDArray[np.intp]:
        """DOFs of a sector that are not those of the next one, (n_s,), ascending."""
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
        """The largest nodal diameter, N // 2."""
        return self.sectors // 2

    def angle(self, nodal_diameter: int) -> float:
        """Return the phase of the next sector [rad]; exact multiples of N are 0."""
        return 2.0 * np.pi * (nodal_diameter % self.sectors) / self.sectors

    def expansion(self, nodal_diameter: int) -> Any:
        """Return T (n, n_s): all DOFs of sector 0 from its free DOFs, in a travelling wave.

        Sector j moves like exp(i k 2 pi j / N) times sector 0, with the nodal diameter k.
        """
        rows = np.concatenate((self.free_dofs, self.right))
        column = np.full(self.mass.shape[0], -1)
        column[self.free_dofs] = np.arange(self.free_dofs.size)
        columns = np.concatenate((column[self.free_dofs], column[self.left]))
        phase = np.exp(1j * self.angle(nodal_diameter))
        values = np.concatenate((np.ones(self.free_dofs.size), np.full(self.right.size, phase)))
        shape = (self.mass.shape[0], self.free_dofs.size)
        return scipy.sparse.csc_array((values, (rows, columns)), shape=shape)

    def force_on_sector(self, force: Mapping[int, complex] | ArrayLike) -> Complexes:
        """Return {DOF: amplitude}, or amplitudes, as forces on the free DOFs (n_s,) [N]."""
        size = self.free_dofs.size
        if isinstance(force, Mapping):
            vector = np.zeros(size, dtype=complex)
            for dof, value in force.items():
                if not (isinstance(dof, int | np.integer) and 0 <= dof < size):
                    raise SlipmodeError(f"force: DOFs must be 0 to {size - 1}, got {dof}")
                vector[dof] = value
        else:
            vector = np.array(force, dtype=complex)
        if vector.shape != (size,) or not np.isfinite(vector).all():
            raise SlipmodeError(
                f"force: must be {{DOF: amplitude}} or {size} finite numbers, got "
                f"{in_one_line(force)}"
            )
        return vector

    def of_diameter(self, nodal_diameter: int) -> tuple[Any, Any, Any]:
        """Return mass, damping and stiffness of a nodal diameter, (n_s, n_s) Hermitian CSC."""
        T = self.expansion(nodal_diameter)
        matrices = (self.mass, self.damping, self.stiffness)
        return tuple((T.conj().T @ (each @ T)).tocsc() for each in matrices)

    def contact_motion(self, nodal_diameter: int) -> Any:
        """Return the contact displacements of sector 0 per free DOF, (N_c, n_s) CSC, complex."""
        turned = np.exp(1j * self.angle(nodal_diameter)) * self.next_directions
        return ((self.own_directions + turned).T @ self.expansion(nodal_diameter)).tocsc()

    def annulus(self, deviation: ArrayLike | None = None) -> Structure:
        """Return all sectors as one structure: n_s N DOFs and N_c N contacts, sector by sector.

        `deviation` (N,) of a mistuned disk: sector j has deviation_j times the stiffness `blade`
        in addition. A structure with aerodynamic forces is refused: they are not symmetric.
        """
        self.refuse_aerodynamics("annulus")
        N = self.sectors
        of_blade = np.zeros(N) if deviation is None else np.asarray(deviation, dtype=float)

        sectors = [self._of_sector(j) for j in range(N)]

        def around(matrix: Any, factors: Floats) -> Any:
            """Return the sum over sectors of factor_j T_j^T matrix T_j."""
            return sum(c * (T.T @ (matrix @ T)) for c, T in zip(factors, sectors, strict=True))

        mass, stiffness, damping = (
            around(each, np.ones(N)) for each in (self.mass, self.stiffness, self.damping)
        )
        further = around(self.blade, of_blade)
        contacts = [
            own.T @ self.own_directions + after.T @ self.next_directions
            for own, after in zip(sectors, [*sectors[1:], sectors[0]], strict=True)
        ]
        return Structure(
            mass,
            stiffness + further,
            damping + self.beta * further,
            contact=scipy.sparse.hstack(contacts),
        )

    def refuse_aerodynamics(self, name: str) -> None:
        """Refuse aerodynamic forces for what does not include them."""
        if self.aerodynamics is not None:
            raise SlipmodeError(
                f"aerodynamics: {name} does not include these forces; give the structure without "
                "aerodynamics"
            )

    def around(self, wave: Complexes, nodal_diameter: int) -> Complexes:
        """Return a travelling wave at all DOFs of the annulus, (n_s N, ...), from sector 0."""
        turn = np.exp(1j * self.angle(nodal_diameter) * np.arange(self.sectors))
        return np.concatenate([each * wave for each in turn])

    def _of_sector(self, j: int) -> Any:
        """Return the DOFs of sector j from those of the annulus, (n, n_s N)."""
        size, n, N = self.free_dofs.size, self.mass.shape[0], self.sectors
        place = np.empty(n, dtype=np.intp)
        place[self.free_dofs] = j * size + np.arange(size)
        place[self.right] = (place[self.left] + size) % (N * size)
        ones = np.ones(n)
        return scipy.sparse.csc_array((ones, (np.arange(n), place)), shape=(n, size * N))


def excited_diameter(engine_order: int, sectors: int) -> int:
    """Return the nodal diameter that an engine order excites, from -(N // 2) to N // 2.

    Engine orders that differ by multiples of the number N of sectors load the sectors alike: they
    are aliased. A negative nodal diameter is a wave that travels backward.

    Parameters
    ----------
    engine_order, sectors : int
        From 1.
    """
    k = engine_order % sectors
    return k if 2 * k <= sectors else k - sectors


def checked_sectors(sectors: int) -> int:
    """Return a number of sectors; refuse other values."""
    if isinstance(sectors, bool) or not isinstance(sectors, int | np.integer) or sectors < 3:
        raise SlipmodeError(f"sectors: must be an integer >= 3, got {in_one_line(sectors)}")
    return int(sectors)


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
