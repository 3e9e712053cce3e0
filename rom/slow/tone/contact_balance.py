"""Contacts in balance with all modes at one forcing frequency, by Newton's method.

    x = x_0 + G (y(x) - s x)

has the displacements x (N_c,) of the contacts at the carrier, x_0 by the forces alone, the
flexibility G of the structure and the force deficits y of the contacts. The structure that has G
is without the springs s of the contacts: all of k_ref, or 0 if its contacts are stuck.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

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
    """A state with coupled contacts, and a step of Newton's method; (N_c,) each."""

    drive: Complexes
    x: Complexes
    y: Complexes
    step: Complexes  # of x
    change: Complexes  # of the drive


@frozen
class ContactBalance:
    """Structures with the same contacts at one frequency, such as mistuning patterns of a disk.

    Attributes
    ----------
    frequency : float
        [rad/s]
    flexibility : (structures, N_c, N_c) complex ndarray
        G [m/N].
    moved : (structures, N_c) complex ndarray
        x_0 [m].
    local : LocalContacts
    springs : (N_c,) ndarray
        s [N/m].
    """

    frequency: float
    flexibility: Complexes
    moved: Complexes
    local: LocalContacts
    springs: Floats

    def with_local_contacts(self, start: Complexes | None) -> tuple[Complexes, Complexes]:
        """Return x and y (structures, N_c); `start` is a guess of x, by default stuck contacts.

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
            length, before = np.ones((len(x), 1)), np.linalg.norm(off, axis=1, keepdims=True)
            for _ in range(_HALVINGS):
                tried = x + length * step
                y, by_x, by_conjugate = self.local(tried)
                off = self._residual(tried, y)
                after = np.linalg.norm(off, axis=1, keepdims=True)
                worse = after > (1.0 - 0.1 * length) * before + np.finfo(float).tiny
                if not worse.any():
                    break
                length[worse] *= 0.5
            x = tried
            small = np.linalg.norm(step, axis=1) <= _CONVERGED * np.linalg.norm(x, axis=1)
            if small.all():
                return x, y
        raise self._unsettled()

    def with_coupled_contacts(
        self, contacts: Sequence[CoupledContacts], x: Complexes
    ) -> tuple[Complexes, Complexes]:
        """Return x and y of contacts that act on each other at the higher harmonics, too.

        From the state x with local contacts, whose derivatives Newton's method keeps; Anderson's
        acceleration improves its steps. `contacts` are the contacts of each structure.

        Raises
        ------
        UnsettledError
            If no state is found.
        """
        every = range(len(x))
        found = [self._single(k)._coupled(contacts[k], x[k : k + 1]) for k in every]
        return np.array([each[0] for each in found]), np.array([each[1] for each in found])

    def corrected(self, contacts: CoupledContacts, x: Complexes, y: Complexes) -> Complexes:
        """Return y (N_c,) after a step of Newton's method from x, y (N_c,), of one structure."""
        slopes = self.local(x[np.newaxis])[1:]
        at = self._iterate(contacts, slopes, x - contacts.far @ y)
        by_x, by_conjugate = (each[0] for each in slopes)
        return np.asarray(at.y + by_x * at.step + by_conjugate * at.step.conj())

    def _single(self, number: int) -> ContactBalance:
        """Return one of the structures."""
        own = slice(number, number + 1)
        G, moved = self.flexibility[own], self.moved[own]
        return ContactBalance(self.frequency, G, moved, self.local, self.springs)

    def _coupled(self, contacts: CoupledContacts, x: Complexes) -> tuple[Complexes, Complexes]:
        """Return x and y (N_c,) of a single structure, from the state x (1, N_c)."""
        from scipy import optimize  # takes long to import

        anderson: Any = optimize.anderson  # its types allow one number only

        y, *slopes = self.local(x)
        start = x[0] - contacts.far @ y[0]
        last = self._iterate(contacts, slopes, start)

        def correction(given: Floats) -> Floats:
            nonlocal last
            drive = given.view(complex)
            if not np.array_equal(drive, last.drive):
                last = self._iterate(contacts, slopes, drive)
            return last.change.view(float)

        closest = _COUPLED * float(np.linalg.norm(x))
        if np.linalg.norm(last.change) > closest:  # scipy refuses a residual of 0
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
            except (optimize.NoConvergence, ValueError):
                raise self._unsettled() from None
        return last.x, last.y

    def _iterate(
        self, contacts: CoupledContacts, slopes: Sequence[Complexes], drive: Complexes
    ) -> _Iterate:
        """Return the state at a drive (N_c,) of a single structure, and its Newton step.

        `slopes` (1, N_c) are the derivatives of y by x and by conj(x).
        """
        y = contacts.deficit(drive)
        x = drive + contacts.far @ y
        by_x, by_conjugate = slopes
        step = self._step(self._residual(x[np.newaxis], y[np.newaxis]), by_x, by_conjugate)[0]
        change = step - contacts.far @ (by_x[0] * step + by_conjugate[0] * step.conj())
        return _Iterate(drive, x, y, step, change)

    @cached_property
    def _left(self) -> Complexes:
        """1 + G s, (structures, N_c, N_c)."""
        return np.asarray(np.eye(self.springs.size) + self.flexibility * self.springs)

    def _stuck(self) -> Complexes:
        """Return x with stuck contacts, which have no force deficit."""
        return np.asarray(np.linalg.solve(self._left, self.moved[..., np.newaxis])[..., 0])

    def _residual(self, x: Complexes, y: Complexes) -> Complexes:
        left, right = (
            (matrix @ vector[..., np.newaxis])[..., 0]
            for matrix, vector in ((self._left, x), (self.flexibility, y))
        )
        return np.asarray(left - self.moved - right)

    def _step(self, off: Complexes, by_x: Complexes, by_conjugate: Complexes) -> Complexes:
        """Return dx of J dx + B conj(dx) = -off."""
        G = self.flexibility
        J, B = self._left - G * by_x[:, np.newaxis], -G * by_conjugate[:, np.newaxis]
        real = np.block([[(J + B).real, (B - J).imag], [(J + B).imag, (J - B).real]])
        right = -np.concatenate((off.real, off.imag), axis=-1)[..., np.newaxis]
        found = np.linalg.solve(real, right)[..., 0]
        half = off.shape[-1]
        return np.asarray(found[..., :half] + 1j * found[..., half:])

    def _unsettled(self) -> UnsettledError:
        return UnsettledError(
            f"contacts: no steady state was found at {self.frequency:g} rad/s; start further "
            "away from the resonance, or use smaller steps of frequency"
        )
