"""Modes that are marched along the torus with elastic contacts.

Contacts that slip or open make the structure softer at once, and its modes answer with their
inertia. What they do at single harmonics could be left to the iteration that finds the response;
where contacts are strong it would not settle. The modes are oscillators on every phase line
instead, with a damping of their own, so that their free vibration is soon over:

    p'' + c p' + omega^2 p = d^T y,   c = 2 zeta max(omega, Omega_A),   d = W^T phi.

The iteration is left with what this damping changes: H - H_marched at each harmonic.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import Order
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen

_DAMPING = 0.5  # zeta
# Modes below this part of the carrier would take periods to come to rest, and hardly respond,
_FAST = 0.7
# except to the mean of forces that are not odd. Modes above _SLOWEST follow it, critically
# damped: their free motion falls to a third within four periods.
_SLOWEST = 0.05


@frozen
class MarchedModes:
    """Modes as oscillators, stepped exactly for forces that are linear in a step.

    Attributes
    ----------
    drawn : (marched, N_c) ndarray
        d [kg^-1/2].
    static : (marched,) ndarray
        1 / omega^2 of the modes that the flexibility of the structure has, 0 of others.
    transition : (marched, 2, 2) ndarray
        Of displacement and velocity over a step.
    load : (marched, 2, 2) ndarray
        What unit forces at the start and at the end of a step do to them.
    step : float
        [s]
    """

    drawn: Floats
    static: Floats
    transition: Floats
    load: Floats
    step: float

    @classmethod
    def of(cls, reduced: Reduced, steps: int) -> MarchedModes:
        """With so many steps per period of mode A."""
        modes = len(reduced.modes)
        slowest = (_SLOWEST if reduced.even else _FAST) * reduced.carrier[0]
        chosen = reduced.nonresonant_frequency >= slowest
        inertia, spring = reduced.nonresonant_inertia[chosen], reduced.nonresonant_spring[chosen]
        omega = np.append(reduced.frequency, reduced.nonresonant_frequency[chosen])
        drawn = np.vstack((-reduced.spring, omega[modes:, np.newaxis] ** 2 * inertia - spring))
        # Retained modes are marched too. At its own carrier a mode does not respond, its slow flow
        # does: what the march has of it there is taken back, and must not be a resonance.
        zeta = np.repeat((1.0, _DAMPING), (modes, omega.size - modes))
        slow = np.arange(omega.size) >= modes
        slow &= omega < _FAST * reduced.carrier[0]
        scale = np.where(slow, omega / _DAMPING, np.maximum(omega, reduced.carrier[0]))
        damping = 2.0 * zeta * scale
        step = 2.0 * np.pi / reduced.carrier[0] / steps
        # displacement, velocity, force and its rate
        system = np.zeros((omega.size, 4, 4))
        system[:, 0, 1] = system[:, 1, 2] = system[:, 2, 3] = 1.0
        system[:, 1, 0], system[:, 1, 1] = -(omega**2), -damping
        over = scipy.linalg.expm(step * system)
        end = over[:, :2, 3] / step
        load = np.stack((over[:, :2, 2] - end, end), axis=-1)
        static = np.append(
            np.zeros(modes), np.where(np.any(spring, axis=1), 0.0, omega[modes:] ** -2)
        )
        return cls(drawn, static, over[:, :2, :2], load, step)

    @property
    def advance(self) -> Floats:
        """Rows of (p, v, g_0, g_1) to p and to v, (marched, 8)."""
        return np.concatenate((self.transition, self.load), axis=-1).reshape(-1, 8)

    def flexibility(self, reduced: Reduced) -> Floats:
        """Of the structure within a step, (N_c, N_c)."""
        within = self.load[:, 0, 1] - self.static
        found = (self.drawn.T * within) @ self.drawn - reduced.stiffness
        return np.asarray(0.5 * (found + found.T))

    def periodic(self, rates: Floats, orders: Sequence[Order]) -> Complexes:
        """P and v at t = 0 per g exp(i nu t), (orders, marched, 2).

        nu of carriers at these rates (modes,) [rad/s].
        """
        nu = np.array(orders, dtype=float)[:, : rates.size] @ rates
        turn = np.exp(1j * nu * self.step)[:, np.newaxis]
        load = self.load[..., 0] + turn[..., np.newaxis] * self.load[..., 1]
        free = turn[..., np.newaxis, np.newaxis] * np.eye(2) - self.transition
        return np.asarray(np.linalg.solve(free, load[..., np.newaxis])[..., 0])

    def response(self, rates: Floats, orders: Sequence[Order]) -> Complexes:
        """H_marched (orders, N_c, N_c): displacement of the contacts per y exp(i nu t).

        Beyond the static flexibility; nu of carriers at these rates (modes,) [rad/s].
        """
        p = self.periodic(rates, orders)[..., 0] - self.static
        return np.asarray(np.einsum("qk,kc,kd->qcd", p, self.drawn, self.drawn))
