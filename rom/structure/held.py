"""A structure whose contacts are held, by bonds or springs: its static solutions and modes.

Both use one factorisation of the stiffness, which is kept with the structure until its contacts
are held in another way.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import scipy

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.matrices import (
    BLOCK,
    TOLERANCE,
    Matrix,
    Sparse,
    as_csc,
    as_dense,
)
from slipmode.rom.structure.solvers.factorisation import (
    SMALL,
    Factorisation,
    NotPositiveDefiniteError,
    factorise,
    large_phase,
)
from slipmode.rom.structure.solvers.lowest_modes import (
    dense_modes,
    lowest_modes,
    with_fixed_signs,
)
from slipmode.rom.structure.solvers.mass import contacts_moved
from slipmode.rom.structure.structure import Structure

# A mode is rigid if its strain energy is rounding, relative to the energies of single entries.
# Multiplied or exported matrices have more rounding than that: a mode is rigid too if its omega^2
# is below _ROUNDED times that of the stiffest DOF and _GAP times that of the next mode.
_RIGID, _ROUNDED, _GAP = 1e-13, 1e-9, 1e-6
_ACCURACY = 1e-13  # of static displacements without rigid-body motion

_MODES_ARE_RIGID = (
    "stiffness: must be positive definite with bonded contacts, but the structure then has a "
    "rigid-body mode; fix a DOF or add a contact"
)
_INDEFINITE = "stiffness: must be positive semidefinite with stuck contacts"

_kept: WeakKeyDictionary[Structure, tuple[bytes, Held]] = WeakKeyDictionary()


def massless_when_bonded(structure: Structure) -> Sparse:
    """Return a basis (n, k) of the motions without inertia that leave the contacts at rest."""
    Z = structure.massless
    moved, columns = contacts_moved(Z, structure.directions)
    if not moved.size:
        return Z
    at_rest = scipy.linalg.null_space(moved, rcond=TOLERANCE)
    return as_csc(scipy.sparse.hstack((Z[:, ~columns], Z[:, columns] @ as_csc(at_rest))))


def bonded_mode_count(structure: Structure) -> int:
    """Return the number of modes with bonded contacts."""
    coordinates = structure.n_dofs - structure.n_contacts
    return coordinates - int(massless_when_bonded(structure).shape[1])


def bonded(structure: Structure, *, may_float: bool = False) -> Held:
    """Return the structure with contacts that do not move: W^T x = 0."""

    def held() -> Held:
        parts = structure.partition()
        massless = massless_when_bonded(structure)[parts.elastic_dofs]
        return Held(parts.K_ee, structure.mass, massless, parts.E, may_float=may_float)

    return _kept_or(held, structure, b"floating" if may_float else b"")


def stuck(structure: Structure, reference: Floats) -> Held:
    """Return the structure with springs K + W diag(k_ref) W^T at the contacts.

    `reference` is k_ref (N_c,) [N/m]. The structure may have rigid-body modes.
    """

    def held() -> Held:
        W, K = structure.directions, structure.stiffness
        if isinstance(K, np.ndarray):
            stiffness: Matrix = K + (as_dense(W) * reference) @ as_dense(W).T
        else:
            stiffness = as_csc(K + W @ scipy.sparse.diags_array(reference) @ W.T)
        return Held(stiffness, structure.mass, structure.massless, None, may_float=True)

    return _kept_or(held, structure, reference.tobytes())


def _kept_or(make: Callable[[], Held], structure: Structure, key: bytes) -> Held:
    """Return the kept structure if its contacts are held in this way, else make another."""
    if structure not in _kept or _kept[structure][0] != key:
        _kept.pop(structure, None)  # before the next is made: each may take most of the memory
        _kept[structure] = (key, make())
    return _kept[structure][1]


class Held:
    """A structure with held contacts in free coordinates y, x = basis y, or y = x without a basis.

    The stiffness is (n_h, n_h), the mass (n, n). `massless` (n_h, k) are the free coordinates of
    motions without inertia. `may_float` allows rigid-body modes.
    """

    def __init__(
        self,
        stiffness: Matrix,
        mass: Matrix,
        massless: Sparse,
        basis: Matrix | None,
        *,
        may_float: bool,
    ) -> None:
        self._stiffness = stiffness
        self._mass = mass
        self._massless = massless
        self._basis = basis
        self._may_float = may_float
        self._squares, self._shapes = np.zeros(0), np.zeros((self.size, 0))  # known modes
        self._complete = 0.0  # all modes with omega below this are known
        self._factorised: tuple[Factorisation, float] | None = None

    @property
    def size(self) -> int:
        """The number of modes: free coordinates less motions without inertia."""
        return int(self._massless.shape[0] - self._massless.shape[1])

    def modes(
        self, at_least: int, at_most: int | None = None, reach: float = 0.0
    ) -> tuple[Floats, Floats]:
        """Return the lowest natural frequencies (count,) [rad/s] and modes (n, count).

        Modes are mass-normalised; the largest free coordinate of each is positive. Frequencies of
        rigid-body modes are 0. Between the bounds `at_least` and `at_most`, all modes are returned
        below `reach` times the frequency of mode number `at_least`.
        """
        at_least = min(at_least, self.size)
        most = self.size if at_most is None else min(max(at_most, at_least), self.size)
        known = self._squares.size
        if known < at_least or (known < most and self._highest(at_least, reach) > self._complete):
            self._squares, self._shapes = self._lowest(at_least, most, reach)
            self._complete = self._highest(at_least, reach) * (1.0 + _ACCURACY)
        highest = self._highest(at_least, reach)
        count = int(np.clip(np.searchsorted(self._squares, highest**2), at_least, most))
        return np.sqrt(self._squares[:count]), self._all_dofs(self._shapes[:, :count])

    def solve(self, load: Any) -> Floats:
        """Return static displacements (n, loads) [m] due to loads (n, loads) [N].

        If there are rigid-body modes: the part that is M-orthogonal to them, under the load in
        balance with their inertia.
        """
        displacement = np.empty(load.shape)
        for start in range(0, load.shape[1], BLOCK):
            large_phase(self.size, f"static shapes, {start} of {load.shape[1]}")
            block = slice(start, start + BLOCK)
            part = as_dense(load[:, block])
            part = part if self._basis is None else as_dense(self._basis.T @ part)
            if self._may_float and self._rigid().any():
                displacement[:, block] = self._all_dofs(self._balanced(part))
            else:
                displacement[:, block] = self._all_dofs(self._factors()[0].solve(part))
        return displacement

    def rigid_body_modes(self) -> Floats:
        """Return the mass-normalised modes (n, count) without strain energy; often none."""
        rigid = self._rigid()  # it may have to compute the shapes
        return self._all_dofs(self._shapes[:, rigid])

    def _highest(self, at_least: int, reach: float) -> float:
        """Return `reach` times the frequency of a known mode."""
        return reach * float(np.sqrt(self._squares[at_least - 1]))

    def _all_dofs(self, free: Floats) -> Floats:
        return free if self._basis is None else as_dense(self._basis @ free)

    def _inertia(self, free: Floats) -> Floats:
        """Return M y for motions y (n_h, k)."""
        if self._basis is None:
            return as_dense(self._mass @ free)
        return as_dense(self._basis.T @ (self._mass @ (self._basis @ free)))

    def _stiffest(self) -> float:
        """Return about the largest omega^2 of a single DOF."""
        return float(self._stiffness.diagonal().max() / self._mass.diagonal().max())

    def _factors(self) -> tuple[Factorisation, float]:
        """Return a factorisation of K + shift M, and the shift: 0 if K is positive definite."""
        if self._factorised is None:
            try:
                factors = factorise(self._stiffness)
                singular = self._may_float and self._is_singular(factors)
                self._factorised = self._shifted() if singular else (factors, 0.0)
            except NotPositiveDefiniteError as error:
                if self._may_float:
                    self._factorised = self._shifted()
                elif self.size <= SMALL and not self._is_rigid(*self._dense(1)).any():
                    raise error from None  # singular by rounding
                else:
                    raise SlipmodeError(_MODES_ARE_RIGID) from None
        return self._factorised

    def _is_singular(self, factors: Factorisation) -> bool:
        """Return whether inverse iteration ends in a rigid-body mode: K is singular to rounding.

        Other modes do not converge with such factors.
        """
        shape = np.random.default_rng(0).standard_normal((self._massless.shape[0], 1))
        for _ in range(2):
            shape = factors.solve(self._inertia(shape))
            shape /= np.sqrt(np.vdot(shape, self._inertia(shape)))
        energy = np.vdot(shape, as_dense(self._stiffness @ shape))
        return bool(self._is_rigid(np.array([energy]), shape)[0])

    def _shifted(self) -> tuple[Factorisation, float]:
        # K + shift M is positive definite
        shift = 1e-8 * self._stiffest()
        mass: Any = self._mass
        if self._basis is not None:
            mass = self._basis.T @ mass @ self._basis
        lifted: Any = self._stiffness + shift * mass
        try:
            return factorise(lifted), shift
        except NotPositiveDefiniteError:
            raise SlipmodeError(_INDEFINITE) from None

    def _lowest(self, at_least: int, at_most: int, reach: float) -> tuple[Floats, Floats]:
        """Return omega^2 and modes, at least those that `modes` returns."""
        if self.size <= SMALL or 4 * at_least > self.size:
            squares, shapes = self._dense(min(2 * at_least + 16, self.size))
            if squares[-1] < reach**2 * squares[at_least - 1]:
                squares, shapes = self._dense(at_most)
        else:
            squares, shapes = self._krylov(at_least, at_most, reach)
            if self._is_rigid(squares, shapes).any() and self._may_float:
                self._factorised = self._shifted()  # K was singular to rounding
                squares, shapes = self._krylov(at_least, at_most, reach)
        rigid = self._is_rigid(squares, shapes)
        if rigid.any() and not self._may_float:
            raise SlipmodeError(_MODES_ARE_RIGID)
        squares[rigid] = 0.0
        if squares.min() < 0.0:
            raise SlipmodeError(_INDEFINITE)
        return squares, shapes

    def _krylov(self, at_least: int, at_most: int, reach: float) -> tuple[Floats, Floats]:
        factors, shift = self._factors()

        def solve(load: Floats) -> Floats:
            large_phase(self.size, "modes")
            return factors.solve(load)

        # eight modes show the gap after rigid-body modes, of which six are possible
        squares, shapes = lowest_modes(
            solve,
            self._inertia,
            self._massless.shape[0],
            max(at_least, 8) if self._may_float else at_least,
            lambda lifted: reach**2 * float(lifted[at_least - 1] - shift) + shift,
            min(at_most, self.size),
        )
        return squares - shift, shapes

    def _dense(self, count: int) -> tuple[Floats, Floats]:
        inertia = self._inertia(np.eye(self._massless.shape[0]))
        mass = 0.5 * (inertia + inertia.T)
        squares, shapes = dense_modes(as_dense(self._stiffness), mass, self._massless, count)
        return squares, with_fixed_signs(shapes)

    def _is_rigid(self, squares: Floats, shapes: Floats) -> Flags:
        """Return which modes (count,), ascending, store no energy beyond rounding."""
        size, energy = np.abs(shapes), np.abs(squares)
        entries = np.einsum("nk,nk->k", size, as_dense(abs(self._stiffness) @ size))
        small = energy[:-1] <= _ROUNDED * self._stiffest()
        gaps = np.flatnonzero(small & (energy[:-1] <= _GAP * energy[1:]))
        below = np.arange(energy.size) <= gaps.max(initial=-1)
        return np.asarray((energy <= _RIGID * entries) | below)

    def _rigid(self) -> Flags:
        """Return which of the known modes are rigid-body modes; all rigid ones are known then."""
        count = BLOCK
        while self._squares.size == 0 or (
            self._squares[-1] == 0.0 and self._squares.size < self.size
        ):
            self.modes(count)
            count *= 2
        return np.asarray(self._squares == 0.0)

    def _balanced(self, load: Floats) -> Floats:
        """Return static displacements (n_h, loads) without rigid-body motion.

        Solutions with K + shift M are refined. The known modes are corrected, so the error falls
        by shift / omega^2 of the next mode in each pass.
        """
        factors, shift = self._factors()
        if shift == 0.0:
            factors, shift = self._factorised = self._shifted()
        rigid = self._rigid()
        R, shapes, squares = self._shapes[:, rigid], self._shapes[:, ~rigid], self._squares[~rigid]
        inertia = self._inertia(R)
        correction = 1.0 / squares - 1.0 / (squares + shift)
        displacement, change, before = np.zeros_like(load), np.inf, np.inf
        residual = load - inertia @ (R.T @ load)
        while True:
            step = factors.solve(residual)
            step += (shapes * correction) @ (shapes.T @ residual)
            step -= R @ (inertia.T @ step)
            displacement += step
            before, change = change, float(np.linalg.norm(step))
            converged = change <= _ACCURACY * np.linalg.norm(displacement)
            if converged or not change <= 0.5 * before:
                return displacement
            residual = load - inertia @ (R.T @ load) - as_dense(self._stiffness @ displacement)
            residual -= inertia @ (R.T @ residual)
