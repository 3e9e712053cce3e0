"""Pictures at the width of a page: one style, a title that states the result."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipmode.rom.extras import extra
from slipmode.rom.storage.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH = 7.3  # [inch], 700 pixels of a page: text keeps its size there
_STYLE: Any = {
    "font.size": 10.0,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
}


def check_pictures() -> None:
    """Refuse before the computation if slipmode[pictures] is missing."""
    extra("matplotlib", "pictures")


@contextmanager
def page_figure(path: Path, title: str, height: float) -> Iterator[Figure]:
    """Make a figure of a height [inch] with a title, and write it when the context ends."""
    mpl, figures = extra("matplotlib", "pictures"), extra("matplotlib.figure", "pictures")
    with mpl.rc_context(_STYLE):
        figure = figures.Figure(figsize=(_WIDTH, height), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.0, wrap=True)
        yield figure
        with replacing(path) as file:
            figure.savefig(file, dpi=160, format="png")


def write_beside(
    ax: Axes, place: tuple[float, float], text: str, color: str = "black", *, above: bool = False
) -> None:
    """Write a label to the right of a point of a curve, or above it, in its colour."""
    ax.annotate(
        text,
        place,
        xytext=(0, 3) if above else (5, 0),
        textcoords="offset points",
        color=color,
        ha="center" if above else "left",
        va="bottom" if above else "center",
        fontsize=9.0,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
        zorder=1.5,  # over the grid, under the curves
        annotation_clip=False,
    )
