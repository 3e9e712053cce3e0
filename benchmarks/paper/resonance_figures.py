"""Friction functions, resonance surface and curves (Figs. 10 to 13), and alpha and beta."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from benchmarks.paper.friction_claims import LARGEST, THRESHOLDS, friction_at
from benchmarks.paper.slices import ALPHAS, BETAS, DETUNINGS, Slices, euclidean, peak
from benchmarks.paper.study import FULL_ORDER_DETUNINGS, Study
from benchmarks.paper.style import (
    BOTH,
    FULL_ORDER,
    GREY,
    MODE_A,
    MODE_B,
    SEQUENCE,
    Style,
    label,
    legend_above,
    panels,
    spaces,
)
from slipmode.rom.arrays import Complexes, Floats

_NORM = r"$\sqrt{|A|^2+|B|^2}$ [m]"
_Q_PANELS = (
    (0, "real", r"Re $Q_A$ [s$^{-2}$]"),
    (0, "imag", r"Im $Q_A$ [s$^{-2}$]"),
    (1, "real", r"Re $Q_B$ [s$^{-2}$]"),
    (1, "imag", r"Im $Q_B$ [s$^{-2}$]"),
)
_STIFFNESS = ((1.0, 20.0), (1.7**2, 40.0))  # coupling of each mode and K_xx of its contact


def figure_10(study: Study) -> Figure:
    """Draw the complex friction functions over both amplitudes."""
    figure, axes = spaces(2, 2, 7.6, 6.4)
    moduli = np.linspace(0.02, LARGEST, 90)
    A, B = np.meshgrid(moduli, moduli, indexing="ij")
    Q = friction_at(study.case.paper, A, B)
    for ax, (mode, part, name), letter in zip(axes, _Q_PANELS, "abcd", strict=True):
        values = getattr(Q[..., mode], part)
        ax.plot_surface(A, B, values, cmap="viridis", rcount=90, ccount=90, linewidth=0)
        ax.view_init(elev=26, azim=-128 if mode == 0 else -38)
        ax.zaxis.set_major_locator(MaxNLocator(4))
        ax.tick_params(axis="z", pad=7)
        ax.xaxis.set_major_locator(MultipleLocator(1.0))
        ax.yaxis.set_major_locator(MultipleLocator(1.0))
        label(ax, r"$|A|$ [m]", r"$|B|$ [m]", f"({letter}) {name}")
    return figure


def figure_11(study: Study) -> Figure:
    """Draw slices of the friction functions, with the closed form for one mode under Coulomb."""
    figure, axes = panels(2, 2, 7.2, 5.0)
    moduli = np.linspace(0.02, LARGEST, 300)
    for ax, (mode, part, name), letter in zip(axes, _Q_PANELS, "abcd", strict=True):
        own = "AB"[mode]
        for held, color in zip((1e-3, 0.5, 1.0, 2.0), SEQUENCE, strict=True):
            A, B = (moduli, held) if mode == 0 else (held, moduli)
            Q = friction_at(study.case.paper, A, B)[..., mode]
            ax.plot(moduli, getattr(Q, part), color=color, label=f"other mode {held:.1f}")
        exact = getattr(_coulomb_alone(mode, moduli), part)
        ax.plot(moduli, exact, color=GREY, ls=":", label="0, Coulomb")
        label(ax, rf"$|{own}|$ [m]", name, f"({letter})")
        ax.margins(x=0)
    legend_above(figure, axes[0], 5)
    return figure


def figure_12(study: Study) -> Figure:
    """Draw the resonance surface over both detunings, with the slices of Fig. 13."""
    figure, (ax,) = spaces(1, 1, 5.6, 4.2)
    surface, slices = study.surface, study.slices
    grid = np.meshgrid(surface.frequency_A - 1.0, surface.frequency_B - 1.7, indexing="ij")
    style: Style = {"rcount": 120, "ccount": 120, "linewidth": 0, "alpha": 0.75}
    ax.plot_surface(*grid, surface.euclidean, cmap="Greys", vmin=-1.5, vmax=5, **style)
    for (first, second), amplitudes, color, name in _slice_lines(slices):
        ax.plot(first, second, euclidean(amplitudes), color=color, lw=2, label=name)
    ax.view_init(elev=28, azim=-128)
    ax.set_box_aspect((1, 1, 0.7), zoom=1.05)
    ax.xaxis.set_major_locator(MultipleLocator(0.1))
    ax.yaxis.set_major_locator(MultipleLocator(0.1))
    ax.set_zlabel(_NORM)
    label(ax, r"$\Delta\omega_A$ [rad/s]", r"$\Delta\omega_B$ [rad/s]")
    legend_above(figure, ax, 4)
    return figure


def figure_13(study: Study) -> Figure:
    """Draw resonance curves: each mode alone, both, and their superposition in two norms."""
    figure, (over_a, over_b) = panels(1, 2, 7.6, 3.7)
    slices, consistent = study.slices, study.consistent_slices
    top_A, top_B = peak(slices.alone_a)[1], peak(slices.alone_b)[1]
    _curves(over_a, slices.alone_a, slices.both_a, top_B, MODE_A)
    _curves(over_b, slices.alone_b, slices.both_b, top_A, MODE_B)
    over_a.plot(DETUNINGS, euclidean(consistent.both_a), color=BOTH, ls="--", lw=1)
    over_b.plot(DETUNINGS, euclidean(consistent.both_b), color=BOTH, ls="--", lw=1)
    circles: Style = {"marker": "o", "ms": 4, "mfc": "white", "mec": FULL_ORDER, "ls": ""}
    for ax, exact in zip((over_a, over_b), study.both_by_full_order, strict=True):
        ax.plot(FULL_ORDER_DETUNINGS, euclidean(exact), **circles)
    label(over_a, r"$\Delta\omega_A$ [rad/s]", _NORM, "(a) across the resonance of A")
    label(over_b, r"$\Delta\omega_B$ [rad/s]", _NORM, "(b) across the resonance of B")
    lines = [over_a.lines[0], over_b.lines[0], *over_a.lines[1:]]
    names = ["A alone", "B alone", "both", "superposition as sum of norms"]
    names += ["superposition in the same norm", "both, consistent model", "both, full order"]
    figure.legend(lines, names, loc="outside upper center", ncols=3)
    return figure


def alpha_beta(study: Study) -> Figure:
    """Draw the paper's three numbers over alpha and beta, which it does not state."""
    figure, axes = panels(1, 3, 7.6, 3.0)
    found = study.sensitivity
    peaks, sums = found.of(lambda s: s.peak_a), found.of(lambda s: s.summed_peaks)
    detunings = found.of(lambda s: s.detuning_b)
    milli = 1e3 * np.array(BETAS)
    for row, (alpha, color) in enumerate(zip(ALPHAS, SEQUENCE, strict=True)):
        style: Style = {"color": color, "marker": "o", "ms": 3}
        style["label"] = rf"$\alpha$ = {alpha:g} m/s"
        for ax, values in zip(axes, (peaks, detunings), strict=False):
            ax.plot(milli, values[row], **style)
        axes[2].plot(peaks[row], sums[row], **style)
    for ax, band in ((axes[0], (2.45, 2.55)), (axes[1], (-0.0465, -0.0455)), (axes[2], (3.85, 4))):
        ax.axhspan(*band, color=GREY, alpha=0.3, lw=0, label="stated")
    axes[2].axvspan(2.45, 2.55, color=GREY, alpha=0.3, lw=0)
    label(axes[0], r"$\beta$ [ms]", "peak of A alone [m]", "(a)")
    label(axes[1], r"$\beta$ [ms]", "detuning of the peak of B [rad/s]", "(b)")
    label(axes[2], "peak of A alone [m]", "sum of both peaks [m]", "(c)")
    legend_above(figure, axes[0], 5)
    return figure


