"""Steady states of many loads on one model, each by itself: one may be refused, others not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats
from slipmode.rom.errors import OutsideTableError, SlipmodeError
from slipmode.rom.reduction.force_response import Forces, off_resonance_shift
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.steady_problem import SteadyProblem
from slipmode.rom.table.hermite import outside_table
from slipmode.rom.table.model import Model
from slipmode.rom.validity import check_carriers


@dataclass(frozen=True, eq=False)
class SteadyPoints:
    """Steady amplitudes where there are any, and why there are none elsewhere.

    Attributes
    ----------
    amplitude : (points, modes) complex ndarray
        a_j [kg^1/2 m]; NaN where there is none.
    reason : list of str
        Of each point; empty where there is an amplitude.
    outside : (points,) ndarray of bool
        Whether the friction table ends before the point, so that a larger one would help.
    """

    amplitude: Complexes
    reason: list[str]
    outside: Flags

    __repr__ = short_repr


def steady_points(
    model: Model, frequency: Floats, patterns: Forces, excitation: Complexes
) -> SteadyPoints:
    """`rom.steady` of many loads.

    Parameters
    ----------
    model : Model
    frequency : (points, modes) ndarray
        [rad/s]
    patterns : one {DOF: amplitude} or (n,) array_like per mode
        Where the forces act; their scale does not matter.
    excitation : (points, modes) complex ndarray
        F_j exp(i phase_j), modal [N kg^-1/2].
    """
    found = SteadyPoints(
        np.full(frequency.shape, np.nan, dtype=complex),
        [""] * len(frequency),
        np.zeros(len(frequency), dtype=bool),
    )
    followed = []
    for k in range(len(frequency)):
        try:
            check_carriers(model.reduced, frequency[k], excitation[k] != 0.0)
        except SlipmodeError as refusal:
            found.reason[k] = str(refusal)
        else:
            followed.append(k)
    if followed:
        shift = off_resonance_shift(model.reduced, patterns)
        problem = SteadyProblem.of(model, shift, frequency[followed], excitation[followed])
        _solve(problem, np.array(followed), found)
    return found


def _solve(problem: SteadyProblem, places: np.ndarray, found: SteadyPoints) -> None:
    """Fill in the points of a problem; one that spoils the passes of the others goes alone."""
    try:
        amplitude = problem.polish(problem.relax())
        stands = problem.is_steady(amplitude)
    except (SlipmodeError, np.linalg.LinAlgError) as refusal:
        if len(places) == 1:
            _refuse(int(places[0]), refusal, found)
            return
        for k in range(len(places)):
            _solve(problem.only(slice(k, k + 1)), places[k : k + 1], found)
        return
    edge = np.asarray(problem.at_edge(amplitude).any(axis=1))
    effective = problem.effective_modulus(amplitude, problem.inputs)
    for k, place in enumerate(places.tolist()):
        if stands[k]:
            found.amplitude[place] = amplitude[k]
        elif edge[k]:
            found.outside[place] = True
            found.reason[place] = str(outside_table(effective[k], problem.model.table))
        else:
            _from_rest(problem.only(slice(k, k + 1)), place, found)


def _from_rest(problem: SteadyProblem, place: int, found: SteadyPoints) -> None:
    try:
        found.amplitude[place] = problem.from_rest()
    except (SlipmodeError, np.linalg.LinAlgError) as refusal:
        _refuse(place, refusal, found)


def _refuse(place: int, why: Exception, found: SteadyPoints) -> None:
    found.outside[place] = isinstance(why, OutsideTableError)
    found.reason[place] = str(why)
