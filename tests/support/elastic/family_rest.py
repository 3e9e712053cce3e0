"""Runs from rest of the seeded family under constant forces: slow flow against full order.

`make family-rest` prints a line for each member, then how many are how far off, and draws the
error against its estimate. SEEDS and LIMIT (CPU seconds a table may
take) and where the picture goes as arguments.
"""

import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from multiprocessing import get_context

import numpy as np
from elastic.family import Member, member
from elastic.family_report import WEAK, TooLongError, limited

from slipmode import rom
from slipmode.fmu import Component, StoppedError
from slipmode.rom import SlowTrajectory, full, sum_harmonics
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.slow.slow_flow import inputs_of, rates, slow_flow
from slipmode.rom.slow.transient import TransientError
from slipmode.runner.transients.demodulation import carrier_signal, slow_parts, window_length

SEEDS, LIMIT, PICTURE = 120, 60, "logs/family-rest.png"
REQUIRED = 0.01  # RMS, where the estimated transient error is as small
TOLERANCE = {1: 3e-3, 2: 5e-3}  # of the table, by modes
SAMPLES, STEPS = 32, 96  # per period of the fastest forcing
MOST_CYCLES, LEAST_CYCLES = 400, 20
SETTLED = 0.02  # of the final amplitude: the run-in ends within
POINTS = 8  # per period of the slowest forcing: of the slow trajectory
MARGINS = (1.2, 1.5, 2.0)  # of the amplitude range, over what full order reaches


@dataclass(frozen=True, eq=False)
class Reference:
    """Full order from rest.

    Attributes
    ----------
    time : (n,) ndarray
    displacement : (n, modes) ndarray
        Of the retained modes.
    amplitude : (points, modes) complex ndarray
        What is slow in them.
    run_in : float
        Time until the amplitudes are what they will be [s].
    """

    time: np.ndarray
    displacement: np.ndarray
    amplitude: np.ndarray
    run_in: float


@dataclass(frozen=True, eq=False)
class Run:
    """The slow flow from rest beside it.

    Attributes
    ----------
    error, at_end : (modes,) ndarray
        RMS of the modal displacement, fast motion and all, over the run-in, and over its last
        tenth: what is no matter of the transient.
    estimate : (modes,) ndarray
        The largest `TransientError`, relative to the largest amplitude.
    offset : (modes,) ndarray
        What the last tenth is about at full order, as a share of its RMS: contacts that slipped
        as modes that are not retained rang keep it, and the slow flow has none.
    """

    error: np.ndarray
    at_end: np.ndarray
    estimate: np.ndarray
    offset: np.ndarray


def reduced_at_forcing(case: Member) -> rom.Reduced:
    """With what the forces do past their modes in the contact problem."""
    return rom.reduce(
        *(case.structure, case.modes),
        law=case.law,
        carrier=case.frequency,
        force_patterns=list(case.force),
    )


