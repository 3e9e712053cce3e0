"""A structure with contacts, and the forces on it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sliders:
    """Jenkins elements in parallel on one contact DOF: limits [N], stiffnesses [N/m]."""

    limits: tuple[float, ...]
    stiffnesses: tuple[float, ...]

    @property
    def stuck(self) -> float:
        """Return the stiffness in stick [N/m]."""
        return sum(self.stiffnesses)


def jenkins(limit: float, stiffness: float) -> Sliders:
    """Return one Jenkins element."""
    return Sliders((limit,), (stiffness,))


@dataclass(frozen=True)
class Tanh:
    """Force limit * tanh(v / alpha) on one contact DOF."""

    limit: float
    alpha: float


@dataclass(frozen=True)
class Coulomb:
    """Exact Coulomb friction on one contact DOF."""

    limit: float


@dataclass(frozen=True)
class Frictional:
    """Friction and lift-off on two contact DOFs: the tangential one, then the normal one.

    N = max(0, preload + normal * (x_n - gap)). The normal force on the structure is N - preload,
    the tangential one tangential * (x_t - s), at most mu N in magnitude.
    """

    mu: float
    preload: float
    tangential: float
    normal: float
    gap: float = 0.0


Law = Sliders | Tanh | Coulomb | Frictional


@dataclass(frozen=True)
class System:
    """M x'' + C x' + K x + W f = F. `W` (n, contact DOFs); `laws` in the order of its columns."""

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    W: np.ndarray
    laws: Sequence[Law]
    loss: np.ndarray | float = 0.0  # K'', of harmonic balance alone

    def stuck_stiffness(self) -> np.ndarray:
        """Return the stiffness of each contact DOF in stick [N/m], 0 for rigid friction."""
        found: list[float] = []
        for law in self.laws:
            alone = [law.stuck if isinstance(law, Sliders) else 0.0]
            found += [law.tangential, law.normal] if isinstance(law, Frictional) else alone
        return np.array(found)

    def stuck(self) -> np.ndarray:
        """Return K with all elastic contacts in stick."""
        return self.K + (self.W * self.stuck_stiffness()) @ self.W.T


@dataclass(frozen=True)
class Tone:
    """The force Re(F exp(i Omega t))."""

    Omega: float
    F: np.ndarray
