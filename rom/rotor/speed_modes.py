"""Modes followed over rotor speeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import scipy

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import RPM
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow import axes_or_current
from slipmode.rom.structure.matrices import Matrix, as_dense

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Frequencies (count,) [rad/s] and mass-normalised shapes (n, count) at one speed.
ModesAtSpeed: TypeAlias = "tuple[Floats, Floats] | tuple[Floats, Complexes]"

# Below this modal assurance criterion a shape has more of another mode than of its own.
_LEAST_SIMILARITY = 0.5


@frozen
class SpeedModes:
    """Hold modes over rotor speeds, each followed by its shape: a Campbell diagram.

    Attributes
    ----------
    speed : (speeds,) ndarray
        Rotor speeds [rad/s].
    frequency : (speeds, modes) ndarray
        Natural frequencies in the frame of the structure [rad/s].
    shapes : (speeds, n, modes) ndarray
        Mass-normalised shapes [kg^-1/2]; complex with gyroscopic forces.
    similarity : (speeds - 1, modes) ndarray
        Modal assurance criterion with the shape at the previous speed [-].
    """

    speed: Floats
    frequency: Floats
    shapes: Floats | Complexes
    similarity: Floats

    def crossings(self, engine_order: float) -> Floats:
        """Return the lowest speed at which an engine order excites each mode in resonance.

        Parameters
        ----------
        engine_order : float
            Forcing frequency relative to the rotor speed, > 0.

        Returns
        -------
        (modes,) ndarray
            Speeds [rad/s]; NaN for modes without a crossing. The squared frequency is linear in
            the squared speed between two speeds.
        """
        square = (self.speed**2)[:, np.newaxis]
        gap = self.frequency**2 - engine_order**2 * square
        found = np.full(gap.shape[1], np.nan)
        for mode, each in enumerate(gap.T):
            (at,) = np.nonzero(each[:-1] * each[1:] <= 0.0)
            if at.size:
                low, high = at[0], at[0] + 1
                part = each[low] / (each[low] - each[high])
                between = square[low, 0] + part * (square[high, 0] - square[low, 0])
                found[mode] = np.sqrt(between)
        return found

    def plot(self, engine_orders: Sequence[float] = (), ax: Axes | None = None) -> Any:
        """Plot frequencies and engine orders against the rotor speed.

        Parameters
        ----------
        engine_orders : sequence of float
            Engine orders to draw.
        ax : Axes, optional
            Matplotlib axes. Default: the current axes.

        Returns
        -------
        Axes
            Axes of the plot.
        """
        ax = axes_or_current(ax)
        ax.plot(self.speed / RPM, self.frequency / (2.0 * np.pi), label="mode")
        for order in engine_orders:
            line = order * self.speed / (2.0 * np.pi)
            ax.plot(self.speed / RPM, line, "0.5", lw=0.8)
            ax.annotate(f"EO {order:g}", (self.speed[-1] / RPM, line[-1]))
        ax.set(xlabel="rotor speed [rpm]", ylabel="frequency [Hz]")
        return ax


def follow(speed: Floats, every: Sequence[ModesAtSpeed], mass: Matrix, count: int) -> SpeedModes:
    """Return modes followed from each speed to the next by the most similar shapes."""
    omega, shapes = (each[..., :count] for each in every[0])
    frequency, followed, similarity = [omega], [shapes], []
    for k, (omega, shapes) in enumerate(every[1:], 1):
        product = followed[-1].conj().T @ as_dense(mass @ shapes)
        own, chosen = scipy.optimize.linear_sum_assignment(-np.abs(product))
        kept = product[own, chosen]
        similarity.append(np.abs(kept) ** 2)
        if (lost := similarity[-1] < _LEAST_SIMILARITY).any():
            mode = int(np.argmax(lost))
            raise SlipmodeError(
                f"speeds: mode {mode} cannot be followed from {speed[k - 1]:g} to {speed[k]:g} "
                f"rad/s, because only {similarity[-1][mode]:.0%} of its shape stays (MAC); give "
                "speeds between them"
            )
        frequency.append(omega[chosen])
        followed.append(shapes[:, chosen] * (kept.conj() / np.abs(kept)))
    kept_shares = np.array(similarity).reshape(-1, frequency[0].size)
    all_shapes: Any = np.array(followed)
    return SpeedModes(speed, np.array(frequency), all_shapes, kept_shares)
