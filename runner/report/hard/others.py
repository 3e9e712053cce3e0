"""Other integrators on a hard case: do they finish, at what cost, how far off."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.integrate import ODEintWarning

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Floats
from slipmode.runner.report.cases.cases import Case
from slipmode.runner.report.hard.signals import reference
from slipmode.runner.report.measure import relative_rms
from slipmode.runner.report.peers import first_order

DURATION = 100.0  # [s], from rest: what takes an implicit integrator in Python a second
PATIENCE = 2.0  # [s] of wall time
_FULL_STEPS = 64  # per period: the default of rom.full
_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Attempt:
    """One method on one case.

    Attributes
    ----------
    method : str
    seconds : float
    error : float
        RMS of the displacements, the worst column; NaN where there are none.
    failure : str
        Why there are none, in a word or two.
    """

    method: str
    seconds: float
    error: float
    failure: str = ""


class _OutOfPatienceError(Exception):
    """The right-hand side was asked for after the time was up."""


class _Impatient(first_order.FirstOrder):
    """Equations of motion that end an integration which takes too long."""

    def __init__(self, case: Case) -> None:
        super().__init__(case)
        self._end = time.perf_counter() + PATIENCE

    def rate(self, t: float, y: Floats) -> Floats:
        if time.perf_counter() > self._end:
            raise _OutOfPatienceError
        return super().rate(t, y)


def attempts(motion: Case) -> list[Attempt]:
    """Full order and the general-purpose integrators on the first part of a motion."""
    case = replace(motion, duration=DURATION)
    exact = reference(case)
    methods: dict[str, Callable[[Case], Floats]] = {"full order": _full_order}
    names = ("lsoda", "radau", *(("cvode",) if first_order.HAS_CVODE else ()))
    methods.update((name, partial(_general_purpose, name)) for name in names)
    return [_attempt(name, partial(method, case), exact) for name, method in methods.items()]


def _attempt(name: str, run: Callable[[], Floats], exact: Floats) -> Attempt:
    started = time.perf_counter()
    try:
        found = run()
    except _OutOfPatienceError:
        return Attempt(name, PATIENCE, float("nan"), "too slow")
    except rom.SlipmodeError as refusal:
        return Attempt(name, 0.0, float("nan"), str(refusal))
    except ODEintWarning:
        return Attempt(name, time.perf_counter() - started, float("nan"), "gives up")
    seconds = time.perf_counter() - started
    if found.shape != exact.shape or not np.isfinite(found).all():
        return Attempt(name, seconds, float("nan"), "gives up")
    return Attempt(name, seconds, relative_rms(found, exact))


def _full_order(case: Case) -> Floats:
    return full.integrate(
        *(case.structure, case.law, case.excitation, case.times),
        outputs=case.observed,
        steps_per_period=_FULL_STEPS,
    ).displacement


def _general_purpose(name: str, case: Case) -> Floats:
    """States by one of the peers; what it warns of is a failure, as its states are wrong then."""
    if isinstance(case.law, rom.Coulomb):
        raise rom.SlipmodeError("no set-valued law")
    with warnings.catch_warnings():
        warnings.simplefilter("error", ODEintWarning)
        states = getattr(first_order, name)(_Impatient(case), case.times, _TOLERANCE)
    return np.asarray(states[:, list(case.observed)])
