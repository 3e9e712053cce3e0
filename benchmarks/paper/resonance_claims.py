"""Claims on the resonance curves, Figs. 12 and 13, judged over alpha and beta."""

from __future__ import annotations

import numpy as np

from benchmarks.paper.case import ALPHA, BETA
from benchmarks.paper.claim import Claims, Found
from benchmarks.paper.slices import ALPHAS, BETAS, Slices, euclidean, peak
from benchmarks.paper.study import Study
from slipmode.rom.arrays import Flags, Floats

_TRIED = (
    f"alpha {ALPHA:g}, beta {BETA:g}; tried alpha {ALPHAS[0]:g} to {ALPHAS[-1]:g}, "
    f"beta {BETAS[0]:g} to {BETAS[-1]:g}"
)

CLAIMS = Claims()


def _is_peak_a(height: Floats) -> Flags:
    """About 2.5."""
    return np.asarray(np.abs(height - 2.5) <= 0.05)


def _is_detuning_b(detuning: Floats) -> Flags:
    """-0.046, to the digits printed."""
    return np.asarray(np.abs(detuning + 0.046) <= 0.0005)


def _is_superposition(height: Floats) -> Flags:
    """Almost 4."""
    return np.asarray((height >= 3.85) & (height <= 4.0))


def _range(over_grid: Floats, what: str = "") -> dict[str, float]:
    return {f"{what}lowest": over_grid.min(), f"{what}highest": over_grid.max()}


@CLAIMS.add("Fig. 13a", "mode A alone peaks at about 2.5", f"{_TRIED}; about: within 0.05")
def _peak_of_a(study: Study) -> Found:
    heights = study.sensitivity.of(lambda s: s.peak_a)
    detuning, height = peak(study.slices.alone_a)
    return {"peak": height, "at": detuning, **_range(heights)}, _is_peak_a(heights)


@CLAIMS.add("Fig. 13", "mode B alone peaks at detuning -0.046", f"{_TRIED}; within 0.0005")
def _detuning_of_b(study: Study) -> Found:
    detunings = study.sensitivity.of(lambda s: s.detuning_b)
    detuning, height = peak(study.slices.alone_b)
    ours = {"detuning": detuning, "peak": height, **_range(detunings)}
    return ours, _is_detuning_b(detunings)


@CLAIMS.add(
    "Fig. 13a",
    "the peaks of A alone and B alone add up to almost 4",
    f"{_TRIED}; almost: 3.85 to 4",
)
def _superposition(study: Study) -> Found:
    heights = study.sensitivity.of(lambda s: s.summed_peaks)
    return {"sum": study.slices.summed_peaks, **_range(heights)}, _is_superposition(heights)


@CLAIMS.add(
    "Fig. 13",
    "2.5, -0.046 and almost 4 belong to one system",
    f"{_TRIED}; where the peak is 2.5 the sum is 3.5 whatever alpha",
)
def _three_numbers(study: Study) -> Found:
    found = study.sensitivity
    peaks, sums = found.of(lambda s: s.peak_a), found.of(lambda s: s.summed_peaks)
    detunings = found.of(lambda s: s.detuning_b)
    met = np.stack((_is_peak_a(peaks), _is_detuning_b(detunings), _is_superposition(sums)))
    # sums at the damping that gives the peak; both fall with damping
    rows = zip(peaks[:, ::-1], sums[:, ::-1], strict=True)
    there = np.array([np.interp(2.5, row, values) for row, values in rows])
    ours = {
        "most that one pair meets": float(met.sum(axis=0).max()),
        **_range(there, "sum where the peak is 2.5, "),
    }
    return ours, met.all(axis=0)


@CLAIMS.add(
    "Fig. 13a",
    "with both modes near resonance the peak is similar to the peak of A alone",
    f"{_TRIED}; Euclidean norm; similar: within 15 %",
)
def _peak_of_both(study: Study) -> Found:
    gains, slices = study.sensitivity.of(lambda s: s.peak_gain), study.slices
    ours = {"peak": peak(slices.both_a)[1], "gain": slices.peak_gain, **_range(gains)}
    return ours, np.abs(gains) < 0.15


@CLAIMS.add(
    "Fig. 12",
    "the peak along the first detuning is lower with both modes than with A alone",
    f"{_TRIED}; |A| does fall, but not by enough to make up for |B|",
)
def _lower_than_alone(study: Study) -> Found:
    gains, slices = study.sensitivity.of(lambda s: s.peak_gain), study.slices
    modulus = slices.both_a[:, 0].max() / slices.alone_a[:, 0].max() - 1
    return {"gain of norm": slices.peak_gain, "gain of |A|": modulus, **_range(gains)}, gains < 0


@CLAIMS.add(
    "Fig. 13a",
    "away from the resonance of A the curve tends to the peak of B",
    f"{_TRIED}; bound 2 %",
)
def _tends_to_b(study: Study) -> Found:
    def ratio(slices: Slices) -> float:
        return float(euclidean(slices.both_a[-1])) / peak(slices.alone_b)[1]

    far = float(euclidean(study.slices.both_a[-1]))
    ours = {"at detuning 0.2": far, "over peak of B": ratio(study.slices)}
    return ours, np.abs(study.sensitivity.of(ratio) - 1) < 0.02


@CLAIMS.add(
    "Fig. 13a",
    "linear superposition significantly overestimates the response",
    f"{_TRIED}; compares sqrt(|A|^2+|B|^2) with a sum of two such norms; bound 10 %",
)
def _superposition_as_plotted(study: Study) -> Found:
    both, summed = peak(study.slices.both_a)[1], study.slices.summed_peaks
    excess = study.sensitivity.of(lambda s: s.summed_peaks / peak(s.both_a)[1] - 1)
    return {"both": both, "superposition": summed, "excess": summed / both - 1}, excess > 0.1


@CLAIMS.add(
    "Sec. 4",
    "it is the added friction that makes superposition overestimate",
    f"{_TRIED}; one norm on both sides, bound 10 %: the gap is a difference of norms",
)
def _superposition_in_one_norm(study: Study) -> Found:
    summed, euclid = study.slices.excess_of_norms
    excess = study.sensitivity.of(lambda s: max(s.excess_of_norms))
    ours = {"excess of |A|+|B|": summed, "excess of sqrt(|A|^2+|B|^2)": euclid}
    return ours | _range(excess), excess > 0.1


@CLAIMS.add(
    "Fig. 13b",
    "with both modes the amplitude at the resonance of B is smaller than nearby",
    f"{_TRIED}; over the least norm within 0.1: there is a peak, and a dip to its sides",
)
def _dip_at_b(study: Study) -> Found:
    rises = study.sensitivity.of(lambda s: s.rise_at_b)
    return {"rise": study.slices.rise_at_b, **_range(rises)}, rises <= 0
