"""Answers of slipmode for drawn structures, each beside the independent solution.

An answer is a complex amplitude, a frequency or a damping ratio, with the error that its result
states. Its true error is the distance from the independent solution, which has its own error.
"""

import signal
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from oracles.families import RATIOS, Case, case
from oracles.harmonic_balance import NotBalancedError, nonlinear_mode
from oracles.system import Coulomb, Sliders, Tanh, Tone
from oracles.time_integration import NotSteadyError, Steady, steady_harmonics

from slipmode import rom

LIMIT = 40.0  # CPU seconds that an answer may take
ORACLE_ERROR = 2e-4  # relative, above which the independent solution takes shorter steps
SWEEP_SPAN = 0.03  # of a response curve, to each side of its middle
MODE_SLIDERS = ("Jenkins", "Iwan")  # laws of which there are nonlinear modes


@dataclass(frozen=True)
class Answer:
    """One number: its true error, the stated one, and the oracle's own, relative to its size."""

    what: str
    true: float
    stated: float
    own: float

    @property
    def violated(self) -> bool:
        """Whether the true error is above the stated one."""
        return not self.true <= self.stated + self.own


class TooLongError(Exception):
    """An answer took more than LIMIT."""


REFUSALS = (rom.SlipmodeError, TooLongError)
NO_ORACLE = (NotSteadyError, NotBalancedError, ArithmeticError)


