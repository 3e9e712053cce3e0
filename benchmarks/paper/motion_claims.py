"""Claims on modes, contact motion and forces: Secs. 2 and 3, Figs. 4 to 9."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.measure import worst_rms
from benchmarks.paper.case import ALPHA, BETA, Case, Signals
from benchmarks.paper.claim import Claims, Found
from benchmarks.paper.study import PERIODS, Study
from benchmarks.peers.paper_scheme import paper_scheme
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.torus.grid import Discretisation

_USED = f"alpha {ALPHA:g}, beta {BETA:g}"
_AGREEMENT = 0.1  # largest difference over the peak that counts as agreement
_TWO_PERIOD_POINTS = ((1.3, 1.5), (2.5, 0.3), (0.9, 0.36))  # |A|, |B|

CLAIMS = Claims()


@CLAIMS.add(
    "Sec. 3",
    "natural frequencies 1 and 1.7, mode shapes (1, 0) and (0, 1)",
    "follows from Table 1",
)
def _bonded_modes(study: Study) -> Found:
    reduced = study.case.paper.reduced
    error = np.abs(reduced.mode_shapes[:2] - np.eye(2)).max()
    omega_A, omega_B = reduced.frequency
    ours = {"omega_A": omega_A, "omega_B": omega_B, "error of shapes": error}
    return ours, np.allclose(reduced.frequency, [1, 1.7]) and error < 1e-9


@CLAIMS.add(
    "Sec. 2.2",
    "the inertia of the contacts is negligible",
    f"{_USED}; steady amplitudes at full order, m_c 0.01 against 0.001; bound 1 %",
)
def _contact_inertia(study: Study) -> Found:
    heavy, light = (
        replace(study.case, contact_mass=mass).steady_by_full_order() for mass in (0.01, 0.001)
    )
    change = np.abs(light - heavy) / np.abs(heavy)
    return {"change of A": change[0], "change of B": change[1]}, change.max() < 0.01


@CLAIMS.add(
    "Sec. 3",
    "contact motion is much smaller than the modal displacements",
    f"{_USED}; peaks; bound 10 %",
)
def _small_contact_motion(study: Study) -> Found:
    ratio = np.abs(study.both.contact).max(axis=0) / np.abs(study.both.elastic).max(axis=0)
    return {"x_c1 / x_e1": ratio[0], "x_c2 / x_e2": ratio[1]}, ratio.max() < 0.1


@CLAIMS.add(
    "Sec. 2.2",
    "two periods suffice for a periodic contact motion",
    "error of Q by scheme (31), 100 steps a period, against the converged Q; bound 5 %; "
    "near the threshold finer steps do not help, more periods do",
)
def _two_periods(study: Study) -> Found:
    reduced, points = study.case.paper.reduced, _TWO_PERIOD_POINTS
    ours: dict[str, float] = {}
    for alpha in (ALPHA, 0.005):
        law = replace(study.case.law, alpha=alpha)
        exact = ContactProblem.of(reduced, law).on(Discretisation(1024, 64)).solve(points).Q
        found = paper_scheme(reduced, law, points, 100, corner=False)
        error = (np.abs(found - exact) / np.abs(exact)).max(axis=1)
        names = [f"at ({A:g}, {B:g}), alpha {alpha:g}" for A, B in points]
        ours |= zip(names, error, strict=True)
    return ours, max(ours.values()) < 0.05


@CLAIMS.add(
    "Fig. 4",
    "contact trajectories are straight lines with one mode, not with two",
    f"{_USED}; width over length, singular values; bounds 0.1 and 0.3",
)
def _straight_trajectories(study: Study) -> Found:
    alone_a, alone_b, both = map(_width, (study.alone_a, study.alone_b, study.both))
    ours = {"A alone": alone_a, "B alone": alone_b, "both": both}
    return ours, max(alone_a, alone_b) < 0.1 and both > 0.3


@CLAIMS.add(
    "Fig. 5",
    "with one mode the friction cycle is a stable rectangle, its loss constant",
    f"{_USED}; {PERIODS - 1} periods of A; bounds 1 % and 0.9",
)
def _rectangle(study: Study) -> Found:
    spread, filling, _ = _loops(study.alone_a)
    ours = {"energy spread": spread, "area / bounding box": filling}
    return ours, spread < 0.01 and filling > 0.9


@CLAIMS.add(
    "Fig. 5",
    "with two modes the friction cycle keeps changing shape and place",
    f"{_USED}; {PERIODS - 1} periods of A; bounds 5 %",
)
def _drifting_loop(study: Study) -> Found:
    spread, _, drift = _loops(study.both)
    ours = {"energy spread": spread, "centre drift / width": drift}
    return ours, min(spread, drift) > 0.05


@CLAIMS.add(
    "Fig. 7",
    "elastic and friction force add up to a nearly sinusoidal one",
    f"{_USED}; RMS beside the carriers over RMS, full order, worse contact; bound 5 %",
)
def _sinusoidal_sum(study: Study) -> Found:
    case, motion = study.case, study.both
    elastic = motion.contact @ case.contact_stiffness
    signals = {"sum": case.force_sum(motion), "elastic": elastic, "friction": motion.friction}
    ours = {
        name: float(_distortion(motion.time, signal, case.frequency).max())
        for name, signal in signals.items()
    }
    return ours, ours["sum"] < 0.05 < ours["friction"]


@CLAIMS.add(
    "Fig. 7",
    "the contact forces agree with time integration, but for the peaks",
    f"{_USED}; largest difference over peak, worse contact; bound 10 %",
)
def _forces_agree(study: Study) -> Found:
    ours = _sum_errors(study.case, study.both, study.paper, study.consistent)
    return ours, ours["paper"] < _AGREEMENT


@CLAIMS.add(
    "Fig. 8",
    "with forces 0.5, 0.75 the errors grow but stay as expected of the method",
    f"{_USED}; largest difference over peak, worse contact; bound 20 %",
)
def _errors_grow(study: Study) -> Found:
    usual = _sum_errors(study.case, study.both, study.paper, study.consistent)
    ours = _sum_errors(
        study.strong, study.both_strong, study.paper_strong, study.consistent_strong
    )
    return ours, usual["paper"] < ours["paper"] < 2 * _AGREEMENT


@CLAIMS.add(
    "Fig. 9",
    "contact displacements agree with time integration",
    f"{_USED}; relative RMS, worse contact; bound 10 %",
)
def _contacts_agree(study: Study) -> Found:
    models = {"paper": study.paper, "consistent": study.consistent}
    exact = study.both.contact
    ours = {name: worst_rms(signals.contact, exact) for name, signals in models.items()}
    return ours, ours["paper"] < _AGREEMENT


def _width(signals: Signals) -> float:
    """Second over first singular value of the trajectory (x_c1, x_c2)."""
    centred = signals.contact - signals.contact.mean(axis=0)
    first, second = np.linalg.svd(centred, compute_uv=False)
    return float(second / first)


def _loops(signals: Signals) -> tuple[float, float, float]:
    """Friction loops of the first contact, period by period of mode A.

    Spread of their energies, share of the bounding box that they fill, drift of their centres.
    """
    count = signals.time.size // PERIODS
    rows = count * np.arange(PERIODS - 1)[:, np.newaxis] + np.arange(count + 1)
    x, force = signals.contact[rows, 0], signals.friction[rows, 0]
    energy = np.sum(0.5 * (force[:, 1:] + force[:, :-1]) * np.diff(x, axis=1), axis=1)
    width, centre = np.ptp(x, axis=1), 0.5 * (x.max(axis=1) + x.min(axis=1))
    filling = np.mean(energy / (width * np.ptp(force, axis=1)))
    spread, drift = np.ptp(energy) / energy.mean(), np.ptp(centre) / width.mean()
    return float(spread), float(filling), float(drift)


def _distortion(time: Floats, signal: Floats, frequency: Floats) -> Floats:
    """RMS of the signal without its carriers over its RMS, per column."""
    angle = np.outer(time, frequency)
    carriers = np.hstack((np.cos(angle), np.sin(angle)))
    rest = signal - carriers @ np.linalg.lstsq(carriers, signal)[0]
    return np.asarray(np.linalg.norm(rest, axis=0) / np.linalg.norm(signal, axis=0))


def _sum_errors(
    case: Case, full_order: Signals, paper: Signals, consistent: Signals
) -> dict[str, float]:
    """Largest difference of the summed force over its peak, the worse contact."""
    exact = case.force_sum(full_order)
    peak = np.abs(exact).max(axis=0)
    return {
        name: float((np.abs(case.force_sum(signals) - exact).max(axis=0) / peak).max())
        for name, signals in (("paper", paper), ("consistent", consistent))
    }
