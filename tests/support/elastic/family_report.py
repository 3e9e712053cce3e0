"""Steady states of a seeded family of structures, without a table, against full order.

`make family` prints a line for each member, then how many are how far off, and the reason where
there is no answer. SEEDS and LIMIT (CPU seconds a member may take, full order apart) as arguments.
"""

import signal
import sys
import time
import warnings

import numpy as np
from elastic.family import Member, member

from slipmode import rom
from slipmode.rom import full

SEEDS, LIMIT, TOLERANCE = 60, 120, 4e-3
WEAK = (
    0.1  # of the strongest mode's contact motion: relative to that below, as `steady_state` has it
)


class TooLongError(Exception):
    """A member took more than its CPU time."""


def solved(case: Member, tolerance: float = TOLERANCE) -> tuple[rom.Reduced, rom.SteadyState]:
    """The steady state of a member."""
    reduced = rom.reduce(
        case.structure, case.modes, law=case.law, carrier=case.frequency, smallest_response=1e-5
    )
    return reduced, rom.steady_state(reduced, case.law, case.frequency, case.force, tolerance)


def full_order(
    case: Member, reduced: rom.Reduced, near: np.ndarray, tolerance: float = 3e-4
) -> full.SteadyAmplitude:
    """Amplitudes of the retained modes by integration from a state near by."""
    Omega = np.array(case.frequency)
    shapes = reduced.mode_shapes
    start = full.State(0.0, 2 * np.real(shapes @ near), 2 * np.real(shapes @ (1j * Omega * near)))
    return full.steady_amplitude(
        case.structure,
        case.law,
        full.Excitation.harmonic(case.structure, case.force, Omega),
        outputs=shapes.T @ case.structure.mass,
        tolerance=tolerance,
        steps_per_period=128,
        start=start,
        most_windows=40,
    )


def relative(reduced: rom.Reduced, found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """Errors (modes,) by the contact motion of each mode."""
    moves = np.linalg.norm(reduced.coupling, axis=1)
    motion = moves * np.abs(expected)
    return moves * np.abs(found - expected) / np.maximum(motion, WEAK * motion.max())


def limited(seconds, call):
    """A call's result; TooLongError after so many CPU seconds."""

    def stop(*_):
        raise TooLongError(f"took more than {seconds:g} CPU s")

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        return call()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def of_full_order(case: Member, limit: float) -> str:
    """Whether a member that has no answer has a steady state at all, from rest."""
    reduced = rom.reduce(case.structure, case.modes, law=case.law)
    try:
        limited(limit, lambda: full_order(case, reduced, np.zeros(len(case.modes))))
    except TooLongError:
        return "full order from rest takes longer"
    except rom.SlipmodeError as reason:
        return f"full order from rest: {reason}"
    return "full order from rest has one"


def main(seeds: int, limit: float) -> None:
    """Print the report."""
    warnings.simplefilter("ignore")
    errors, unsolved = {}, {}
    for seed in range(seeds):
        case, begun = member(seed), time.process_time()
        try:
            reduced, state = limited(limit, lambda case=case: solved(case))
        except (rom.SlipmodeError, TooLongError) as reason:
            unsolved[seed] = f"{reason}; {of_full_order(case, limit)}"
            print(f"{case.name}: NO ANSWER, {unsolved[seed]}", flush=True)
            continue
        cost = time.process_time() - begun
        try:
            reference = limited(
                5 * limit,
                lambda: full_order(case, reduced, state.amplitude),  # noqa: B023
            )
        except (rom.SlipmodeError, TooLongError) as reason:
            unsolved[seed] = f"full order: {reason}"
            print(f"{case.name}: no full order to compare with, {reason}", flush=True)
            continue
        expected = np.diagonal(reference.amplitude)
        off = relative(reduced, state.amplitude, expected)
        errors[seed] = off.max()
        own = relative(reduced, expected + np.diagonal(reference.error), expected)
        print(
            f"{case.name}: off by {np.array2string(100 * off, precision=3)} %, stated "
            f"{100 * relative(reduced, state.amplitude + state.error, state.amplitude).max():.2g}"
            f" %, full order's own {100 * own.max():.1g} %, {cost:.1f} CPU s",
            flush=True,
        )
    found = np.array(list(errors.values()))
    print(f"{found.size} of {seeds} compared; within 0.5 %: {np.sum(found <= 5e-3)}")
    print(f"within 0.5 % of all: {np.sum(found <= 5e-3) / seeds:.0%}; no comparison:")
    for seed, reason in unsolved.items():
        print(f"  {seed}: {reason}")


if __name__ == "__main__":
    main(*([int(sys.argv[1]), float(sys.argv[2])] if len(sys.argv) > 2 else [SEEDS, LIMIT]))
