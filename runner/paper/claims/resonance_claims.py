"""Claims on the resonance curves, Figs. 12 and 13, judged over alpha and beta."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Flags, Floats
from slipmode.runner.paper.case import ALPHA, BETA
from slipmode.runner.paper.claims.claim import Claim, judge_over
from slipmode.runner.paper.slices import ALPHAS, BETAS, euclidean, peak
from slipmode.runner.paper.study import Study

_TRIED = (
    f"alpha {ALPHA:g}, beta {BETA:g}; tried alpha {ALPHAS[0]:g} to {ALPHAS[-1]:g}, "
    f"beta {BETAS[0]:g} to {BETAS[-1]:g}"
)


def is_peak_a(height: Floats) -> Flags:
    """About 2.5."""
    return np.abs(height - 2.5) <= 0.05


def is_detuning_b(detuning: Floats) -> Flags:
    """-0.046, to the digits printed."""
    return np.abs(detuning + 0.046) <= 0.0005


def is_superposition(height: Floats) -> Flags:
    """Almost 4."""
    return (height >= 3.85) & (height <= 4.0)


def peak_of_mode_a(study: Study) -> Claim:
    """Peak of mode A alone."""
    heights = study.sensitivity.of(lambda s: s.peak_a)
    detuning, height = peak(study.slices.alone_a)
    return Claim(
        name="peak of A",
        where="Fig. 13a",
        stated="mode A alone peaks at about 2.5",
        ours={"peak": height, "at": detuning, **_range(heights)},
        verdict=judge_over(is_peak_a(heights)),
        note=f"{_TRIED}; about: within 0.05",
    )


def detuning_of_mode_b(study: Study) -> Claim:
    """Detuning at which mode B alone peaks."""
    detunings = study.sensitivity.of(lambda s: s.detuning_b)
    detuning, height = peak(study.slices.alone_b)
    return Claim(
        name="detuning of B",
        where="Fig. 13",
        stated="mode B alone peaks at detuning -0.046",
        ours={"detuning": detuning, "peak": height, **_range(detunings)},
        verdict=judge_over(is_detuning_b(detunings)),
        note=f"{_TRIED}; within 0.0005",
    )


def superposition(study: Study) -> Claim:
    """Sum of the peaks of A alone and B alone."""
    heights = study.sensitivity.of(lambda s: s.summed_peaks)
    return Claim(
        name="superposition",
        where="Fig. 13a",
        stated="the peaks of A alone and B alone add up to almost 4",
        ours={"sum": study.slices.summed_peaks, **_range(heights)},
        verdict=judge_over(is_superposition(heights)),
        note=f"{_TRIED}; almost: 3.85 to 4",
    )


def three_numbers(study: Study) -> Claim:
    """Whether any alpha, beta gives the three numbers at once."""
    found = study.sensitivity
    peaks, sums = found.of(lambda s: s.peak_a), found.of(lambda s: s.summed_peaks)
    detunings = found.of(lambda s: s.detuning_b)
    met = np.stack((is_peak_a(peaks), is_detuning_b(detunings), is_superposition(sums)))
    return Claim(
        name="three numbers at once",
        where="Fig. 13",
        stated="2.5, -0.046 and almost 4 belong to one system",
        ours={
            "most that one pair meets": float(met.sum(axis=0).max()),
            **_range(_where_peak_is(2.5, peaks, sums), "sum where the peak is 2.5, "),
        },
        verdict=judge_over(met.all(axis=0)),
        note=f"{_TRIED}; where the peak is 2.5 the sum is 3.5 whatever alpha",
    )


def peak_of_both(study: Study) -> Claim:
    """Peak with both modes at resonance over that of A alone."""
    gains = study.sensitivity.of(lambda s: s.peak_gain)
    return Claim(
        name="peak of both",
        where="Fig. 13a",
        stated="with both modes near resonance the peak is similar to that of A alone",
        ours={
            "peak": peak(study.slices.both_a)[1],
            "gain": study.slices.peak_gain,
            **_range(gains),
        },
        verdict=judge_over(np.abs(gains) < 0.15),
        note=f"{_TRIED}; Euclidean norm; similar: within 15 %",
    )


def lower_than_alone(study: Study) -> Claim:
    """Whether mode B lowers the peak."""
    gains, slices = study.sensitivity.of(lambda s: s.peak_gain), study.slices
    modulus = float(slices.both_a[:, 0].max() / slices.alone_a[:, 0].max()) - 1
    return Claim(
        name="lower than A alone",
        where="Fig. 12",
        stated="the peak along the first detuning is lower with both modes than with A alone",
        ours={"gain of norm": slices.peak_gain, "gain of |A|": modulus, **_range(gains)},
        verdict=judge_over(gains < 0),
        note=f"{_TRIED}; |A| does fall, but not by enough to make up for |B|",
    )


def tends_to_mode_b(study: Study) -> Claim:
    """The curve with both modes, far from the resonance of A."""

    def ratio(both_a: Floats, alone_b: Floats) -> float:
        return float(euclidean(both_a[-1])) / peak(alone_b)[1]

    ratios = study.sensitivity.of(lambda s: ratio(s.both_a, s.alone_b))
    return Claim(
        name="tends to B",
        where="Fig. 13a",
        stated="away from the resonance of A the curve tends to the peak of B",
        ours={
            "at detuning 0.2": float(euclidean(study.slices.both_a[-1])),
            "over peak of B": ratio(study.slices.both_a, study.slices.alone_b),
        },
        verdict=judge_over(np.abs(ratios - 1) < 0.02),
        note=f"{_TRIED}; bound 2 %",
    )


def superposition_as_plotted(study: Study) -> Claim:
    """The Euclidean norm with both modes against the sum of two norms."""
    both, summed = peak(study.slices.both_a)[1], study.slices.summed_peaks
    excess = study.sensitivity.of(lambda s: s.summed_peaks / peak(s.both_a)[1] - 1)
    return Claim(
        name="superposition as plotted",
        where="Fig. 13a",
        stated="linear superposition significantly overestimates the response",
        ours={"both": both, "superposition": summed, "excess": summed / both - 1},
        verdict=judge_over(excess > 0.1),
        note=f"{_TRIED}; compares sqrt(|A|^2+|B|^2) with a sum of two such norms; bound 10 %",
    )


def superposition_in_one_norm(study: Study) -> Claim:
    """The same comparison with one norm on both sides."""
    summed, euclid = study.slices.excess_of_norms
    excess = study.sensitivity.of(lambda s: max(s.excess_of_norms))
    return Claim(
        name="superposition in one norm",
        where="Sec. 4",
        stated="it is the added friction that makes superposition overestimate",
        ours={
            "excess of |A|+|B|": summed,
            "excess of sqrt(|A|^2+|B|^2)": euclid,
            **_range(excess),
        },
        verdict=judge_over(excess > 0.1),
        note=f"{_TRIED}; one norm on both sides, bound 10 %: the gap is that of the two norms",
    )


def dip_at_mode_b(study: Study) -> Claim:
    """The curve over the second detuning: at the peak of B against nearby."""
    rises, slices = study.sensitivity.of(lambda s: s.rise_at_b), study.slices
    return Claim(
        name="dip at B",
        where="Fig. 13b",
        stated="with both modes the amplitude at the resonance of B is smaller than nearby",
        ours={"rise": slices.rise_at_b, **_range(rises)},
        verdict=judge_over(rises <= 0),
        note=f"{_TRIED}; over the least norm within 0.1: there is a peak, and a dip to its sides",
    )


def _range(over_grid: Floats, what: str = "") -> dict[str, float]:
    return {f"{what}lowest": float(over_grid.min()), f"{what}highest": float(over_grid.max())}


def _where_peak_is(height: float, peaks: Floats, values: Floats) -> Floats:
    """Values (alphas,) at the damping that gives the peak; both fall with damping."""
    rows = zip(peaks[:, ::-1], values[:, ::-1], strict=True)
    return np.array([np.interp(height, row, value) for row, value in rows])
