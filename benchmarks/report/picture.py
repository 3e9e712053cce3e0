"""The picture of the report: error against time, one panel per task, one colour per method."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.report.sections import Section, by_method
from slipmode.rom.extras import extra

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Colours by the beginning of a method's name, markers by its end; else black, and circles.
_COLOURS = {
    "slipmode": "#c1272d",
    "paper formulation": "#e69f00",
    "full order": "#1b4f8f",
    "Craig-Bampton": "#56b4e9",
    "LSODA": "#6a3d9a",
    "CVODE": "#009e73",
    "harmonic balance": "#cc5599",
    "scheme (31)": "#e69f00",
}
_MARKERS = {"surface": "s", "motion": "D", "sums": "^", "continued": "^", "both axes": "^"}
_MARKERS |= {"2 modes": "v", "4 modes": "s", "8 modes": "^"}
_STYLE: Any = {
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "legend.fontsize": 7.5,
}


def draw(sections: Sequence[Section], folder: Path) -> Path:
    """Write speed-error.png into a folder and return its path."""
    mpl = extra("matplotlib", "pictures")
    from matplotlib.figure import Figure

    columns = min(len(sections), 3 if len(sections) > 4 else 2)
    rows = -(-len(sections) // columns)
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(4.6 * columns, 3.3 * rows + 1.0), layout="constrained")
        figure.suptitle("Error against time: the lower left is the better", fontsize=11)
        panels = list(figure.subplots(rows, columns, squeeze=False).ravel())
        for panel, section in zip(panels, sections, strict=False):
            _panel(panel, section)
        for panel in panels[len(sections) :]:
            panel.set_axis_off()
        handles = {  # a method looks the same in each panel: one legend
            label: handle
            for panel in panels
            for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
        }
        names = sorted(handles)
        figure.legend(
            [handles[name] for name in names], names, loc="outside lower center", ncols=2 * columns
        )
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "speed-error.png"
        figure.savefig(path, dpi=170)
    return path


def _panel(axes: Axes, section: Section) -> None:
    for method, rows in by_method(section.rows).items():
        colour = next((c for name, c in _COLOURS.items() if method.startswith(name)), "black")
        marker = next((m for name, m in _MARKERS.items() if method.endswith(name)), "o")
        # settings of our methods are tables and flows, no sequence for a line
        joined = not any(row.setting.startswith("table") for row in rows)
        axes.plot(
            [row.seconds for row in rows],
            [row.error for row in rows],
            marker,
            color=colour,
            markersize=5,
            markerfacecolor=colour if marker == "o" else "white",
            linestyle="-" if joined else "none",
            linewidth=0.9,
            label=method,
        )
    axes.set(xscale="log", yscale="log", title=section.title)
    axes.set(xlabel=f"time per {section.run} [s]", ylabel=f"relative error, {section.errors[0]}")
    axes.xaxis.set_minor_formatter("")
    axes.grid(which="major", linewidth=0.4, color="#dddddd")
    axes.set_axisbelow(True)
