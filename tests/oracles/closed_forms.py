"""Closed forms of one contact and of one mass."""

import numpy as np


def jenkins_first_harmonic(X: float, limit: float, stiffness: float) -> complex:
    """Return the first harmonic of a Jenkins force under x = X cos(theta), f = Re(q exp(i theta)).

    The real part is the elastic force, the imaginary part dissipates: pi X Im q per cycle.
    """
    reach = limit / stiffness
    if reach >= X:
        return complex(stiffness * X)
    turn = np.arccos(1.0 - 2.0 * reach / X)  # phase from a reversal to slip
    elastic = stiffness * X / np.pi * (turn - 0.5 * np.sin(2.0 * turn))
    return complex(elastic, jenkins_dissipation(X, limit, stiffness) / (np.pi * X))


def jenkins_dissipation(X: float, limit: float, stiffness: float) -> float:
    """Return the work that a Jenkins element dissipates per cycle, 4 mu N (X - mu N / k)."""
    return 4.0 * limit * max(0.0, X - limit / stiffness)


def play_delay(stick: float) -> complex:
    """Return the integral of t exp(-i t) over the angle that a slider sticks after a reversal."""
    return complex(np.exp(-1j * stick) * (1.0 + 1j * stick) - 1.0)
