"""Contacts of disks in balance with all waves at one forcing frequency, by Newton's method.

    (1 + G k_ref) x = x_0 + G y(x)

has the displacements x (N N_c) of the contacts at the carrier, x_0 by the forces alone, the
flexibility G of the disk with open contacts and the force deficits y of the contacts.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.cyclic.mistuned.coupled_contacts import CoupledContacts
from slipmode.rom.cyclic.mistuned.disk_modes import AtFrequency
from slipmode.rom.cyclic.mistuned.local_contacts import LocalContacts
from slipmode.rom.errors import UnsettledError
from slipmode.rom.short_repr import frozen

_ITERATIONS, _HALVINGS = 60, 8
# Relative change of x at which iterations end: with local contacts, and with coupled ones, which
# are as exact as their march.
_CONVERGED, _COUPLED = 1e-6, 1e-5
_SECANTS = 10  # corrections that are kept


@frozen
class DiskBalance:
    """Disks of several mistuning patterns at one frequency.

    Attributes
    ----------
    at : AtFrequency
    local : LocalContacts
    springs : (N N_c,) ndarray
        k_ref of all contacts [N/m].
    """

    at: AtFrequency
    local: LocalContacts
    springs: Floats

    def with_local_contacts(self, start: Complexes | None) -> tuple[Complexes, Complexes]:
        """Return x and y (patterns, N N_c); `start` is a guess of x, by default stuck contacts.

        Raises
        ------
        UnsettledError
            If no state is found.
        """
        x = self._stuck() if start is None else start
        y, by_x, by_conjugate = self._local(x)
        off = self._residual(x, y)
        for _ in range(_ITERATIONS):
            step = self._step(off, by_x, by_conjugate)
            # Along Newton's direction, as far as the residual falls.
            length, before = np.ones((len(x), 1)), np.linalg.norm(off, axis=1, keepdims=True)
            for _ in range(_HALVINGS):
                tried = x + length * step
                y, by_x, by_conjugate = self._local(tried)
                off = self._residual(tried, y)
                after = np.linalg.norm(off, axis=1, keepdims=True)
                worse = after > (1.0 - 0.1 * length) * before + np.finfo(float).tiny
                if not worse.any():
                    break
                length[worse] *= 0.5
            x = tried
            if _is_small(step, x, _CONVERGED):
                return x, y
        raise self._unsettled()

    def with_coupled_contacts(
        self, contacts: CoupledContacts, x: Complexes
    ) -> tuple[Complexes, Complexes]:
        """Return x and y of contacts that act on each other at the higher harmonics, too.

        From the state x with local contacts, whose derivatives Newton's method keeps. Secants of
        the last corrections improve them (Anderson's acceleration).

        Raises
        ------
        UnsettledError
            If no state is found.
        """
        far = contacts.far
        y, by_x, by_conjugate = self._local(x)
        drive = x - y @ far
        secants = [_Secants() for _ in drive]
        for _ in range(_ITERATIONS):
            y = contacts.deficit(drive)
            x = drive + y @ far
            step = self._step(self._residual(x, y), by_x, by_conjugate)
            if _is_small(step, x, _COUPLED):
                return x, y
            correction = step - (by_x * step + by_conjugate * step.conj()) @ far
            patterns = zip(secants, drive, correction, strict=True)
            drive = np.array([each.improved(*at) for each, *at in patterns])
        raise self._unsettled()

    @cached_property
    def _left(self) -> Complexes:
        """1 + G k_ref, (patterns, N N_c, N N_c)."""
        return np.asarray(np.eye(self.springs.size) + self.at.flexibility * self.springs)

    def _stuck(self) -> Complexes:
        """Return x with stuck contacts, which have no force deficit."""
        return np.asarray(np.linalg.solve(self._left, self.at.moved[..., np.newaxis])[..., 0])

    def _local(self, x: Complexes) -> tuple[Complexes, Complexes, Complexes]:
        """Return y and its derivatives by x and conj(x), with local contacts."""
        by_sector = x.reshape(*x.shape[:-1], -1, self.local.contacts)
        y, by_x, by_conjugate = (each.reshape(x.shape) for each in self.local(by_sector))
        return y, by_x, by_conjugate

    def _residual(self, x: Complexes, y: Complexes) -> Complexes:
        left, right = (
            (matrix @ vector[..., np.newaxis])[..., 0]
            for matrix, vector in ((self._left, x), (self.at.flexibility, y))
        )
        return np.asarray(left - self.at.moved - right)

    def _step(self, off: Complexes, by_x: Complexes, by_conjugate: Complexes) -> Complexes:
        """Return dx of J dx + B conj(dx) = -off."""
        G = self.at.flexibility
        J, B = self._left - G * by_x[:, np.newaxis], -G * by_conjugate[:, np.newaxis]
        real = np.block([[(J + B).real, (B - J).imag], [(J + B).imag, (J - B).real]])
        right = -np.concatenate((off.real, off.imag), axis=-1)[..., np.newaxis]
        found = np.linalg.solve(real, right)[..., 0]
        half = off.shape[-1]
        return np.asarray(found[..., :half] + 1j * found[..., half:])

    def _unsettled(self) -> UnsettledError:
        return UnsettledError(
            f"contacts: no steady state was found at {self.at.frequency:g} rad/s; start further "
            "away from the resonance, or use smaller steps of frequency"
        )


class _Secants:
    """Anderson's acceleration of x -> x + f(x), of one pattern."""

    def __init__(self) -> None:
        self._points: list[Floats] = []
        self._corrections: list[Floats] = []

    def improved(self, x: Complexes, correction: Complexes) -> Complexes:
        """Return the next x, from this and the last ones."""
        self._points = [*self._points[-_SECANTS:], x.view(float)]
        self._corrections = [*self._corrections[-_SECANTS:], correction.view(float)]
        new = x + correction
        if len(self._points) > 1:
            moved, changed = (np.diff(each, axis=0) for each in (self._points, self._corrections))
            weights, *_ = np.linalg.lstsq(changed.T, self._corrections[-1], rcond=None)
            new = new - (weights @ (moved + changed)).view(complex)
        return np.asarray(new)


def _is_small(step: Complexes, x: Complexes, tolerance: float) -> bool:
    """Return whether a step of Newton's method is small in every pattern."""
    return bool(np.all(np.linalg.norm(step, axis=1) <= tolerance * np.linalg.norm(x, axis=1)))