def _coulomb_alone(mode: int, moduli: Floats) -> Complexes:
    """Q of one mode alone under exact Coulomb friction, the other contact stuck."""
    k, K = _STIFFNESS[mode]
    r = np.minimum(THRESHOLDS[mode] / moduli, 1.0)
    spring = np.pi / 2 + np.arcsin(1 - 2 * r) + 2 * (1 - 2 * r) * np.sqrt(r * (1 - r))
    return np.asarray(k**2 / (np.pi * K) * (spring - 4j * r * (1 - r)))


def _slice_lines(
    slices: Slices,
) -> list[tuple[tuple[Floats, Floats], Floats, str, str]]:
    """Detunings of A and of B, amplitudes, colour and name of the slices of the surface."""
    a, b, line = peak(slices.alone_a)[0], peak(slices.alone_b)[0], DETUNINGS
    ones = np.ones_like(line)
    return [
        ((line, -0.2 * ones), slices.alone_a, MODE_A, "A alone"),
        ((0.2 * ones, line), slices.alone_b, MODE_B, "B alone"),
        ((line, b * ones), slices.both_a, BOTH, "both"),
        ((a * ones, line), slices.both_b, BOTH, "_"),
    ]


def _curves(ax: Axes, alone: Floats, both: Floats, other_peak: float, color: str) -> None:
    """One mode alone, both, and the other's peak added in two ways."""
    norm = euclidean(alone)
    ax.plot(DETUNINGS, norm, color=color)
    ax.plot(DETUNINGS, euclidean(both), color=BOTH)
    ax.plot(DETUNINGS, norm + other_peak, color=FULL_ORDER)
    ax.plot(DETUNINGS, np.hypot(norm, other_peak), color=FULL_ORDER, ls=":")
    ax.margins(x=0)
    ax.set_ylim(bottom=0)
    ax.xaxis.set_major_locator(MultipleLocator(0.1))


FIGURES = (figure_10, figure_11, figure_12, figure_13, alpha_beta)
