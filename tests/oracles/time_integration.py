"""Time integration with the linear part exact, and harmonics of the steady motion.

The linear part, contacts in stick included, is advanced by its matrix exponential. Forces, and
what contacts exert beyond their stiffness in stick, are linear in each step (Coulomb: constant,
the impulse that ends the step in stick or at the limit). The error is of second order in the step
and is measured with two steps, h and 2 h.
"""

import ctypes
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import scipy.linalg

from oracles.system import Coulomb, Frictional, Sliders, System, Tanh, Tone

LEVELS = 8  # of steps h, h / 2, ... where rigid contacts stick, slide or turn
LARGEST_SPREAD = 3e-3  # of harmonics under two tones from window to window, relative
SAMPLES = 128  # per period of the fastest tone, of what harmonics are taken from


class NotSteadyError(Exception):
    """The motion did not become steady within the allowed periods."""


class _Contact(ctypes.Structure):
    _fields_ = (
        [(name, ctypes.c_int) for name in ("kind", "first", "count")]
        + [(name, ctypes.c_double) for name in "abc"]
    )  # fmt: skip


@cache
def _library() -> ctypes.CDLL:
    source = Path(__file__).with_name("march.c")
    flags = ["-std=c99", "-O2", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror"]
    with tempfile.TemporaryDirectory() as folder:
        built = str(Path(folder, "march.so"))
        subprocess.run(["cc", *flags, str(source), "-o", built, "-lm"], check=True)
        return ctypes.CDLL(built)


def state_matrix(system: System) -> np.ndarray:
    """Return A of z' = A z, z = (x, x'), with all elastic contacts in stick."""
    n = len(system.M)
    rows = -np.linalg.solve(system.M, np.hstack((system.stuck(), system.C)))
    return np.vstack((np.hstack((np.zeros((n, n)), np.eye(n))), rows))


class _March(ctypes.Structure):
    _fields_ = (
        [(name, ctypes.c_int) for name in ("n", "contacts", "forces", "sliders", "levels")]
        + [(name, ctypes.c_void_p) for name in ("E", "G0", "G1", "H0", "H1", "D", "R")]
        + [("laws", ctypes.POINTER(_Contact))]
        + [(name, ctypes.c_void_p) for name in ("limits", "stiffnesses", "z", "u", "memory")]
    )  # fmt: skip


class Integrator:
    """Steps of size h of a system under forces `columns` (n, forces) times signals of time."""

    def __init__(self, system: System, columns: np.ndarray, h: float) -> None:
        self.n, self.forces = len(system.M), columns.shape[1]
        self._contacts(system)
        levels = LEVELS if any(isinstance(law, Coulomb | Tanh) for law in system.laws) else 1
        parts = [self._exact(system, columns, h / 2**level) for level in range(levels)]
        self.matrices = [np.array(matrix) for matrix in zip(*parts, strict=True)]
        self.z, self.u = np.zeros(2 * self.n), np.zeros(system.W.shape[1])

    def _exact(self, system: System, columns: np.ndarray, h: float) -> list[np.ndarray]:
        """Return E, G0, G1, H0, H1 and D of a step h: the effect of z, contacts and forces."""
        n, c = self.n, system.W.shape[1]
        A = state_matrix(system)
        B = np.zeros((2 * n, c + columns.shape[1]))
        B[n:] = np.linalg.solve(system.M, np.hstack((system.W, columns)))
        m = B.shape[1]
        both = np.zeros((2 * n + 2 * m, 2 * n + 2 * m))
        both[: 2 * n, : 2 * n], both[: 2 * n, 2 * n : 2 * n + m] = A * h, B * h
        both[2 * n : 2 * n + m, 2 * n + m :] = np.eye(m)
        exact = scipy.linalg.expm(both)[: 2 * n]
        end = exact[:, 2 * n + m :]
        begin = exact[:, 2 * n : 2 * n + m] - end
        end[:, :c] += begin[:, :c] * self.constant
        begin[:, :c] *= ~self.constant
        parts = exact[:, : 2 * n], begin[:, :c], end[:, :c], begin[:, c:], end[:, c:]
        return [*parts, self.R @ end[:, :c]]

    def _contacts(self, system: System) -> None:
        """Set the laws as C reads them, the contact coordinates R z, and which u are constant."""
        laws, limits, stiffnesses, slots = [], [], [], 0
        self.R = np.zeros((system.W.shape[1], 2 * self.n))
        self.constant = np.zeros(system.W.shape[1], dtype=bool)
        for law in system.laws:
            i = len(laws)
            rows = slice(self.n, None) if isinstance(law, Tanh | Coulomb) else slice(self.n)
            self.R[i, rows] = system.W[:, i]
            if isinstance(law, Sliders):
                laws.append(_Contact(0, slots, len(law.limits), 0, 0, 0))
                limits += law.limits
                stiffnesses += law.stiffnesses
            elif isinstance(law, Tanh):
                laws.append(_Contact(1, slots, 0, law.limit, law.alpha, 0))
            elif isinstance(law, Coulomb):
                laws.append(_Contact(2, slots, 0, law.limit, 0, 0))
                self.constant[i] = True
            else:
                assert isinstance(law, Frictional)
                self.R[i + 1, : self.n] = system.W[:, i + 1]
                laws.append(_Contact(3, slots, 1, law.mu, law.tangential, 0))
                laws.append(_Contact(4, slots, 0, law.preload, law.normal, law.gap))
                limits, stiffnesses = [*limits, 0.0], [*stiffnesses, 1.0]
            slots = len(limits)
        self.laws = (_Contact * max(1, len(laws)))(*laws)
        self.sliders = np.array([limits, stiffnesses]).reshape(2, slots)
        self.memory = np.zeros(slots)

    def advance(self, signals: np.ndarray, every: int) -> tuple[np.ndarray, np.ndarray]:
        """March along signals (steps + 1, forces); z and u after each `every`-th step."""
        steps, c = len(signals) - 1, len(self.u)
        signals = np.ascontiguousarray(signals)
        out = np.empty((steps // every, 2 * self.n + c))
        data = [m.ctypes.data for m in (*self.matrices, self.R)]
        inner = [m.ctypes.data for m in (*self.sliders, self.z, self.u, self.memory)]
        sizes = 2 * self.n, c, self.forces, len(self.memory), len(self.matrices[0])
        march = _March(*sizes, *data, self.laws, *inner)
        status = _library().march(
            *(ctypes.byref(march), ctypes.c_long(steps), ctypes.c_void_p(signals.ctypes.data)),
            *(ctypes.c_long(every), ctypes.c_void_p(out.ctypes.data)),
        )
        if status or not np.isfinite(self.z).all():
            raise ArithmeticError(f"the contacts of a step were not solved, status {status}")
        return out[:, : 2 * self.n], out[:, 2 * self.n :]


@dataclass(frozen=True)
class Motion:
    """Samples: times (s,), displacements and velocities (s, n)."""

    t: np.ndarray
    x: np.ndarray
    v: np.ndarray


def integrate(
    system: System,
    columns: np.ndarray,
    signals: Callable[[np.ndarray], np.ndarray],
    t_end: float,
    steps: int,
    every: int = 1,
    start: np.ndarray | float = 0.0,
) -> Motion:
    """Integrate under columns (n, forces) @ signals(t) (s, forces), from rest or z = (x, v).

    Sliders begin at 0, or follow to their reach in the first step.
    """
    h = t_end / steps
    inner = Integrator(system, columns, h)
    inner.z[:] = start
    z, n = inner.advance(signals(h * np.arange(steps + 1)), every)[0], inner.n
    return Motion(h * every * np.arange(1, len(z) + 1), z[:, :n], z[:, n:])


@dataclass(frozen=True)
class Steady:
    """Steady harmonics: x = Re(sum_k amplitude_k exp(i frequency_k t)).

    `error` (orders, n) bounds what remains of the transient and the effect of the step.
    """

    frequency: np.ndarray
    amplitude: np.ndarray
    error: np.ndarray


def steady_harmonics(
    system: System,
    tones: Sequence[Tone],
    orders: Sequence[Sequence[int]],
    tolerance: float = 1e-5,
    steps: int = 1024,
    most_periods: int = 30_000,
) -> Steady:
    """Integrate from rest until the harmonics are steady, `steps` per period of the fastest tone.

    `orders` (orders, tones): integer multiples of the frequencies. `tolerance` is the remainder of
    the transient relative to the largest amplitude. Raises NotSteadyError.
    """
    coarse, inner = _settled(system, tones, orders, tolerance, steps // 2, most_periods, None)
    fine, _ = _settled(system, tones, orders, tolerance, steps, most_periods, inner)
    error = fine.error + np.abs(fine.amplitude - coarse.amplitude)
    return Steady(fine.frequency, fine.amplitude, error)


def _settled(system, tones, orders, tolerance, steps, most_periods, start):
    Omega = np.array([tone.Omega for tone in tones])
    columns = np.array([part for tone in tones for part in (tone.F.real, tone.F.imag)]).T
    h = 2.0 * np.pi / Omega.max() / steps
    inner = Integrator(system, columns, h)
    if start is not None:
        inner.z, inner.u, inner.memory = start.z.copy(), start.u.copy(), start.memory.copy()
    nu = np.array(orders, dtype=float) @ Omega
    window = _window(Omega)
    every = max(1, steps // SAMPLES)
    samples = window * steps // every
    s = np.arange(1, samples + 1) / (samples + 1.0)
    # smooth to all orders at both ends: lines decay faster than any power
    weight = np.exp(-1.0 / (s * (1.0 - s))) if len(tones) > 1 else np.ones(samples)
    weight /= weight.sum()
    decay = -np.linalg.eigvals(state_matrix(system)).real
    left = np.exp(-decay.min() * window * steps * h)  # of a transient after a window
    windows: list[np.ndarray] = []
    for done in range(window, most_periods + 1, window):
        first = (done - window) * steps
        phases = np.outer(h * np.arange(first, first + window * steps + 1), Omega)
        signals = np.stack((np.cos(phases), -np.sin(phases)), axis=2).reshape(len(phases), -1)
        x = inner.advance(signals, every)[0][:, : inner.n]
        t = h * (first + every * np.arange(1, samples + 1))
        waves = np.exp(-1j * np.outer(nu, t)) * weight
        found = np.where(nu[:, np.newaxis] == 0.0, 1.0, 2.0) * (waves @ x)
        windows = [*windows[-3:], found]
        if len(windows) == 1:
            continue
        size = np.abs(found).max()
        error = np.abs(found - windows[-2]) * max(1.0, left / (1.0 - left))
        if error.max() > tolerance * size and done + window > most_periods and len(tones) > 1:
            # lines beside the lattice, or closer to each other than windows distinguish
            found = np.mean(windows, axis=0)
            error = np.abs(np.array(windows) - found).max(axis=0)
            tolerance = LARGEST_SPREAD
        if error.max() <= tolerance * size:
            return Steady(nu, found, error), inner
    raise NotSteadyError(f"not steady after {most_periods} periods")


def _window(Omega: np.ndarray) -> int:
    """Periods of the fastest tone that harmonics are taken over."""
    if len(Omega) == 1:
        return 10
    lines = np.array([[n, m] for n in range(7) for m in range(-6, 7) if 0 < n + abs(m) <= 6])
    apart = np.abs(lines @ Omega) / Omega.max()
    return int(np.clip(np.ceil(20.0 / apart[apart > 1e-9].min()), 60, 1500))
