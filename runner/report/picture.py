"""The picture of the report: error against time, one panel per task, one colour per method."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from runner.report.measure import Row, Section

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HAS_MATPLOTLIB = find_spec("matplotlib") is not None
HOW_TO_GET_IT = "no picture: matplotlib is missing; pip install 'slipmode[report]'"

# method: (colour, marker); related methods share a colour
_STYLES = {
    "slipmode": ("#c1272d", "o"),
    "slipmode, window": ("#c1272d", "s"),
    "slipmode, motion": ("#c1272d", "D"),
    "paper formulation": ("#e69f00", "o"),
    "paper formulation, window": ("#e69f00", "s"),
    "paper formulation, motion": ("#e69f00", "D"),
    "full order": ("#1b4f8f", "o"),
    "Craig-Bampton, 2 modes": ("#56b4e9", "v"),
    "Craig-Bampton, 4 modes": ("#56b4e9", "s"),
    "Craig-Bampton, 8 modes": ("#56b4e9", "^"),
    "LSODA": ("#6a3d9a", "o"),
    "CVODE": ("#009e73", "o"),
    "BDF": ("#8c564b", "o"),
    "Radau": ("#777777", "o"),
    "harmonic balance": ("#009e73", "s"),
    "harmonic balance, continued": ("#009e73", "^"),
    "slipmode, surface": ("#c1272d", "s"),
    "paper formulation, surface": ("#e69f00", "s"),
    "scheme (31) from the corner": ("#e69f00", "o"),
    "scheme (31) from both axes": ("#e69f00", "^"),
}
_OTHER = ("#333333", "x")
_STYLE = {
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "svg.fonttype": "none",
}


def draw(sections: Sequence[Section], folder: Path, name: str = "speed-error") -> list[Path]:
    """Write <name>.png and <name>.svg."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    columns = 2 if len(sections) > 1 else 1
    rows = -(-len(sections) // columns)
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(5.2 * columns, 3.7 * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel, section in zip(panels, sections, strict=False):
            _panel(panel, section)
        for panel in panels[len(sections) :]:
            panel.set_axis_off()
        written = [folder / f"{name}.png", folder / f"{name}.svg"]
        for path in written:
            figure.savefig(path, dpi=170, metadata={"Date": None} if path.suffix == ".svg" else {})
    return written


def _panel(axes: Axes, section: Section) -> None:
    for series, rows in _series(section.rows).items():
        colour, marker = _STYLES.get(series, _OTHER)
        axes.plot(
            [row.seconds for row in rows],
            [row.error for row in rows],
            marker,
            color=colour,
            markersize=5,
            markerfacecolor=colour if marker == "o" else "white",
            linestyle="-",
            linewidth=0.9,
            label=series,
        )
    axes.set(xscale="log", yscale="log", title=section.title)
    axes.set_xlabel(_per_run(section))
    axes.set_ylabel(f"relative error, {section.errors[0]}")
    axes.grid(which="major", linewidth=0.4, color="#dddddd")
    axes.set_axisbelow(True)
    axes.margins(0.07)
    axes.legend(loc="best", handlelength=1.6, labelspacing=0.25)


def _per_run(section: Section) -> str:
    unit = {"steady": "state", "friction": "amplitude pair"}
    return f"time per {unit.get(section.key.split()[0], 'run')} [s]"


def _series(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows that one line joins, by increasing time."""
    series: dict[str, list[Row]] = {}
    for row in rows:
        series.setdefault(series_name(row), []).append(row)
    return {name: sorted(members, key=lambda row: row.seconds) for name, members in series.items()}


def series_name(row: Row) -> str:
    """The method, told apart where a state is one of many or continued from a neighbour."""
    for mark, suffix in (("continued", "continued"), ("each of", "surface")):
        if mark in row.setting:
            return f"{row.method}, {suffix}"
    return row.method