def variant(seed: int, laws: tuple[str, ...] | None = None, modes: int | None = None) -> Case:
    """Return the case of a seed: one and two modes, far from and near the ratios, in turn."""
    count = modes or 1 + seed // 2 % 2
    near = RATIOS[1 if count == 1 else 0 :]
    ratio = near[seed // 4 % len(near)] if seed % 2 else None
    return case(seed, count, laws, ratio) if laws else case(seed, count, ratio=ratio)


def structure_and_law(given: Case) -> tuple[rom.Structure, rom.Friction, rom.Friction | None]:
    """Return the structure, its law, and the law that `rom.reduce` takes."""
    s = given.system
    structure = rom.Structure(s.M, s.K, s.C, contact=s.W)
    first = s.laws[0]
    if isinstance(first, Tanh):
        return structure, rom.Tanh([law.limit for law in s.laws], first.alpha), None
    if isinstance(first, Coulomb):
        return structure, rom.Coulomb([law.limit for law in s.laws]), None
    assert isinstance(first, Sliders)
    if len(first.limits) == 1:
        pairs = [(law.limits[0], law.stiffnesses[0]) for law in s.laws]
        joint = rom.Jenkins(*map(list, zip(*pairs, strict=True)))
    else:
        joint = rom.Contacts(
            [(rom.Sliders(law.limits, law.stiffnesses), [i]) for i, law in enumerate(s.laws)]
        )
    return structure, joint, joint


def reduced(given: Case, forced: bool = True) -> tuple[rom.Reduced, rom.Friction]:
    """Return the reduction to the modes of a case, by default to its forces and frequencies."""
    structure, law, elastic = structure_and_law(given)
    options: dict[str, list] = {}
    if forced:
        options = {
            "carrier": [tone.Omega for tone in given.tones],
            "force_patterns": forces(given),
        }
    return rom.reduce(structure, given.modes, law=elastic, warned=False, **options), law


def forces(given: Case) -> list[np.ndarray]:
    """Return the force amplitudes on the modes."""
    return [tone.F.real for tone in given.tones]


def limited(call: Callable, limit: float = LIMIT):
    """Return a call's result without warnings. Raises TooLongError."""

    def stop(*_):
        raise TooLongError(f"took more than {limit:g} CPU s")

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return call()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def solution(given: Case, tones: tuple[Tone, ...] | None = None, steps: int = 512) -> Steady:
    """Return the independent harmonics at the forcing frequencies.

    Steps are a quarter as long where the error is above ORACLE_ERROR.
    """
    orders = np.eye(len(given.tones), dtype=int).tolist()
    arguments = given.system, tones or given.tones, orders, 2e-5
    found = steady_harmonics(*arguments, steps, most_periods=8000)
    if (found.error.max(axis=1) > ORACLE_ERROR * np.abs(found.amplitude).max(axis=1)).any():
        found = steady_harmonics(*arguments, 4 * steps, most_periods=8000)
    return found


def amplitudes(given: Case, found: rom.Reduced, exact: Steady) -> tuple[np.ndarray, np.ndarray]:
    """Return true amplitudes a_j (modes,) of a reduction, and their errors."""
    rows = found.mode_shapes.T @ given.system.M
    a = 0.5 * np.einsum("jn,jn->j", rows, exact.amplitude)
    return a, 0.5 * np.einsum("jn,jn->j", np.abs(rows), exact.error)


def _compared(names, found, stated, true, own) -> Iterator[Answer]:
    for name, value, error, exact, its in zip(names, found, stated, true, own, strict=True):
        size = abs(exact)
        yield Answer(name, abs(value - exact) / size, float(error) / size, float(its) / size)


def direct(given: Case) -> list[Answer]:
    """Amplitudes of `rom.steady_state`."""
    small, law = reduced(given)
    frequency = [tone.Omega for tone in given.tones]
    state = limited(lambda: rom.steady_state(small, law, frequency, forces(given)))
    true, own = amplitudes(given, small, solution(given))
    names = [f"a_{j} by {state.method}" for j in "AB"[: len(true)]]
    return list(_compared(names, state.amplitude, state.error, true, own))


def _model(given: Case, largest: np.ndarray, forced: bool = True) -> rom.Model:
    small, law = reduced(given, forced)
    tolerance = 1e-3 if len(given.modes) == 1 and given.law in MODE_SLIDERS else 1e-2
    return rom.tabulate(small, law, (1.3 * largest).tolist(), tolerance)


def table(given: Case) -> list[Answer]:
    """Amplitudes of `rom.steady`, with the error of a response curve through the same point."""
    exact = solution(given)
    small, _ = reduced(given)
    true, own = amplitudes(given, small, exact)
    Omega = np.array([tone.Omega for tone in given.tones])

    def answer():
        model = _model(given, np.abs(true))
        a = rom.steady(model, Omega, forces(given))
        curve = rom.response_curve(
            model, Omega, forces(given), "frequency_A", Omega[0] * (1.0 + np.array([-2e-3, 2e-3]))
        )
        nearest = int(np.argmin(np.abs(curve.parameter - Omega[0])))
        return a, curve.error[nearest]

    a, stated = limited(answer)
    return list(_compared([f"a_{j}" for j in "AB"[: len(true)]], a, stated, true, own))


def curve(given: Case) -> list[Answer]:
    """Points of a response curve of one mode, 3 % to each side of the drawn frequency."""
    tone = given.tones[0]
    small, _ = reduced(given)
    peak = np.abs(amplitudes(given, small, solution(given))[0])
    span = tone.Omega * (1.0 + SWEEP_SPAN * np.array([-1.0, 1.0]))
    found = limited(
        lambda: rom.response_curve(
            _model(given, 1.5 * peak), [tone.Omega], forces(given), "frequency_A", span
        )
    )
    answers = [Answer(f"{p.kind} at {p.parameter:.6g}", 1.0, 0.0, 0.0) for p in found.special]
    size = np.abs(found.amplitude[:, 0])
    wanted = np.linspace(-0.9, 0.9, 5) * SWEEP_SPAN * tone.Omega + tone.Omega
    points = {int(np.argmin(np.abs(found.parameter - Omega))) for Omega in wanted}
    points.add(int(np.argmax(size)))
    for k in sorted(points):
        Omega = float(found.parameter[k])
        exact = solution(given, (Tone(Omega, tone.F),), 256)
        true, own = amplitudes(given, small, exact)
        answers += _compared(
            [f"Omega / carrier {Omega / tone.Omega:.5f}"],
            *(found.amplitude[k], found.error[k], true, own),
        )
    return answers


def backbone(given: Case) -> list[Answer]:
    """Frequency and damping of a nonlinear mode at six amplitudes."""
    largest = given.amplitude[0]
    sizes = largest * np.geomspace(0.1, 1.0, 6)
    found = limited(
        lambda: rom.backbone(_model(given, np.array([largest]), forced=False), amplitude=sizes)
    )
    shape = given.shapes[:, 0]
    answers: list[Answer] = []
    mode = coarse = None
    for k, a in enumerate(sizes):
        mode = nonlinear_mode(given.system, shape, 2.0 * a, mode, alone=True)
        coarse = nonlinear_mode(given.system, shape, 2.0 * a, coarse, 9, alone=True)
        answers += _compared(
            [f"frequency at {a / largest:.2f}", f"damping at {a / largest:.2f}"],
            [found.frequency[k], found.damping[k]],
            [found.frequency_error[k], found.damping_error[k]],
            [mode.omega, mode.zeta],
            [abs(mode.omega - coarse.omega), abs(mode.zeta - coarse.zeta)],
        )
    return answers


KINDS: dict[str, tuple[Callable[[Case], list[Answer]], Callable[[int], Case]]] = {
    "direct": (direct, variant),
    "table": (table, variant),
    "curve": (curve, lambda seed: variant(seed, modes=1)),
    "backbone": (backbone, lambda seed: variant(seed, MODE_SLIDERS, 1)),
}
