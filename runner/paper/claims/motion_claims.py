"""Claims on modes, contact motion and forces: Secs. 2 and 3, Figs. 4 to 9."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.contact.friction_terms import friction_functions as converged_functions
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.runner.paper import upwind
from slipmode.runner.paper.case import ALPHA, BETA, Case, Signals
from slipmode.runner.paper.claims.claim import Claim, judge
from slipmode.runner.paper.study import PERIODS, Study

USED = f"alpha {ALPHA:g}, beta {BETA:g}"
AGREEMENT = 0.1  # largest difference relative to the peak that passes as agreement
_TWO_PERIOD_POINTS = ((1.3, 1.5), (2.5, 0.3), (0.9, 0.36))  # |A|, |B|
_TWO_PERIOD_STEPS = 100
_TWO_PERIOD_BOUND = 0.05


def fixed_interface_modes(study: Study) -> Claim:
    """Natural frequencies and mode shapes with bonded contacts."""
    reduced = study.case.paper.reduced
    off = float(np.abs(reduced.mode_shapes[:2] - np.eye(2)).max())
    omega_A, omega_B = (float(omega) for omega in reduced.frequency)
    return Claim(
        name="bonded modes",
        where="Sec. 3",
        stated="natural frequencies 1 and 1.7, mode shapes (1, 0) and (0, 1)",
        ours={"omega_A": omega_A, "omega_B": omega_B, "shapes off by": off},
        verdict=judge(bool(np.allclose([omega_A, omega_B], [1, 1.7]) and off < 1e-9)),
        note="follows from Table 1",
    )


def contact_inertia(study: Study) -> Claim:
    """How the steady amplitudes change with a tenth of the contact mass."""
    heavy, light = (
        replace(study.case, contact_mass=mass).steady_by_full_order() for mass in (0.01, 0.001)
    )
    change = np.abs(light - heavy) / np.abs(heavy)
    return Claim(
        name="contact inertia",
        where="Sec. 2.2",
        stated="the inertia of the contacts is negligible",
        ours={"change of A": float(change[0]), "change of B": float(change[1])},
        verdict=judge(bool(change.max() < 0.01)),
        note=f"{USED}; steady amplitudes at full order, m_c 0.01 against 0.001; bound 1 %",
    )


def small_contact_motion(study: Study) -> Claim:
    """Largest contact motion against the modal displacement next to it."""
    ratio = np.abs(study.both.contact).max(axis=0) / np.abs(study.both.elastic).max(axis=0)
    return Claim(
        name="small contact motion",
        where="Sec. 3",
        stated="contact motion is much smaller than the modal displacements",
        ours={"x_c1 / x_e1": float(ratio[0]), "x_c2 / x_e2": float(ratio[1])},
        verdict=judge(bool(ratio.max() < 0.1)),
        note=f"{USED}; peaks; bound 10 %",
    )


def two_periods(study: Study) -> Claim:
    """Scheme (31) run over two periods against the converged friction functions."""
    reduced, ours = study.case.paper.reduced, {}
    for alpha in (ALPHA, 0.005):
        law = replace(study.case.law, alpha=alpha)
        exact = converged_functions(reduced, law, _TWO_PERIOD_POINTS, Discretisation(1024, 64))
        found = upwind.friction_functions(reduced, law, _TWO_PERIOD_POINTS, _TWO_PERIOD_STEPS)
        error = (np.abs(found - exact) / np.abs(exact)).max(axis=1)
        for (A, B), worst in zip(_TWO_PERIOD_POINTS, error, strict=True):
            ours[f"at ({A:g}, {B:g}), alpha {alpha:g}"] = float(worst)
    return Claim(
        name="two periods",
        where="Sec. 2.2",
        stated="two periods suffice for a periodic contact motion",
        ours=ours,
        verdict=judge(max(ours.values()) < _TWO_PERIOD_BOUND),
        note="error of Q by scheme (31), 100 steps a period, against the converged Q; bound 5 %; "
        "near the threshold finer steps do not help, more periods do",
    )


def straight_trajectories(study: Study) -> Claim:
    """Width of the contact trajectories relative to their length."""
    ours = {
        "A alone": _width(study.alone_a),
        "B alone": _width(study.alone_b),
        "both": _width(study.both),
    }
    straight = max(ours["A alone"], ours["B alone"]) < 0.1
    return Claim(
        name="straight trajectories",
        where="Fig. 4",
        stated="contact trajectories are straight lines with one mode, not with two",
        ours=ours,
        verdict=judge(straight and ours["both"] > 0.3),
        note=f"{USED}; width over length, singular values; bounds 0.1 and 0.3",
    )


def rectangle(study: Study) -> Claim:
    """The friction loop with mode A alone."""
    loop = _Loop.of(study.alone_a)
    return Claim(
        name="rectangle",
        where="Fig. 5",
        stated="with one mode the friction cycle is a stable rectangle, its loss constant",
        ours={"energy spread": loop.energy_spread, "area / bounding box": loop.filling},
        verdict=judge(loop.energy_spread < 0.01 and loop.filling > 0.9),
        note=f"{USED}; {PERIODS - 1} periods of A; bounds 1 % and 0.9",
    )


def drifting_loop(study: Study) -> Claim:
    """The friction loop with both modes."""
    loop = _Loop.of(study.both)
    return Claim(
        name="drifting loop",
        where="Fig. 5",
        stated="with two modes the friction cycle keeps changing shape and place",
        ours={"energy spread": loop.energy_spread, "centre drift / width": loop.centre_drift},
        verdict=judge(loop.energy_spread > 0.05 and loop.centre_drift > 0.05),
        note=f"{USED}; {PERIODS - 1} periods of A; bounds 5 %",
    )


def sinusoidal_sum(study: Study) -> Claim:
    """Part of the summed contact force at full order that is not at the two carriers."""
    case, full_order = study.case, study.both
    elastic = full_order.contact @ case.contact_stiffness
    of_sum, of_elastic, of_friction = (
        float(_distortion(full_order.time, signal, case.frequency).max())
        for signal in (case.force_sum(full_order), elastic, full_order.friction)
    )
    return Claim(
        name="sinusoidal sum",
        where="Fig. 7",
        stated="elastic and friction force add up to a nearly sinusoidal one",
        ours={"sum": of_sum, "elastic": of_elastic, "friction": of_friction},
        verdict=judge(of_sum < 0.05 < of_friction),
        note=f"{USED}; RMS beside the carriers over RMS, full order, worse contact; bound 5 %",
    )


def forces_agree(study: Study) -> Claim:
    """Summed contact forces of the reduced models against full order."""
    ours = _sum_errors(study.case, study.both, study.paper, study.consistent)
    return Claim(
        name="forces agree",
        where="Fig. 7",
        stated="the contact forces agree with time integration, but for the peaks",
        ours=ours,
        verdict=judge(ours["paper"] < AGREEMENT),
        note=f"{USED}; largest difference over peak, worse contact; bound 10 %",
    )


def errors_grow(study: Study) -> Claim:
    """The same under the forces 0.5 and 0.75."""
    usual = _sum_errors(study.case, study.both, study.paper, study.consistent)
    ours = _sum_errors(
        study.strong, study.both_strong, study.paper_strong, study.consistent_strong
    )
    return Claim(
        name="errors grow",
        where="Fig. 8",
        stated="with forces 0.5, 0.75 the errors grow but stay as expected of the method",
        ours=ours,
        verdict=judge(usual["paper"] < ours["paper"] < 2 * AGREEMENT),
        note=f"{USED}; largest difference over peak, worse contact; bound 20 %",
    )


def contacts_agree(study: Study) -> Claim:
    """Contact displacements of the reduced models against full order."""
    ours = {
        "paper": _relative_rms(study.paper.contact, study.both.contact),
        "consistent": _relative_rms(study.consistent.contact, study.both.contact),
    }
    return Claim(
        name="contacts agree",
        where="Fig. 9",
        stated="contact displacements agree with time integration",
        ours=ours,
        verdict=judge(ours["paper"] < AGREEMENT),
        note=f"{USED}; relative RMS, worse contact; bound 10 %",
    )


def _width(signals: Signals) -> float:
    """Second over first singular value of the trajectory (x_c1, x_c2)."""
    centred = signals.contact - signals.contact.mean(axis=0)
    first, second = np.linalg.svd(centred, compute_uv=False)
    return float(second / first)


class _Loop:
    """Friction loops of the first contact, period by period of mode A."""

    def __init__(self, x: Floats, force: Floats) -> None:
        energy = np.sum(0.5 * (force[:, 1:] + force[:, :-1]) * np.diff(x, axis=1), axis=1)
        width, centre = np.ptp(x, axis=1), 0.5 * (x.max(axis=1) + x.min(axis=1))
        self.energy_spread = float(np.ptp(energy) / energy.mean())
        self.filling = float(np.mean(energy / (width * np.ptp(force, axis=1))))
        self.centre_drift = float(np.ptp(centre) / width.mean())

    @classmethod
    def of(cls, signals: Signals) -> _Loop:
        """Whole periods, each with its first sample repeated at its end."""
        count = signals.time.size // PERIODS
        rows = count * np.arange(PERIODS - 1)[:, np.newaxis] + np.arange(count + 1)
        return cls(signals.contact[rows, 0], signals.friction[rows, 0])


def _distortion(time: Floats, signal: Floats, frequency: Floats) -> Floats:
    """RMS of what the carriers leave over RMS, per column."""
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


def _relative_rms(signal: Floats, reference: Floats) -> float:
    difference = np.linalg.norm(signal - reference, axis=0)
    return float((difference / np.linalg.norm(reference, axis=0)).max())
