"""The pictures: one function per figure of the paper, one file per figure."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from slipmode.runner.paper.figures import motion_figures, resonance_figures
from slipmode.runner.paper.figures.style import RC
from slipmode.runner.paper.study import Study

FIGURES: dict[str, Callable[[Study], Figure]] = {
    "figure_03": motion_figures.figure_3,
    "figure_04": motion_figures.figure_4,
    "figure_05": motion_figures.figure_5,
    "figure_06": motion_figures.figure_6,
    "figure_07": motion_figures.figure_7,
    "figure_08": motion_figures.figure_8,
    "figure_09": motion_figures.figure_9,
    "figure_10": resonance_figures.figure_10,
    "figure_11": resonance_figures.figure_11,
    "figure_12": resonance_figures.figure_12,
    "figure_13": resonance_figures.figure_13,
    "alpha_beta": resonance_figures.figure_unstated,
}


def draw(study: Study, folder: Path) -> list[Path]:
    """Write every figure as a PNG picture."""
    written = []
    with mpl.rc_context(RC):
        for name, figure in FIGURES.items():
            path = folder / f"{name}.png"
            figure(study).savefig(path)
            written.append(path)
    return written