def at_full_order(case: Member) -> Reference:
    """Until the slowest mode has come to rest, were it alone and linear, or MOST_CYCLES."""
    reduced = reduced_at_forcing(case)
    frequency = np.array(case.frequency)
    cycle, window = 2 * np.pi / frequency.min(), window_length(frequency[np.newaxis])
    duration = min(6.0 / reduced.modal_damping.min(), MOST_CYCLES * cycle)
    duration = max(duration, LEAST_CYCLES * cycle + window, 3 * window)
    spacing = 2 * np.pi / frequency.max() / SAMPLES
    motion = full.integrate(
        *(case.structure, case.law),
        full.Excitation.harmonic(case.structure, case.force, frequency),
        spacing * np.arange(1, int(np.ceil(duration / spacing)) + 1),
        outputs=reduced.mode_shapes.T @ case.structure.mass,
        steps_per_period=STEPS,
    )
    at = np.arange(0.5 * window, duration - 0.5 * window, 0.5 * cycle)
    moving = motion.displacement, motion.velocity
    amplitude = slow_part(motion.time, *moving, frequency, at)
    final = amplitude[-max(len(at) // 10, 1) :].mean(axis=0)
    moves = np.linalg.norm(reduced.coupling, axis=1)
    off = np.linalg.norm(moves * (amplitude - final), axis=1)
    unsettled = at[off > SETTLED * np.linalg.norm(moves * final)]
    run_in = max(unsettled[-1] if unsettled.size else 0.0, LEAST_CYCLES * cycle, 2 * window)
    return Reference(motion.time, moving[0], amplitude, min(run_in, duration - window))


def slow_part(
    time: np.ndarray, q: np.ndarray, v: np.ndarray, frequency: np.ndarray, at: np.ndarray
) -> np.ndarray:
    """What turns with the carriers in modal motion, (at, modes), of either side alike."""
    angle = np.outer(time, frequency)
    turning = carrier_signal(q, v, angle, frequency)
    return slow_parts(time, turning, angle, at, window_length(frequency[np.newaxis]))[0]


def tabulated(case: Member, reduced: rom.Reduced, reached: np.ndarray, margin: float) -> rom.Model:
    """A table for effective amplitudes (points, modes), by a margin larger."""
    tolerance = TOLERANCE[len(case.modes)]
    return rom.tabulate(
        *(reduced, case.law, margin * reached.max(axis=0), tolerance),
        harmonics=RESPONSE_ORDER,
        warned=False,
    )


def compared(case: Member, model: rom.Model, reference: Reference) -> Run:
    """The slow flow from rest, with the harmonics that modes respond to, against full order."""
    reduced, patterns = model.reduced, list(case.force)
    frequency = np.array(case.frequency)
    kept = reference.time <= reference.run_in
    time = reference.time[kept]
    stride = max(1, int(2 * np.pi / frequency.min() / POINTS / time[0]))
    points = np.append(time[:-1:stride], time[-1])
    amplitude = _followed(case, model, points)
    force = np.array([reduced.modal_force(j, f) for j, f in enumerate(patterns)], dtype=complex)
    angle = np.outer(points, frequency)
    inputs = inputs_of(np.tile(force, (points.size, 1)), frequency, angle=angle)
    rate = rates(slow_flow(model, patterns), inputs, amplitude)
    each = np.ones((points.size - 1, 1))
    trajectory = SlowTrajectory(
        *(points, amplitude, angle, each * frequency, 0.0 * each * frequency),
        *(each * force, 0.0 * each * force),
        AppliedForces.of(reduced, patterns, case.structure),
    )
    exact = reference.displacement[kept]
    difference = sum_harmonics(model, trajectory, time).modal[:, : frequency.size] - exact
    last = slice(-max(time.size // 10, 1), None)
    response = AppliedForces.of(reduced, patterns)
    acting = amplitude + response.shift * force
    estimate = TransientError.of(reduced, model.law).at(rate, frequency, acting).max(axis=0)
    moves = np.linalg.norm(reduced.coupling, axis=1)
    largest = moves * np.abs(amplitude).max(axis=0)
    return Run(
        relative_rms(reduced, difference, exact),
        relative_rms(reduced, difference[last], exact[last]),
        moves * estimate / np.maximum(largest, WEAK * largest.max()),
        relative_rms(reduced, np.broadcast_to(exact[last].mean(axis=0), exact.shape), exact),
    )


def relative_rms(reduced: rom.Reduced, difference: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """RMS (modes,) by the contact motion of each mode."""
    moves = np.linalg.norm(reduced.coupling, axis=1)
    off, size = (
        moves * np.sqrt(np.mean(np.abs(signal) ** 2, axis=0)) for signal in (difference, exact)
    )
    return np.asarray(off / np.maximum(size, WEAK * size.max()))


def _followed(case: Member, model: rom.Model, time: np.ndarray) -> np.ndarray:
    """Amplitudes (times, modes) from rest."""
    modes, patterns = "AB"[: model.modes], list(case.force)
    frequency = np.array(case.frequency)
    force = [model.reduced.modal_force(j, f) for j, f in enumerate(patterns)]
    component = Component(model, patterns, tolerance=1e-6, warned=False)
    response = AppliedForces.of(model.reduced, patterns, case.structure)
    free = response.free_vibration(np.array(force, dtype=complex), frequency)
    component.reset(amplitude=free)
    values = {"limit_scale": 1.0}
    for mode, Omega in zip(modes, frequency, strict=True):
        values |= {f"force_{mode}": 1.0, f"frequency_{mode}": Omega}
    inputs = np.tile([values.get(name, 0.0) for name in component.input_names], (time.size, 1))
    outputs = component.run(np.diff(time, prepend=0.0), inputs)
    columns = [component.output_names.index(f"{m}_{part}") for m in modes for part in ("re", "im")]
    return np.ascontiguousarray(outputs[:, columns]).view(complex)


def from_rest(case: Member, reference: Reference) -> tuple[rom.Model, Run]:
    """A table as scenes have it, as large as it takes, and the run by it."""
    reduced = reduced_at_forcing(case)
    force = np.array([reduced.modal_force(j, f) for j, f in enumerate(case.force)])
    shift = AppliedForces.of(reduced, list(case.force)).shift
    reached = np.abs(reference.amplitude + shift * force)
    for margin in MARGINS:
        model = tabulated(case, reduced, reached, margin)
        try:
            return model, compared(case, model, reference)
        except (StoppedError, rom.SlipmodeError) as reason:
            left = reason
    raise left


def outcome(seed: int, limit: float) -> tuple[Run | None, str]:
    """The comparison of a member, None where there is none, and what there is to say of it."""
    warnings.simplefilter("ignore")
    case = member(seed)
    try:
        reference = limited(5 * limit, lambda: at_full_order(case))
        _, run = limited(limit, lambda: from_rest(case, reference))
    except (rom.SlipmodeError, StoppedError, TooLongError) as reason:
        return None, f"{case.name}: NO TABLE, {reason}"
    off, left, estimate = (
        np.array2string(100 * part, precision=2) for part in (run.error, run.at_end, run.estimate)
    )
    cycles = reference.run_in * min(case.frequency) / (2 * np.pi)
    said = f"off by {off} % in {cycles:.0f} cycles, {left} % at their end"
    return run, f"{case.name}: {said}, estimated {estimate} %"


def main(seeds: int, limit: float, picture: str) -> None:
    """Print the report and draw the curve."""
    runs: dict[int, Run] = {}
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = pool.map(outcome, range(seeds), repeat(limit))
        for seed, (run, said) in enumerate(found):
            print(said, flush=True)
            if run is not None:
                runs[seed] = run
    error, estimate = (
        np.array([getattr(run, name).max() for run in runs.values()])
        for name in ("error", "estimate")
    )
    slow = estimate <= REQUIRED
    print(f"{len(runs)} of {seeds} compared, {seeds - len(runs)} without a table")
    for said, chosen in ((f"up to {REQUIRED:.0%}", slow), ("more", ~slow)):
        within = np.sum(error[chosen] <= REQUIRED)
        print(f"estimated transient error {said}: {within} of {chosen.sum()} within 1 %")
    for seed in [seed for seed, run in runs.items() if run.error.max() > REQUIRED]:
        run = runs[seed]
        said = f"at the end {run.at_end.max():.1%}, estimated {run.estimate.max():.1%}"
        print(f"  {seed}: {run.error.max():.1%}, {said}, offset {run.offset.max():.1%}")
    draw(estimate, error, picture)


def draw(estimate: np.ndarray, error: np.ndarray, picture: str) -> None:
    """Error against its estimate, with its median and worst by thirds of a decade."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    axes.loglog(100 * estimate, 100 * error, "o", markersize=4, label="a member")
    third = np.floor(3 * np.log10(estimate)).astype(int)
    met = np.unique(third)
    middle = 100 * 10 ** ((met + 0.5) / 3)
    for name, of in (("median", np.median), ("worst", np.max)):
        axes.loglog(middle, [100 * of(error[third == each]) for each in met], label=name)
    axes.axvline(100 * REQUIRED, color="0.6", linestyle=":")
    axes.axhline(100 * REQUIRED, color="0.6", linestyle=":")
    axes.set_xlabel("estimated transient error, largest [%]")
    axes.set_ylabel("RMS error from rest [%]")
    axes.legend()
    figure.savefig(picture, dpi=120)
    print(f"error against its estimate: {picture}")


if __name__ == "__main__":
    given = sys.argv[1:]
    main(
        int(given[0]) if given else SEEDS,
        float(given[1]) if len(given) > 1 else LIMIT,
        given[2] if len(given) > 2 else PICTURE,
    )
