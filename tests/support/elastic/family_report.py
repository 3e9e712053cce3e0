"""Steady states of a seeded family of structures, without a table, against full order.

`make family` prints a line for each member, then how many are how far off, and the reason where
there is no answer. SEEDS and LIMIT (CPU seconds a member may take, full order apart) as arguments.

Full order continues the motion that was found, contacts and all: where sliders have several
steady means, that decides between them. A member has no steady state if full order does not
settle, or if OFF_LATTICE of its contacts' motion (RMS) lies beside n Omega_A + m Omega_B.
"""

import ctypes
import signal
import sys
import time
import warnings

import numpy as np
from elastic.family import Member, member

from slipmode import rom
from slipmode.rom import full, kernel
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.steady import OFF_LATTICE, nonharmonic_motion

SEEDS, LIMIT, TOLERANCE = 60, 120, 4e-3
# of the strongest mode's contact motion: relative to that below, as `steady_state` has it
WEAK = 0.1
PERIODS, WINDOWS = 400, 12  # where windows that suffice for most do not settle


class TooLongError(Exception):
    """A member took more than its CPU time."""


def solved(case: Member, tolerance: float = TOLERANCE) -> tuple[rom.Reduced, rom.SteadyState]:
    """The steady state of a member."""
    reduced = rom.reduce(
        case.structure, case.modes, law=case.law, carrier=case.frequency, smallest_response=1e-6
    )
    return reduced, rom.steady_state(reduced, case.law, case.frequency, case.force, tolerance)


def on(case: Member, state: rom.SteadyState) -> full.State:
    """Full order on a steady motion at t = 0, its contacts as the motion left them."""
    c, nu = state.displacement_harmonics(), state.harmonics.frequency
    W, contacts = case.structure.directions, case.structure.n_contacts
    elastic = case.law.elements(contacts).kernel()
    memory = np.zeros(kernel.lib.sm_elastic_memory(ctypes.byref(elastic)))
    force = np.empty(contacts)
    period = 2 * np.pi / state.reduced.carrier.min()
    steps = int(256 * state.reduced.carrier.max() / state.reduced.carrier.min())
    for t in np.linspace(-3 * period, 0.0, 3 * steps + 1):
        x_c = kernel.contiguous(2 * np.real(np.exp(1j * nu * t) @ c) @ W)
        kernel.check(
            kernel.lib.sm_elastic_force(
                *(ctypes.byref(elastic), contacts, x_c.ctypes.data),
                *(memory.ctypes.data, force.ctypes.data),
            ),
            "forces on the contacts",
        )
    return full.State(
        *(0.0, 2 * np.real(c.sum(axis=0)), 2 * np.real((1j * nu) @ c)), contact_memory=memory
    )


def full_order(
    case: Member, reduced: rom.Reduced, start: full.State | None, tolerance: float = 3e-4
) -> tuple[full.SteadyAmplitude, float]:
    """Amplitudes of the retained modes by integration, and the share beside the lattice."""
    excitation = full.Excitation.harmonic(case.structure, case.force, np.array(case.frequency))
    outputs = reduced.mode_shapes.T @ case.structure.mass

    def settled(**windows: int) -> full.SteadyAmplitude:
        return full.steady_amplitude(
            *(case.structure, case.law, excitation),
            outputs=outputs,
            tolerance=tolerance,
            steps_per_period=128,
            start=start,
            **windows,
        )

    try:
        found = settled(most_windows=40)
    except rom.SlipmodeError:
        found = settled(most_windows=WINDOWS, periods=PERIODS)
    integrator = Integrator(case.structure, case.law, excitation, outputs, 128)
    return found, nonharmonic_motion(integrator, found.end).share


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


def of_full_order(case: Member, limit: float) -> tuple[bool, str]:
    """Whether a member that has no answer may have a steady state at all, from rest."""
    reduced = rom.reduce(case.structure, case.modes, law=case.law)
    try:
        _, share = limited(limit, lambda: full_order(case, reduced, None))
    except TooLongError:
        return True, "full order from rest takes longer"
    except rom.SlipmodeError as reason:
        return False, f"full order from rest: {reason}"
    if share > OFF_LATTICE:
        return False, f"full order from rest: {share:.1%} of the motion beside the lattice"
    return True, "full order from rest has one"


def main(seeds: int, limit: float) -> None:
    """Print the report."""
    warnings.simplefilter("ignore")
    errors, unsolved, unsteady, understated = {}, {}, {}, []
    integrated = []
    for seed in range(seeds):
        case, begun = member(seed), time.process_time()
        try:
            reduced, state = limited(limit, lambda case=case: solved(case))
        except (rom.SlipmodeError, TooLongError) as reason:
            steady, why = of_full_order(case, 5 * limit)
            (unsolved if steady else unsteady)[seed] = f"{reason}; {why}"
            print(f"{case.name}: NO ANSWER, {reason}; {why}", flush=True)
            continue
        cost = time.process_time() - begun
        try:
            start = on(case, state)
            reference, share = limited(
                5 * limit,
                lambda: full_order(case, reduced, start),  # noqa: B023
            )
        except (rom.SlipmodeError, TooLongError) as reason:
            unsteady[seed] = f"{state.method}; full order: {reason}"
            print(f"{case.name}: no full order to compare with, {reason}", flush=True)
            continue
        if share > OFF_LATTICE:
            unsteady[seed] = f"{state.method}; full order: {share:.1%} beside the lattice"
            print(f"{case.name}: full order is {share:.1%} beside the lattice", flush=True)
            continue
        expected = np.diagonal(reference.amplitude)
        off = relative(reduced, state.amplitude, expected)
        errors[seed] = off.max()
        own = relative(reduced, expected + np.diagonal(reference.error), expected).max()
        stated = relative(reduced, state.amplitude + state.error, state.amplitude).max()
        if off.max() > stated + own:
            understated.append(seed)
        if state.method == "integration":
            integrated.append(seed)
        print(
            f"{case.name}: off by {np.array2string(100 * off, precision=3)} %, stated "
            f"{100 * stated:.2g} %, full order's own {100 * own:.1g} %, {share:.1%} beside the "
            f"lattice, by {state.method}, {cost:.1f} CPU s",
            flush=True,
        )
    found = np.array(list(errors.values()))
    good, steady = np.sum(found <= 5e-3), found.size + len(unsolved)
    print(f"{steady} of {seeds} have a steady state; {good} within 0.5 %: {good / steady:.0%}")
    print(f"compared: {found.size}, of these by integration: {integrated}")
    print(f"worse than 0.5 %: {[seed for seed, error in errors.items() if error > 5e-3]}")
    print(f"worse than stated, full order's own error apart: {understated}")
    for title, members in (("no answer", unsolved), ("no steady state", unsteady)):
        print(f"{title}: {len(members)}")
        for seed, reason in members.items():
            print(f"  {seed}: {reason}")


if __name__ == "__main__":
    main(*([int(sys.argv[1]), float(sys.argv[2])] if len(sys.argv) > 2 else [SEEDS, LIMIT]))
