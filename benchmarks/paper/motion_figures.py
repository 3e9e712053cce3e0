"""Figures in time: motion from rest, trajectories, friction cycles, forces (Figs. 3 to 9)."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import RegularGridInterpolator

from benchmarks.paper.case import Case, Signals
from benchmarks.paper.study import TORUS_AMPLITUDES, TORUS_ANGLES, Study
from benchmarks.paper.style import (
    BOTH,
    CONSISTENT,
    FULL_ORDER,
    GREY,
    MODE_A,
    MODE_B,
    PAPER,
    Style,
    label,
    legend_above,
    panels,
    spaces,
)
from slipmode.rom.arrays import Floats

_CENTRE_RADIUS, _TUBE_RADIUS, _SWELLING = 2.0, 0.75, 0.3  # of the torus, swollen by x_c1
_SHOWN_PERIODS = 5
_TURNS = 7  # of the motion around the torus
_DASHED: Style = {"color": FULL_ORDER, "ls": (0, (4, 3)), "lw": 1.0}


def figure_03(study: Study) -> Figure:
    """Draw displacement of x_e1 from rest; friction force and contact motion over five periods."""
    figure, (slow, force, first, second) = panels(2, 2, 7.2, 4.6)
    rest, (time, amplitudes) = study.from_rest, study.envelope
    slow.plot(rest.time, rest.elastic[:, 0], color=BOTH, lw=0.3)
    for sign in (-2, 2):
        slow.plot(time, sign * amplitudes[:, 0], color=FULL_ORDER, lw=1.2)
    slow.plot([], [], color=FULL_ORDER, label=r"$\pm 2|A|$, slow flow")
    slow.margins(x=0, y=0.28)
    slow.legend(loc="upper right")
    label(slow, r"$t$ [s]", r"$x_{e1}$ [m]", "(a) modal displacement, both modes")
    for ax, quantity, contact, alone, color, name in (
        (force, "friction", 0, study.alone_a, MODE_A, "only mode A"),
        (first, "contact", 0, study.alone_a, MODE_A, "only mode A"),
        (second, "contact", 1, study.alone_b, MODE_B, "only mode B"),
    ):
        for signals, shade, legend in ((alone, color, name), (study.both, BOTH, "both modes")):
            shown = _last_periods(signals, study.case)
            ax.plot(_elapsed(shown), getattr(shown, quantity)[:, contact], shade, label=legend)
    label(force, r"$t - t_0$ [s]", r"$g_1$ [N]", "(b) friction force, first contact")
    label(first, r"$t - t_0$ [s]", r"$x_{c1}$ [m]", "(c) first contact")
    label(second, r"$t - t_0$ [s]", r"$x_{c2}$ [m]", "(d) second contact")
    for ax in (force, first, second):
        ax.margins(x=0, y=0.28)
        ax.legend(loc="upper right", ncols=2)
    return figure


def figure_04(study: Study) -> Figure:
    """Draw the trajectories of the contacts."""
    figure, (ax,) = panels(1, 1, 4.6, 3.2)
    for signals, color, name in (
        (study.both, BOTH, "both modes"),
        (study.alone_a, MODE_A, "only mode A"),
        (study.alone_b, MODE_B, "only mode B"),
    ):
        ax.plot(*signals.contact.T, color=color, label=name, lw=1.0 if color == BOTH else 2.0)
    ax.set_aspect("equal")
    label(ax, r"$x_{c1}$ [m]", r"$x_{c2}$ [m]")
    legend_above(figure, ax, 3)
    return figure


def figure_05(study: Study) -> Figure:
    """Draw friction cycles of the first contact."""
    figure, (ax,) = panels(1, 1, 4.4, 3.4)
    for signals, color, name in (
        (study.both, BOTH, "both modes"),
        (study.alone_a, MODE_A, "only mode A"),
    ):
        shown = _last_periods(signals, study.case)
        ax.plot(shown.contact[:, 0], shown.friction[:, 0], color=color, label=name)
    label(ax, r"$x_{c1}$ [m]", r"$g_1$ [N]")
    legend_above(figure, ax, 2)
    return figure


def figure_06(study: Study) -> Figure:
    """Draw periodic motion of the first contact in both phases: a surface, and on a torus."""
    figure, (plain, wrapped) = spaces(1, 2, 7.6, 3.4)
    x = study.torus
    t_A, t_B = np.meshgrid(TORUS_ANGLES, TORUS_ANGLES, indexing="ij")
    style: Style = {"rcount": 97, "ccount": 97, "linewidth": 0, "antialiased": False}
    plain.plot_surface(t_A, t_B, x, cmap="viridis", **style)
    ticks = np.pi * np.arange(3)
    names = ("0", r"$\pi$", r"$2\pi$")
    plain.set_xticks(ticks, names)
    plain.set_yticks(ticks, names)
    plain.set_zlabel(r"$x_{c1}$ [m]", labelpad=8)
    label(plain, r"$t_A$ [rad]", r"$t_B$ [rad]", "(a) over the two phases")
    (A, B), relative = TORUS_AMPLITUDES, x / np.abs(x).max()
    style |= {"facecolors": colormaps["viridis"](0.5 + 0.5 * relative), "shade": False}
    wrapped.plot_surface(*_torus_points(t_A, t_B, relative), **style)
    wrapped.plot(*_visible_trajectory(relative, wrapped.elev, wrapped.azim), "k", lw=0.9)
    wrapped.set_box_aspect((1, 1, 0.4), zoom=1.35)
    wrapped.set_axis_off()
    wrapped.set_title("(b) on a torus, the motion in black")
    figure.suptitle(f"$|A|$ = {A}, $|B|$ = {B}", fontsize=9)
    return figure


def figure_07(study: Study) -> Figure:
    """Draw forces on the first contact, the reduced models against full order."""
    return _forces(study.case, study.both, study.paper, study.consistent)


def figure_08(study: Study) -> Figure:
    """Draw forces on the first contact under the larger excitation."""
    strong = study.strong
    return _forces(strong, study.both_strong, study.paper_strong, study.consistent_strong)


def figure_09(study: Study) -> Figure:
    """Draw contact displacements, the reduced models against full order."""
    figure, axes = panels(2, 1, 7.2, 4.4)
    lines: tuple[tuple[Signals, Style, str], ...] = (
        (study.paper, {"color": PAPER}, "paper's model"),
        (study.consistent, {"color": CONSISTENT}, "consistent model"),
        (study.both, _DASHED, "full order"),
    )
    for contact, ax in enumerate(axes):
        for signals, style, name in lines:
            shown = _last_periods(signals, study.case)
            ax.plot(_elapsed(shown), shown.contact[:, contact], label=name, **style)
        ax.margins(x=0)
        title = f"({'ab'[contact]}) contact {contact + 1}"
        label(ax, r"$t - t_0$ [s]", rf"$x_{{c{contact + 1}}}$ [m]", title)
    legend_above(figure, axes[0], 3)
    return figure


def _torus_points(t_A: Floats, t_B: Floats, swelling: Floats) -> tuple[Floats, Floats, Floats]:
    """Points of two phases on a torus whose tube is swollen by -1 to 1."""
    tube = _TUBE_RADIUS + _SWELLING * swelling
    distance = _CENTRE_RADIUS + tube * np.cos(t_B)
    return distance * np.cos(t_A), distance * np.sin(t_A), tube * np.sin(t_B)


def _visible_trajectory(swelling: Floats, elevation: float, azimuth: float) -> Floats:
    """The motion on the torus (3, n), NaN where the tube faces away from the eye."""
    t_A = np.linspace(0.0, 2 * np.pi * _TURNS, 400 * _TURNS)
    t_B = 1.7 * t_A
    look_up = RegularGridInterpolator((TORUS_ANGLES, TORUS_ANGLES), swelling)
    swollen = look_up(np.column_stack((t_A, t_B)) % (2 * np.pi))
    e, a = np.radians([elevation, azimuth])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    normal = np.array([np.cos(t_B) * np.cos(t_A), np.cos(t_B) * np.sin(t_A), np.sin(t_B)])
    points = np.array(_torus_points(t_A, t_B, swollen))
    return np.asarray(np.where(eye @ normal > 0.05, points, np.nan))


def _forces(case: Case, full_order: Signals, paper: Signals, consistent: Signals) -> Figure:
    figure, axes = panels(1, 2, 7.2, 3.2)
    for ax, signals, name in (
        (axes[0], paper, "(a) the paper's model"),
        (axes[1], consistent, "(b) consistent model"),
    ):
        _force_terms(ax, case, _last_periods(signals, case, 2), {"lw": 1.8})
        _force_terms(ax, case, _last_periods(full_order, case, 2), _DASHED)
        label(ax, r"$t - t_0$ [s]", "force on contact 1 [N]", name)
        ax.margins(x=0)
    handles = [line for line in axes[0].lines if line.get_linestyle() == "-"][:3]
    handles.append(axes[0].lines[-1])
    names = ("elastic", "friction", "sum", "full order")
    figure.legend(handles, names, loc="outside upper center", ncols=4)
    return figure


def _force_terms(ax: Axes, case: Case, signals: Signals, style: Style) -> None:
    """Elastic force, friction force and their sum on the first contact."""
    elastic = signals.contact @ case.contact_stiffness
    terms = (elastic, signals.friction, case.force_sum(signals))
    for term, color in zip(terms, (CONSISTENT, GREY, PAPER), strict=True):
        ax.plot(_elapsed(signals), term[:, 0], **{"color": color, **style})


def _last_periods(signals: Signals, case: Case, periods: int = _SHOWN_PERIODS) -> Signals:
    shown = signals.time >= signals.time[-1] - periods * case.period
    s = signals
    return Signals(s.time[shown], s.elastic[shown], s.contact[shown], s.friction[shown])


def _elapsed(signals: Signals) -> Floats:
    return np.asarray(signals.time - signals.time[0])


FIGURES = (figure_03, figure_04, figure_05, figure_06, figure_07, figure_08, figure_09)
