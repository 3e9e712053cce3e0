"""One factorisation of a symmetric positive definite matrix, for any number of solutions.

Dense matrices by LAPACK, sparse ones by PARDISO (`pip install 'slipmode[fast]'`) or, without it,
by SuperLU in the order of nested_dissection.py.
"""

from __future__ import annotations

import importlib.util
import logging
import weakref
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.progress import phase
from slipmode.rom.structure.matrices import BLOCK, Matrix, Sparse, as_csc, as_dense
from slipmode.rom.structure.solvers.nested_dissection import nested_dissection

_log = logging.getLogger(__name__)

LARGE = 20_000  # DOFs from which a factorisation takes a second
SMALL = 500  # DOFs up to which dense algorithms are faster
_GIB = 2.0**30
_FASTER = "pip install 'slipmode[fast]' (PARDISO) needs less time and memory"

_SINGULAR = (
    "mass, stiffness: must be positive definite with bonded contacts, up to rounding; model "
    "parts that are stiffer or heavier than others by a factor of 1e15 as rigid"
)


class NotPositiveDefiniteError(SlipmodeError):
    """A matrix that should be positive definite is not, or only to rounding."""

    def __init__(self) -> None:
        super().__init__(_SINGULAR)


class Factorisation(Protocol):
    """Factorisation of a matrix A (n, n)."""

    def solve(self, right: Floats) -> Floats:
        """Return A^-1 right, for right-hand sides (n,) or (n, m)."""


def factorise(matrix: Matrix, name: str = "stiffness") -> Factorisation:
    """Factorise a symmetric positive definite matrix, which messages call `name`.

    Refuses with NotPositiveDefiniteError a matrix that is not positive definite, or (dense) only
    to rounding; and before the work starts if there is not enough memory.
    """
    diagonal = matrix.diagonal()
    if not np.all(diagonal > 0):
        raise NotPositiveDefiniteError
    if isinstance(matrix, np.ndarray) or matrix.shape[0] <= SMALL:
        return Cholesky(as_dense(matrix))
    purpose = f"factorising {name} ({matrix.shape[0]} DOFs)"
    large_phase(matrix.shape[0], f"ordering {name} ({matrix.shape[0]} DOFs)")
    if importlib.util.find_spec("pypardiso") is not None:
        return Pardiso(matrix, purpose)
    return SuperLU(matrix, purpose)


class Cholesky:
    """LAPACK, with rows and columns scaled so that their units do not matter."""

    def __init__(self, matrix: Floats) -> None:
        self._unit = np.exp2(-np.round(0.5 * np.log2(matrix.diagonal())))
        scaled = self._unit[:, np.newaxis] * matrix * self._unit
        try:
            self._factor = scipy.linalg.cho_factor(scaled, check_finite=False)
        except scipy.linalg.LinAlgError:
            raise NotPositiveDefiniteError from None
        norm = np.abs(scaled).sum(axis=0).max()
        inverse_condition, _ = scipy.linalg.lapack.dpocon(self._factor[0], norm)
        if inverse_condition < np.finfo(float).eps:
            raise NotPositiveDefiniteError

    def solve(self, right: Floats) -> Floats:
        """Return A^-1 right."""
        unit = self._unit if right.ndim == 1 else self._unit[:, np.newaxis]
        return np.asarray(unit * scipy.linalg.cho_solve(self._factor, unit * right))


