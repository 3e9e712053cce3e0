"""Harmonic balance with alternating frequency and time, for one or two forcing frequencies.

x_c = sum_k 2 Re X_k exp(i (n_k t_A + m_k t_B)) over the odd harmonics |n| + |m| <= highest. The
linear part is condensed to the contacts: with H_k = W^T Z(nu_k)^-1 W and Z the dynamic stiffness,

    H_k^-1 X_k + G_k(X) = H_k^-1 W^T Z(nu_k)^-1 F_k,

where G_k are the harmonics of the friction force on a grid over the torus. Newton's method takes
its Jacobian from the harmonics of the slope g'(v), d G_k / d X_l = i nu_l g'_(k - l), which take
one more transform.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.fft import next_fast_len

from benchmarks.cases import Case
from slipmode import rom
from slipmode.rom.arrays import Complexes
from slipmode.rom.laws.friction import limits
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.structure.matrices import as_dense

_OVERSAMPLING = 4  # grid points per harmonic and period
_LEAST_GRID = 16  # grid points: few harmonics need more against aliasing
_TOLERANCE = 1e-9  # residual over the friction limit
_NEWTON_STEPS = 25
_FIRST_ALPHA = 1.0  # alpha of the first law [m/s]
_SHARPENING = 0.4  # factor from one alpha to the next


@dataclass(frozen=True, eq=False)
class Balance:
    """A steady motion."""

    contact: Complexes  # X_k (harmonics, N_c) [m]
    displacement: Complexes  # carriers (modes, n) of every DOF, x = 2 Re(... exp(i t_j)) [m]
    newton_steps: int


class HarmonicBalance:
    """The equations of a case, condensed to its contacts.

    Parameters
    ----------
    case : Case
        With tanh friction; modes without a force are left out.
    highest : int
        Largest |n| + |m|.
    """

    def __init__(self, case: Case, highest: int) -> None:
        assert isinstance(case.law, rom.Tanh)
        s, patterns = case.structure, case.excitation.patterns
        self.forced = np.flatnonzero(np.any(patterns != 0.0, axis=1))
        self._alpha = case.law.alpha
        self._limit = limits(case.law, s.n_contacts)
        self._orders = np.array(harmonic_orders(highest, self.forced.size))
        n, m = self._orders.T
        self._apart = np.subtract.outer(n, n), np.subtract.outer(m, m)
        size = max(next_fast_len(_OVERSAMPLING * highest), _LEAST_GRID)
        self._grid = (size, size if self.forced.size == 2 else 1)
        self._sums = tuple(
            np.add.outer(k, k) % count for k, count in zip((n, m), self._grid, strict=True)
        )
        self._matrices = tuple(as_dense(part) for part in (s.mass, s.damping, s.stiffness))
        self._directions = as_dense(s.directions)
        self._loads = np.concatenate([self._directions, 0.5 * patterns[self.forced].T], axis=1)
        self._condense(case.frequency)

    def at(self, frequency: Sequence[float]) -> Self:
        """Return the same equations at other forcing frequencies [rad/s]."""
        other = copy(self)
        other._condense(frequency)
        return other

    def _condense(self, frequency: Sequence[float]) -> None:
        """Linear responses to the friction forces and to the excitation, at every harmonic."""
        M, C, K = self._matrices
        W, loads = self._directions, self._loads
        self._nu = self._orders[:, : self.forced.size] @ np.array(frequency)[self.forced]
        Z = K - np.multiply.outer(self._nu**2, M) + 1j * np.multiply.outer(self._nu, C)
        responses = np.linalg.solve(Z, np.broadcast_to(loads, (self._nu.size, *loads.shape)))
        contacts = W.shape[1]
        self._receptance, excitation = responses[..., :contacts], responses[..., contacts:]
        carriers = np.arange(self.forced.size)  # the first harmonics belong to the forces
        self._driven = excitation[carriers, :, carriers]
        self._stiffness = np.linalg.inv(W.T @ self._receptance)
        self._linear = np.zeros((self._nu.size, contacts), dtype=complex)
        self._linear[carriers] = self._driven @ W

    def solve(self, start: Complexes | None = None) -> Balance:
        """Solve from a neighbouring solution, or through sharper and sharper laws."""
        if start is not None:
            X, steps = self._newton(start, self._alpha)
            if steps <= _NEWTON_STEPS:
                return self._balance(X, steps)
        X, alpha, total = self._linear, max(_FIRST_ALPHA, self._alpha), 0
        while True:
            X, steps = self._newton(X, alpha)
            total += steps
            if alpha == self._alpha:
                if steps > _NEWTON_STEPS:
                    raise rom.SlipmodeError("harmonic balance: Newton's method does not converge")
                return self._balance(X, total)
            alpha = max(_SHARPENING * alpha, self._alpha)

    def _balance(self, X: Complexes, steps: int) -> Balance:
        carriers = slice(0, self._driven.shape[0])
        force = np.einsum("kij,kj->ki", self._stiffness, self._linear - X)[carriers]
        moved = self._driven - np.einsum("knc,kc->kn", self._receptance[carriers], force)
        return Balance(X, moved, steps)

    def _newton(self, X: Complexes, alpha: float) -> tuple[Complexes, int]:
        """Solution and number of steps, one more than _NEWTON_STEPS where it does not converge."""
        residual, slope = self._residual(X, alpha)
        for step in range(_NEWTON_STEPS):
            size = np.abs(residual).max()
            if size <= _TOLERANCE * self._limit.max():
                return X, step
            change = self._newton_change(residual, slope)
            for shortening in 0.5 ** np.arange(8):
                trial = X + shortening * change
                residual, slope = self._residual(trial, alpha)
                if np.abs(residual).max() < size:
                    break
            X = trial
        return X, _NEWTON_STEPS + 1

    def _residual(self, X: Complexes, alpha: float) -> tuple[Complexes, Complexes]:
        """Residual forces (harmonics, N_c), and the spectrum of g'(v) on the grid."""
        spectrum = np.zeros((*self._grid, X.shape[1]), dtype=complex)
        n, m = self._orders.T
        spectrum[n, m] = 1j * self._nu[:, np.newaxis] * X
        v = 2.0 * np.fft.ifft2(spectrum, axes=(0, 1), norm="forward").real
        force = np.tanh(v / alpha)
        G = self._limit * np.fft.fft2(force, axes=(0, 1), norm="forward")[n, m]
        slope = np.fft.fft2((1.0 - force**2) / alpha, axes=(0, 1), norm="forward") * self._limit
        return np.einsum("kij,kj->ki", self._stiffness, X - self._linear) + G, slope

    def _newton_change(self, residual: Complexes, slope: Complexes) -> Complexes:
        """Solve J dX = -residual in real and imaginary parts: G depends on X and on conj X."""
        count, contacts = residual.shape
        inu = 1j * self._nu
        a = np.zeros((count, contacts, count, contacts), dtype=complex)
        b = np.zeros_like(a)
        each = np.arange(count)
        a[each, :, each, :] = self._stiffness
        for c in range(contacts):
            a[:, c, :, c] += slope[(*self._apart, c)] * inu
            b[:, c, :, c] = slope[(*self._sums, c)] * inu.conj()
        size = count * contacts
        plus, minus = (a + b).reshape(size, size), (a - b).reshape(size, size)
        J = np.block([[plus.real, -minus.imag], [plus.imag, minus.real]])
        r = residual.ravel()
        y = np.linalg.solve(J, -np.concatenate([r.real, r.imag]))
        return (y[:size] + 1j * y[size:]).reshape(residual.shape)
