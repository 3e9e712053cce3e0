"""One style for all figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from benchmarks.paper.study import Study

MODE_A, MODE_B, BOTH = "#1f5fa8", "#2b8a3e", "#c92a2a"
PAPER, CONSISTENT, FULL_ORDER = "#e8590c", "#6741d9", "#111111"
GREY = "#868e96"
SEQUENCE = ("#1f5fa8", "#3c9d9b", "#e0a100", "#c92a2a")  # of rising amplitude or alpha

Style = dict[str, Any]

_RC: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.linewidth": 0.7,
    "grid.color": "#e9ecef",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "savefig.dpi": 200,
}


def draw(
    figures: Iterable[Callable[[Study], Figure]], study: Study, folder: Path
) -> Iterator[Path]:
    """Write every figure as a PNG picture; yield the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(_RC):
        for figure in figures:
            path = folder / f"{figure.__name__}.png"
            figure(study).savefig(path)
            yield path


def panels(rows: int, columns: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """Return a figure [inch] of plane panels, row by row."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, list(np.ravel(figure.subplots(rows, columns, squeeze=False)))


def spaces(rows: int, columns: int, width: float, height: float) -> tuple[Figure, list[Axes3D]]:
    """Return a figure [inch] of panels in space, row by row."""
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = [
        figure.add_subplot(rows, columns, k + 1, projection="3d", computed_zorder=False)
        for k in range(rows * columns)
    ]
    for ax in axes:
        ax.set_box_aspect((1, 1, 0.7), zoom=0.92)
        for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
            axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
    return figure, axes


def label(ax: Axes, x: str, y: str, title: str = "") -> None:
    """Set axis labels with units, and a title."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.set_title(title)


def legend_above(figure: Figure, ax: Axes, columns: int) -> None:
    """Draw one legend for all panels, from the lines of one of them."""
    handles, names = ax.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=columns)
