"""Scenes of a few DOFs with the independent time integration beside them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from oracles.system import System
from oracles.time_integration import Integrator
from scipy.interpolate import CubicSpline

SAMPLES = 64  # of the independent motion per period of the fastest force


@dataclass(frozen=True)
class Force:
    """A force vector times amplitude cos(phase + integral of the frequency).

    Numbers, or breakpoints [[t, value], ...] as in scenes.
    """

    vector: Sequence[float]
    amplitude: float | list = 1.0
    frequency: float | list = 1.0
    phase: float | list = 0.0

    def toml(self, name: str) -> str:
        """Return the section of a scene."""
        return (
            f"[forcing.{name}]\nvector = {list(self.vector)}\namplitude = {self.amplitude}\n"
            f"frequency = {self.frequency}\nphase = {self.phase}\n"
        )

    def signal(self, t: np.ndarray) -> np.ndarray:
        """Return the signal at times."""
        theta = integral(self.frequency, t) + value(self.phase, t)
        return value(self.amplitude, t) * np.cos(theta)


def value(points, t: np.ndarray) -> np.ndarray:
    """Return a right-continuous piecewise linear function, constant outside its breakpoints."""
    if not isinstance(points, list):
        return np.full(len(t), float(points))
    times, values = np.array(points, dtype=float).T
    i = np.searchsorted(times, t, side="right") - 1
    first, last = np.clip(i, 0, None), np.clip(i + 1, None, len(times) - 1)
    span = np.where(times[last] > times[first], times[last] - times[first], 1.0)
    part = np.where(i < 0, 0.0, (t - times[first]) / span)
    return values[first] + np.clip(part, 0.0, 1.0) * (values[last] - values[first])


def integral(points, t: np.ndarray) -> np.ndarray:
    """Return the integral of a piecewise linear function from 0 to t."""
    if not isinstance(points, list):
        return float(points) * t
    nodes = np.unique([0.0, *(p[0] for p in points if p[0] > 0.0), t.max()])
    ends = value(points, nodes[1:] - 1e-9)
    sums = np.append(0.0, np.cumsum(0.5 * (value(points, nodes[:-1]) + ends) * np.diff(nodes)))
    i = np.clip(np.searchsorted(nodes, t, side="right") - 1, 0, len(nodes) - 2)
    return sums[i] + 0.5 * (value(points, nodes[i]) + value(points, t)) * (t - nodes[i])


@dataclass(frozen=True)
class Exact:
    """Independent motion: times, displacements, velocities, contact forces, forces on DOFs."""

    system: System
    t: np.ndarray
    x: np.ndarray
    v: np.ndarray
    contact: np.ndarray
    force: np.ndarray = field(repr=False)

    def at(self, times: np.ndarray) -> np.ndarray:
        """Return displacements (times, n), from rest at t = 0."""
        begin = np.zeros((1, self.x.shape[1]))
        return CubicSpline(np.append(0.0, self.t), np.vstack((begin, self.x)))(times)

    def contact_force(self, times: np.ndarray) -> np.ndarray:
        """Return the forces of the contacts (times, contact DOFs), less preload."""
        return np.column_stack([np.interp(times, self.t, each) for each in self.contact.T])


def integrated(
    system: System,
    forces: Sequence[Force],
    end: float,
    steps: int = 512,
    scale: tuple[float, float] | None = None,
    samples: int = SAMPLES,
) -> Exact:
    """Integrate from rest, `steps` per period of the fastest force.

    `scale`: (time, factor), a jump of all friction limits of sliders.
    """
    fastest = max(np.max(value(f.frequency, np.linspace(0.0, end, 1000))) for f in forces)
    count = int(np.ceil(end * fastest / (2.0 * np.pi))) * steps
    h, every = end / count, steps // samples
    columns = np.array([f.vector for f in forces], dtype=float).T
    inner = Integrator(system, columns, h)
    block, parts = 200 * steps, []
    jump = count if scale is None else round(scale[0] / end * count / every) * every
    for first in sorted({*range(0, count, block), min(jump, count - every)}):
        later = [k for k in (*range(0, count + block, block), jump, count) if k > first]
        last = min(min(later), count)
        if first == jump:
            inner.sliders[0] *= scale[1]
        t = h * np.arange(first, last + 1)
        signals = np.array([f.signal(t) for f in forces]).T
        parts.append(np.hstack(inner.advance(signals, every)))
    found, n = np.vstack(parts), inner.n
    z, u = np.split(found, [2 * n], axis=1)
    contact = z[:, :n] @ (system.W * system.stuck_stiffness()) - u
    t = h * every * np.arange(1, len(z) + 1)
    forces_at = np.array([f.signal(t) for f in forces]).T @ columns.T
    return Exact(system, t, z[:, :n], z[:, n:], contact, forces_at)
