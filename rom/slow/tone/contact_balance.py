"""Contacts in balance with all modes at the frequencies of one or two tones, by Newton's method.

    x_k = x_0k + G_k (y_k(x) - s x_k)

has the displacements x_k (N_c,) of the contacts at the carriers, and under two tones also at
harmonics near a mode, x_0 by the forces alone, the flexibility G of the structure and the force
deficits y of the contacts. The structure that has G is without the springs s of the contacts: all
of k_ref, or 0 if its contacts are stuck.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import UnsettledError
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.tone.coupled_contacts import CoupledContacts
from slipmode.rom.table.local.local_contacts import LocalContacts

_ITERATIONS, _HALVINGS = 60, 8
# Relative change of x at which iterations end: with local contacts, and with coupled ones, which
# are as exact as their march.
_CONVERGED, _COUPLED = 1e-6, 1e-5
_CORRECTIONS = 10  # that Anderson's acceleration keeps


@frozen
class _Iterate:
    """A state with coupled contacts, and a step of Newton's method; (orders, N_c) each."""

    drive: Complexes
    x: Complexes
    y: Complexes
    harmonics: Complexes  # of the force deficits, (orders, N_c)
    step: Complexes  # of x
    change: Complexes  # of the drive


@frozen
class ContactBalance:
    """Structures with the same contacts and frequencies, such as mistuning patterns of a disk.

    Attributes
    ----------
    frequency : (tones,) ndarray
        [rad/s]
    flexibility : (structures, orders, N_c, N_c) complex ndarray
        G [m/N].
    moved : (structures, orders, N_c) complex ndarray
        x_0 [m].
    local : LocalContacts
    springs : (N_c,) ndarray
        s [N/m].
    """

    frequency: Floats
    flexibility: Complexes
    moved: Complexes
    local: LocalContacts
    springs: Floats

    def with_local_contacts(self, start: Complexes | None) -> tuple[Complexes, Complexes]:
        """Return x and y (structures, tones, N_c), from a guess of x or else from stuck contacts.

        The structures are given at the carriers alone.

        Raises
        ------
        UnsettledError
            If no state is found.
        """
        x = self._stuck() if start is None else start
        y, by_x, by_conjugate = self.local(x)
        off = self._residual(x, y)
        for _ in range(_ITERATIONS):
            step = self._step(off, by_x, by_conjugate)
            # Along Newton's direction, as far as the residual falls.
            length, before = np.ones((len(x), 1, 1)), _norm(off)
            for _ in range(_HALVINGS):
                tried = x + length * step
                y, by_x, by_conjugate = self.local(tried)
                off = self._residual(tried, y)
                after = _norm(off)
                worse = after > (1.0 - 0.1 * length) * before + np.finfo(float).tiny
                if not worse.any():
                    break
                length[worse] *= 0.5
            x = tried
            if np.all(_norm(step) <= _CONVERGED * _norm(x)):
                return x, y
        raise self._unsettled()

    def with_coupled_contacts(
        self,
        contacts: Sequence[CoupledContacts],
        x: Complexes,
        harmonics: Complexes | None = None,
    ) -> tuple[Complexes, Complexes]:
        """Return x, and all harmonics of y, of contacts that act on each other at harmonics, too.

        From the state x with local contacts, whose derivatives Newton's method keeps, or from a
        result on fewer steps; Anderson's acceleration improves the steps of Newton's method.
        `contacts` are the contacts of each structure.

        Raises
        ------
        UnsettledError
            If no state is found.
        """
        guesses = [None] * len(x) if harmonics is None else list(harmonics)
        found = [
            self._single(k)._coupled(contacts[k], x[k], guess) for k, guess in enumerate(guesses)
        ]
        return np.array([each[0] for each in found]), np.array([each[1] for each in found])

    def corrected(
        self, contacts: CoupledContacts, x: Complexes, harmonics: Complexes
    ) -> Complexes:
        """Return y after a step of Newton's method from x (orders, N_c), of one structure.

        `harmonics` (orders, N_c) are of y at x; `contacts` may have more of them.
        """
        slopes = self._with_slopes(x)[1:]
        drive = x - _times(contacts.far, harmonics[: len(x)])
        at = self._iterate(contacts, slopes, drive, harmonics)
        return np.asarray(at.y + _changes(slopes, at.step))

    def _single(self, number: int) -> ContactBalance:
        """Return one of the structures."""
        own = slice(number, number + 1)
        G, moved = self.flexibility[own], self.moved[own]
        return ContactBalance(self.frequency, G, moved, self.local, self.springs)

    def _coupled(
        self, contacts: CoupledContacts, x: Complexes, guess: Complexes | None
    ) -> tuple[Complexes, Complexes]:
        """Return x and harmonics of a single structure, from x (orders, N_c) and a guess."""
        y, *slopes = self._with_slopes(x)
        start = x - _times(contacts.far, y if guess is None else guess[: len(x)])
        last = self._iterate(contacts, slopes, start, guess)

        def correction(given: Floats) -> Floats:
            nonlocal last
            drive = given.view(complex)
            if not np.array_equal(drive, last.drive):
                last = self._iterate(contacts, slopes, drive, last.harmonics)
            return last.change.view(float)

        closest = _COUPLED * float(np.linalg.norm(x))
        if np.linalg.norm(last.change) > closest:  # scipy refuses a residual of 0
            anderson: Any = scipy.optimize.anderson  # its types allow one number only
            try:
                anderson(
                    correction,
                    start.view(float),
                    alpha=1.0,
                    M=min(_CORRECTIONS, 2 * start.size),
                    maxiter=_ITERATIONS,
                    f_tol=closest,
                    tol_norm=np.linalg.norm,
                    line_search=None,
                )
            except (scipy.optimize.NoConvergence, ValueError):
                raise self._unsettled() from None
        return last.x, last.harmonics

    def _with_slopes(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y of local contacts and its derivatives, at x (orders, N_c) of one structure.

        Local contacts have no force deficits at harmonics beside the carriers. Their slopes are
        there, as of any small motion, the mean slopes at the carriers.
        """
        orders, contacts = x.shape
        tones = self.frequency.size
        y, slopes = np.zeros_like(x), np.zeros((2, orders, orders, contacts), dtype=complex)
        y[:tones], slopes[0, :tones, :tones], slopes[1, :tones, :tones] = self.local(x[:tones])
        others = np.arange(tones, orders)
        slopes[0, others, others] = np.einsum("ttc->c", slopes[0]) / tones
        return y, slopes[0], slopes[1]

    def _iterate(
        self,
        contacts: CoupledContacts,
        slopes: Sequence[Complexes],
        drive: Complexes,
        guess: Complexes | None = None,
    ) -> _Iterate:
        """Return the state at a drive (orders, N_c) of a single structure, and its Newton step.

        `slopes` (orders, orders, N_c) are the derivatives of y by x and by conj(x), `guess` the
        harmonics of another iterate.
        """
        harmonics = contacts.deficit(drive, guess)
        y = harmonics[: len(drive)]
        x = drive + _times(contacts.far, y)
        by_x, by_conjugate = (each[np.newaxis] for each in slopes)
        step = self._step(self._residual(x[np.newaxis], y[np.newaxis]), by_x, by_conjugate)[0]
        change = step - _times(contacts.far, _changes(slopes, step))
        return _Iterate(drive, x, y, harmonics, step, change)

    @cached_property
    def _left(self) -> Complexes:
        """1 + G s, (structures, orders, N_c, N_c)."""
        return np.asarray(np.eye(self.springs.size) + self.flexibility * self.springs)

    def _stuck(self) -> Complexes:
        """Return x with stuck contacts, which have no force deficit."""
        return np.asarray(np.linalg.solve(self._left, self.moved[..., np.newaxis])[..., 0])

    def _residual(self, x: Complexes, y: Complexes) -> Complexes:
        return _times(self._left, x) - self.moved - _times(self.flexibility, y)

    def _step(self, off: Complexes, by_x: Complexes, by_conjugate: Complexes) -> Complexes:
        """Return dx of J dx + B conj(dx) = -off."""
        structures, orders, contacts = off.shape
        G, half = self.flexibility[:, :, :, np.newaxis], orders * contacts
        J, B = (-G * by[:, :, np.newaxis] for by in (by_x, by_conjugate))
        for order in range(orders):
            J[:, order, :, order] += self._left[:, order]
        J, B = (each.reshape(structures, half, half) for each in (J, B))
        real = np.block([[(J + B).real, (B - J).imag], [(J + B).imag, (J - B).real]])
        flat = off.reshape(structures, half)
        right = -np.concatenate((flat.real, flat.imag), axis=-1)[..., np.newaxis]
        found = np.linalg.solve(real, right)[..., 0]
        return np.asarray(found[:, :half] + 1j * found[:, half:]).reshape(off.shape)

    def _unsettled(self) -> UnsettledError:
        where = " and ".join(f"{each:g}" for each in self.frequency)
        return UnsettledError(
            f"contacts: no steady state was found at {where} rad/s; start further "
            "away from the resonance, or use smaller steps of frequency"
        )


def _times(matrix: Complexes | Floats, vector: Complexes) -> Complexes:
    """Return the products of matrices (..., N_c, N_c) and vectors (..., N_c)."""
    return np.asarray((matrix @ vector[..., np.newaxis])[..., 0])


def _norm(x: Complexes) -> Floats:
    """Return the norms of (structures, orders, N_c), (structures, 1, 1)."""
    return np.asarray(np.linalg.norm(x, axis=(1, 2), keepdims=True))


def _changes(slopes: Sequence[Complexes], step: Complexes) -> Complexes:
    """Return what a step of x (orders, N_c) changes of y, with its `slopes`."""
    by_x, by_conjugate = slopes
    return np.asarray((by_x * step + by_conjugate * step.conj()).sum(axis=1))
