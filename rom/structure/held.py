"""A structure whose contacts are held, by bonds or springs: solutions and modes of it.

All of it is by one factorisation, which is kept with the structure until its contacts are held
in another way.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import scipy.linalg
import scipy.sparse

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.progress import phase
from slipmode.rom.structure.matrices import Matrix, as_csc, as_dense
from slipmode.rom.structure.solvers.factorisation import (
    LARGE,
    Factorisation,
    NotPositiveDefiniteError,
    factorise,
)
from slipmode.rom.structure.solvers.lowest_modes import lowest_modes, turned
from slipmode.rom.structure.structure import Structure

_DENSE_SIZE = 500  # up to here a dense eigenvalue problem is the faster one
_RIGID = 1e-13  # strain energy of a mode that is rounding, relative to that of its entries
# Where matrices have been multiplied or exported, it is more than theirs: omega^2 of a rigid-body
# mode, over that of the stiffest DOF, and over that of the first elastic mode.
_ROUNDED = 1e-9
_GAP = 1e-6
_FREE = 8  # modes by which that gap is seen: six may be rigid
_SHIFT = 1e-8  # of the stiffest DOF: mass that holds a structure with rigid-body modes
_BLOCK = 16  # loads at a time
_PASSES = 30
_ACCURACY = 1e-13

_MODES_ARE_RIGID = (
    "stiffness: must be positive definite with bonded contacts, but the structure has a "
    "rigid-body mode then; fix a DOF or add a contact"
)

_INDEFINITE = "stiffness: must be positive semidefinite with stuck contacts"

_kept: WeakKeyDictionary[Structure, tuple[bytes, Held]] = WeakKeyDictionary()


def bonded(structure: Structure, *, may_float: bool = False) -> Held:
    """The structure with contacts that do not move: W^T x = 0."""

    def held() -> Held:
        parts = structure.partition()
        return Held(parts.K_ee, structure.mass, parts.E, may_float=may_float)

    return _keep(structure, b"floating" if may_float else b"", held)


def stuck(structure: Structure, reference: Floats) -> Held:
    """The structure with springs (N_c,) [N/m] at the contacts; it may have rigid-body modes."""

    def held() -> Held:
        return Held(stuck_stiffness(structure, reference), structure.mass, None, may_float=True)

    return _keep(structure, reference.tobytes(), held)


def stuck_stiffness(structure: Structure, reference: Floats) -> Matrix:
    """K + W diag(k_ref) W^T, dense or CSC like the structure."""
    W = structure.directions
    if isinstance(structure.stiffness, np.ndarray):
        dense = as_dense(W)
        return np.asarray(structure.stiffness + (dense * reference) @ dense.T)
    return as_csc(structure.stiffness + W @ scipy.sparse.diags_array(reference) @ W.T)


class Held:
    """A structure with held contacts.

    Parameters
    ----------
    stiffness : (n_h, n_h) matrix
        K in the coordinates y that are left, x = basis y.
    mass : (n, n) matrix
        M of the structure.
    basis : (n, n_h) matrix or None
        None: y is x.
    may_float : bool
        Whether rigid-body modes are allowed.
    """

    def __init__(
        self, stiffness: Matrix, mass: Matrix, basis: Matrix | None, *, may_float: bool
    ) -> None:
        self._stiffness = stiffness
        self._mass = mass
        self._basis = basis
        self._may_float = may_float
        self._squares, self._shapes = np.zeros(0), np.zeros((self.size, 0))
        self._factorised: tuple[Factorisation, float] | None = None
        self._complete = 0.0  # all modes with omega below this are known

    @property
    def size(self) -> int:
        """The number n_h of modes."""
        return int(self._stiffness.shape[0])

    def modes(
        self,
        at_least: int,
        highest: float = 0.0,
        at_most: int | None = None,
        reach: float = 0.0,
    ) -> tuple[Floats, Floats]:
        """Lowest natural frequencies (count,) [rad/s] and modes (n, count).

        Mass-normalised; the largest component of each mode, in the coordinates that are left, is
        positive. Frequencies of rigid-body modes are 0.

        Parameters
        ----------
        at_least, at_most : int
            How many.
        highest : float, default 0.0
            Between these, modes below this frequency [rad/s] are wanted.
        reach : float, default 0.0
            And those below so many times the frequency of the last that is wanted at least.

        Raises
        ------
        SlipmodeError
            If there are rigid-body modes and may not be.
        """
        at_least = min(at_least, self.size)
        most = self.size if at_most is None else min(max(at_most, at_least), self.size)
        known = self._squares.size
        if known >= at_least:
            highest = max(highest, reach * float(np.sqrt(self._squares[at_least - 1])))
        if known < at_least or (highest > self._complete and known < most):
            self._squares, self._shapes = self._lowest(at_least, highest, most, reach)
            highest = max(highest, reach * float(np.sqrt(self._squares[at_least - 1])))
            self._complete = highest * (1.0 + _ACCURACY)
        count = int(np.clip(np.searchsorted(self._squares, highest**2), at_least, most))
        return np.sqrt(self._squares[:count]), self._all_dofs(self._shapes[:, :count])

    def solve(self, load: Any) -> Floats:
        """Static displacement (n, loads) [m] by loads (n, loads) [N], dense or sparse.

        Where there are rigid-body modes, what is M-orthogonal to them, by the load that is in
        balance with their inertia.
        """
        displacement = np.empty(load.shape)
        for start in range(0, load.shape[1], _BLOCK):
            self._tell(f"static shapes, {start} of {load.shape[1]}")
            block = slice(start, start + _BLOCK)
            part = as_dense(load[:, block])
            part = part if self._basis is None else as_dense(self._basis.T @ part)
            displacement[:, block] = self._all_dofs(self._solved(part))
        return displacement

    def rigid_body_modes(self) -> Floats:
        """Modes (n, count) that strain nothing, mass-normalised; often none."""
        rigid = self._rigid()  # which may be what finds the shapes
        return self._all_dofs(self._shapes[:, rigid])

    def _tell(self, text: str) -> None:
        if self.size >= LARGE:
            phase(text)

    def _all_dofs(self, held: Floats) -> Floats:
        return held if self._basis is None else as_dense(self._basis @ held)

    def _heavy(self, held: Floats) -> Floats:
        """M y."""
        if self._basis is None:
            return as_dense(self._mass @ held)
        return as_dense(self._basis.T @ (self._mass @ (self._basis @ held)))

    def _factors(self) -> tuple[Factorisation, float]:
        """Of K + shift M, and the shift: 0 where K is positive definite."""
        if self._factorised is None:
            try:
                self._factorised = factorise(self._stiffness), 0.0
            except NotPositiveDefiniteError as error:
                if not self._may_float:
                    raise self._refusal(error) from None
                self._factorised = self._shifted()
        return self._factorised

    def _shifted(self) -> tuple[Factorisation, float]:
        shift = float(_SHIFT * self._stiffness.diagonal().max() / self._mass.diagonal().max())
        try:
            lifted: Any = self._stiffness + shift * self._mass
            return factorise(lifted), shift
        except NotPositiveDefiniteError:
            raise SlipmodeError(_INDEFINITE) from None

    def _refusal(self, error: SlipmodeError) -> SlipmodeError:
        """Why a stiffness could not be factorised: rigid-body modes, or rounding."""
        if self.size <= _DENSE_SIZE:
            squares, shapes = self._dense(1)
            if not self._is_rigid(squares, shapes).any():
                return error
        return SlipmodeError(_MODES_ARE_RIGID)

    def _lowest(
        self, at_least: int, highest: float, at_most: int, reach: float
    ) -> tuple[Floats, Floats]:
        """omega^2 and modes, as `modes` wants them."""

        def limit(squares: Floats) -> float:
            return float(max(highest**2, reach**2 * squares[at_least - 1]))

        if self.size <= _DENSE_SIZE or 4 * at_least > self.size:
            squares, shapes = self._dense(min(2 * at_least + 16, self.size))
            if squares[-1] < limit(squares):
                squares, shapes = self._dense(at_most)
        else:
            squares, shapes = self._krylov(at_least, limit, at_most)
            if self._is_rigid(squares, shapes).any() and self._may_float:
                self._factorised = self._shifted()  # what was factorised is singular to rounding
                squares, shapes = self._krylov(at_least, limit, at_most)
        rigid = self._is_rigid(squares, shapes)
        if rigid.any() and not self._may_float:
            raise SlipmodeError(_MODES_ARE_RIGID)
        squares[rigid] = 0.0
        if squares.min() < 0.0:
            raise SlipmodeError(_INDEFINITE)
        return squares, shapes

    def _krylov(
        self, at_least: int, limit: Callable[[Floats], float], at_most: int
    ) -> tuple[Floats, Floats]:
        factors, shift = self._factors()
        if self._may_float:
            at_least = max(at_least, _FREE)

        def solve(load: Floats) -> Floats:
            self._tell("modes")
            return factors.solve(load)

        squares, shapes = lowest_modes(
            *(solve, self._heavy, self.size, at_least),
            lambda lifted: limit(lifted - shift) + shift,
            at_most,
        )
        return squares - shift, shapes

    def _dense(self, count: int) -> tuple[Floats, Floats]:
        K = as_dense(self._stiffness)
        M = self._heavy(np.eye(self.size))
        squares, shapes = scipy.linalg.eigh(K, 0.5 * (M + M.T), subset_by_index=(0, count - 1))
        return squares, turned(shapes)

    def _is_rigid(self, squares: Floats, shapes: Floats) -> Flags:
        """Which modes, ascending, store no energy beyond rounding."""
        size, energy = np.abs(shapes), np.abs(squares)
        entries = np.einsum("nk,nk->k", size, as_dense(abs(self._stiffness) @ size))
        small = energy <= _ROUNDED * self._stiffness.diagonal().max() / self._mass.diagonal().max()
        gaps = np.flatnonzero(small[:-1] & (energy[:-1] <= _GAP * energy[1:]))
        below = np.arange(energy.size) <= (gaps[-1] if gaps.size else -1)
        return np.asarray((energy <= _RIGID * entries) | below)

    def _solved(self, load: Floats) -> Floats:
        """K^-1 load, (n_h, loads)."""
        if self._may_float and self._rigid().any():
            return self._balanced(load)
        factors, _ = self._factors()
        return factors.solve(load)

    def _rigid(self) -> Flags:
        """Which of the modes that are known are rigid-body modes: all these are."""
        count = _BLOCK
        while self._squares.size == 0 or (
            not self._squares[-1] and self._squares.size < self.size
        ):
            self.modes(count)
            count *= 2
        return np.asarray(self._squares == 0.0)

    def _balanced(self, load: Floats) -> Floats:
        """The same without rigid-body modes, by refinement of what K + shift M gives.

        With the modes that are known put right, the error falls by shift / omega^2 of the next.
        """
        factors, shift = self._factors()
        if shift == 0.0:
            factors, shift = self._factorised = self._shifted()
        rigid = self._rigid()
        R, shapes, squares = self._shapes[:, rigid], self._shapes[:, ~rigid], self._squares[~rigid]
        heavy = self._heavy(R)
        residual = load - heavy @ (R.T @ load)
        displacement, change = np.zeros_like(load), np.inf
        for _ in range(_PASSES):
            step = factors.solve(residual)
            right = 1.0 / squares - 1.0 / (squares + shift)
            step += (shapes * right) @ (shapes.T @ residual)
            step -= R @ (heavy.T @ step)
            displacement += step
            before, change = change, float(np.linalg.norm(step))
            if change <= _ACCURACY * np.linalg.norm(displacement) or change > 0.5 * before:
                break
            residual = load - heavy @ (R.T @ load) - as_dense(self._stiffness @ displacement)
            residual -= heavy @ (R.T @ residual)
        return displacement


def _keep(structure: Structure, key: bytes, make: Any) -> Held:
    """The held structure that is kept, if it is held in that way; else a new one."""
    if structure in _kept and _kept[structure][0] == key:
        return _kept[structure][1]
    _kept.pop(structure, None)  # before the next is made: each may take most of the memory
    held: Held = make()
    _kept[structure] = (key, held)
    return held