class Pardiso:
    """Intel's PARDISO, by pypardiso; its analysis states the memory that it will need.

    Rows of the matrix (n, n) given as `boundary` (b,) are not eliminated: see `Elimination`.
    """

    def __init__(
        self, matrix: Sparse, purpose: str, boundary: NDArray[np.intp] | None = None
    ) -> None:
        import pypardiso
        from pypardiso.pardiso_wrapper import PyPardisoError

        upper = scipy.sparse.triu(matrix, format="csr")
        upper.sort_indices()
        self._upper: Any = upper
        self._solver: Any = pypardiso.PyPardisoSolver(mtype=2)
        self.boundary = np.zeros(0, dtype=np.intp) if boundary is None else boundary
        if self.boundary.size:
            self._solver.perm = np.zeros(matrix.shape[0], dtype=np.int32)
            self._solver.perm[self.boundary] = 1
            # no defaults; order by nested dissection; two-level factorisation and sequential
            # solutions, both faster; Schur complement of the boundary, and factors
            for number, value in ((1, 1), (2, 2), (24, 1), (25, 1), (36, 2)):
                self._solver.set_iparm(number, value)
        schur = np.zeros(self.boundary.size**2)
        self._run(11, schur)
        peak, permanent, factors = (1024.0 * self._solver.get_iparm(k) for k in (15, 16, 17))
        needed = max(peak, permanent + factors)
        _check_memory(needed, purpose)
        large_phase(matrix.shape[0], f"{purpose} by PARDISO, {needed / _GIB:.1f} GiB")
        try:
            schur = self._run(22, schur)
        except PyPardisoError as error:
            self._solver.free_memory(everything=True)
            if error.value == -2:  # not enough memory
                raise SlipmodeError(f"{purpose}: not enough memory") from error
            raise NotPositiveDefiniteError from None
        self.schur = schur.reshape(2 * self.boundary.shape)
        weakref.finalize(self, self._solver.free_memory, everything=True).atexit = False

    def solve(self, right: Floats) -> Floats:
        """Return A^-1 right."""
        return _by_blocks(lambda part: self._run(33, part), right)

    def forward(self, right: Floats) -> Floats:
        """Return the right-hand sides (n, m) after elimination of the interior."""
        return _by_blocks(lambda part: self._run(331, part), right)

    def backward(self, reduced: Floats) -> Floats:
        """Return solutions (n, m) from those of the boundary and from `forward`."""
        return _by_blocks(lambda part: self._run(333, part), reduced)

    def _run(self, step: int, right: Floats) -> Floats:
        # pypardiso's own solve would compare the matrix with a copy at every call
        self._solver.set_phase(step)
        return np.asarray(self._solver._call_pardiso(self._upper, np.asfortranarray(right)))


class SuperLU:
    """scipy's LU with diagonal pivots only: L D L^T, D = diag(U)."""

    def __init__(self, matrix: Sparse, purpose: str) -> None:

        self._order, fill = nested_dissection(matrix)
        # bytes per entry of L: L and U with their indices, and scipy's copy for the pivots
        needed = 45.0 * fill
        _check_memory(needed, purpose, f"; {_FASTER}")
        large_phase(matrix.shape[0], f"{purpose} by SuperLU, about {needed / _GIB:.1f} GiB")
        if matrix.shape[0] >= LARGE:
            _log.warning("%s by SuperLU: about %.1f GiB; %s", purpose, needed / _GIB, _FASTER)
        try:
            self._factors = scipy.sparse.linalg.splu(
                as_csc(matrix[self._order][:, self._order]),
                permc_spec="NATURAL",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # exactly singular
            raise NotPositiveDefiniteError from None
        same_order = np.array_equal(self._factors.perm_r, self._factors.perm_c)
        if not (same_order and (self._factors.U.diagonal() > 0).all()):  # Sylvester's criterion
            raise NotPositiveDefiniteError

    def solve(self, right: Floats) -> Floats:
        """Return A^-1 right."""
        solution = np.empty_like(right)
        solution[self._order] = _by_blocks(self._factors.solve, right[self._order])
        return solution


def large_phase(size: int, text: str) -> None:
    """Show a phase of work on matrices whose size makes it take a second or more."""
    if size >= LARGE:
        phase(text)


def _check_memory(needed: float, purpose: str, advice: str = "") -> None:
    """Refuse work that needs more memory [bytes] than is free, if the system states that."""
    available = available_memory()
    if available is not None and needed > available:
        raise SlipmodeError(
            f"{purpose}: needs about {needed / _GIB:.1f} GiB of memory, "
            f"but {available / _GIB:.1f} GiB are free{advice}"
        )


def available_memory() -> float | None:
    """Return the free memory [bytes], with that of caches; None if it is not known."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    entries = dict(line.split(":", 1) for line in lines)
    return float(entries["MemAvailable"].split()[0]) * 1024.0


def _by_blocks(solve: Any, right: Floats) -> Floats:
    """Return solutions for BLOCK right-hand sides at a time."""
    if right.ndim == 1:
        return np.asarray(solve(right[:, np.newaxis]))[:, 0]
    solution = np.empty(right.shape)
    for start in range(0, right.shape[1], BLOCK):
        block = slice(start, start + BLOCK)
        solution[:, block] = solve(right[:, block])
    return solution
