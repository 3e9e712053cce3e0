"""The smallest model that describes measured loops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom import Jenkins, Sliders, SlipmodeError
from slipmode.rom.common import in_one_line, percentage, short_list
from slipmode.rom.identification.loops.loop import Loop, Strokes
from slipmode.rom.identification.loops.model import Terms
from slipmode.rom.identification.loops.problem import Fitted
from slipmode.rom.identification.loops.result import LoopFit, LoopLaw

# A term must lower the rms error by this share, and by this much of the peak force. Of models
# whose errors differ by less, the one with the fewest parameters is taken, elements before a
# distribution.
GAIN, LEAST_GAIN = 0.05, 1e-3
LARGE_ERROR = 0.2  # error of the peak force from which the model is doubtful
SAMPLES = 1500  # of a loop, for the choice of the terms
MOST_SAMPLES = 20_000  # of a loop, for the fit of the chosen model
# Limit of a slider that is a spring, relative to the largest force of the spring
SPRING = 1e3


def fit_loops(loops: Loop | Sequence[Loop]) -> LoopFit:
    """Return the contact law of a joint from measured loops of force against displacement.

    Parameters
    ----------
    loops : Loop or sequence of Loop
        Loops of one joint, from `rom.read_loops` or arrays. Several loops are levels of the
        normal load: they have common stiffnesses, and each has its own friction limits and
        backlash.

    Returns
    -------
    LoopFit
        Contact laws, parameters with intervals, and the rms error of the loops.

    Raises
    ------
    SlipmodeError
        If a loop has fewer than two cycles, dissipates no energy, or has values that are not
        allowed.

    Notes
    -----
    Jenkins elements in parallel make the force. The first model is one element. Further
    terms are limits by direction, a backlash in series, a spring in parallel, another element, and
    Segalman's four-parameter distribution instead of the elements. The term that lowers the rms
    error most is added if it lowers it by at least 5 % and by 0.1 % of the peak force, until no
    term does. If several larger models differ by less in their errors, the one with the fewest
    parameters is taken, elements before a distribution.

    The first two strokes of a loop settle the contacts and are not compared. Inertia and viscous
    forces are not part of the model: measure slowly. Errors are relative to the peak force of each
    loop. Intervals of 99 % follow from the scatter of the cycles, with Student's distribution;
    they are infinite if a loop has fewer than three cycles.

    Contact laws of structures have neither a backlash nor limits by direction. Limits by direction
    without a backlash are a law with equal limits, and a constant force. If there is a backlash,
    the law is the smallest model without it.
    """
    given = [loops] if isinstance(loops, Loop) else loops
    if not isinstance(given, Sequence) or not given:
        raise SlipmodeError(f"loops: must be one or more of rom.Loop, got {in_one_line(loops)}")
    levels = [Strokes.of(loop) for loop in given]
    names = [level.name for level in levels]
    if repeated := sorted({name for name in names if names.count(name) > 1}):
        raise SlipmodeError(f"loops: the name {short_list(repeated)} occurs more than once")
    notes = [f"{loop.name}: {note}" for loop in given for note in loop.notes]
    full = [level.thinned(MOST_SAMPLES) for level in levels]
    first = _first([level.thinned(SAMPLES) for level in levels])
    small, tried = _grown(first, backlash=True)
    found = law = small.on(full)
    if found.terms.backlash:
        law = _grown(first, backlash=False)[0].on(full)
    return LoopFit(
        model=str(found.terms),
        parameters=found.parameters(),
        interval=found.intervals(),
        error=dict(zip(names, found.errors.tolist(), strict=True)),
        laws={level.name: _law(law, i) for i, level in enumerate(levels)},
        law_error=dict(zip(names, law.errors.tolist(), strict=True)),
        mean_force={level.name: _mean_force(law, i) for i, level in enumerate(levels)},
        tried={str(terms): error for terms, error in tried.items()},
        warnings=(*notes, *_warnings(found, law)),
        fitted=found,
        law_fitted=law,
    )


def _first(levels: Sequence[Strokes]) -> Fitted:
    """Return the fit of one Jenkins element."""
    peak = [level.peak for level in levels]
    starts = [
        {"stiffness_1": steep * max(peak) / _reach(levels)}
        | {f"{i}.limit": each for i, each in enumerate(peak)}
        for steep in (2.0, 10.0, 50.0)
    ]
    return min((Fitted.of(Terms(), levels, start) for start in starts), key=_error)


def _grown(best: Fitted, *, backlash: bool) -> tuple[Fitted, dict[Terms, float]]:
    """Return the smallest sufficient model that has the terms of a fit, and the tried errors."""
    tried = {best.terms: best.error}
    while True:
        larger = [
            Fitted.of(terms, best.levels, start)
            for terms, start in best.terms.larger(best.values, _reach(best.levels))
            if backlash or not terms.backlash
        ]
        for each in sorted(larger, key=_error, reverse=True):
            tried[each.terms] = each.error
        least = min(map(_error, larger), default=best.error)
        gain = max(GAIN * best.error, LEAST_GAIN)
        if best.error - least < gain:
            return best, tried
        as_good = [each for each in larger if each.error - least < gain]
        best = min(as_good, key=lambda x: (x.logarithms.size, not x.terms.elements, x.error))


def _reach(levels: Sequence[Strokes]) -> float:
    """Return the largest displacement from the middle [m]."""
    return max(float(np.ptp(level.used_displacement)) / 2.0 for level in levels)


def _error(fitted: Fitted) -> float:
    return fitted.error


def _law(found: Fitted, level: int) -> LoopLaw:
    """Return the contact law with equal limits in both directions."""
    terms, values = found.terms, found.values
    limit = float(np.mean(found.limits(level, values)))
    if not terms.spring and terms.elements == 1:
        return Jenkins(limit, values["stiffness_1"])
    if not terms.spring and not terms.elements:
        return terms.iwan(values, limit)
    k, share = terms.sliders(values)
    limits = limit * share
    if terms.spring:
        reach = float(np.ptp(found.levels[level].used_displacement))
        k = np.append(k, values["spring"])
        limits = np.append(limits, SPRING * values["spring"] * reach)
    return Sliders(limits.tolist(), k.tolist())


def _mean_force(law: Fitted, level: int) -> float:
    forward, backward = law.limits(level, law.values)
    return 0.5 * (forward - backward)


def _warnings(found: Fitted, law: Fitted) -> list[str]:
    lines = []
    errors = ", ".join(map(percentage, law.errors))
    if found.terms.backlash:
        lines.append(
            "contact laws of structures have no backlash; the law without it has an rms error of "
            f"{errors} of the peak force"
        )
    if found.terms.direction or law.terms.direction:
        forces = ", ".join(f"{_mean_force(law, i):.3g} N" for i in range(len(law.levels)))
        lines.append(
            "contact laws of structures have equal limits in both directions; the loops have the "
            f"law and a constant force of {forces}"
        )
    lines += [*_shortcomings(found), *_unshared("models", found)]
    return lines if law is found else [*lines, *_unshared("contact laws", law)]


def _shortcomings(found: Fitted) -> list[str]:
    lines = []
    open_ends = [name for name, ends in found.intervals().items() if not np.isfinite(ends).all()]
    single = [level.name for level in found.levels if level.cycles < 2]
    if single:
        lines.append(
            f"{short_list(single)}: one cycle after the first one has no scatter; intervals need "
            "three cycles in all"
        )
    elif open_ends:
        lines.append(
            f"the loops do not determine {short_list(open_ends)}; a limit needs loops with slip"
        )
    if found.error > LARGE_ERROR:
        lines.append(
            f"the model has an rms error of {percentage(found.error)} of the peak force: no model "
            "of this family describes the loops"
        )
    return lines


def _unshared(name: str, fitted: Fitted) -> list[str]:
    """Return in a line if the levels are described better by stiffnesses of their own."""
    if len(fitted.levels) == 1:
        return []
    alone = [_alone(fitted, i) for i in range(len(fitted.levels))]
    if np.sqrt(np.mean(np.square(alone))) > (1.0 - GAIN) * fitted.error:
        return []
    errors = ", ".join(map(percentage, alone))
    return [
        f"the {name} of the loops do not share their stiffness: fitted one by one, they have rms "
        f"errors of {errors}; fit the loops separately"
    ]


def _alone(found: Fitted, level: int) -> float:
    """Return the error of the same model with all parameters fitted to one level."""
    values = {
        f"0.{name.partition('.')[2]}" if name.startswith(f"{level}.") else name: value
        for name, value in found.values.items()
        if name.startswith(f"{level}.") or "." not in name
    }
    return Fitted.of(found.terms, [found.levels[level].thinned(SAMPLES)], values).error
