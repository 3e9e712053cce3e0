"""The picture of the report: error against time, one panel per task, one colour per method."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipmode.runner.report.measure import Row, Section

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HAS_MATPLOTLIB = find_spec("matplotlib") is not None
HOW_TO_GET_IT = "no picture: matplotlib is missing; pip install 'slipmode[report]'"

# method: (colour, marker); related methods share a colour
_STYLES = {
    "slipmode": ("#c1272d", "o"),
    "slipmode, slow flow": ("#c1272d", "o"),
    "slipmode, one state": ("#c1272d", "o"),
    "slipmode, window": ("#c1272d", "s"),
    "slipmode, motion": ("#c1272d", "D"),
    "slipmode, sums": ("#c1272d", "^"),
    "paper formulation, slow flow": ("#e69f00", "o"),
    "paper formulation, one state": ("#e69f00", "o"),
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
    "harmonic balance": ("#cc5599", "s"),
    "harmonic balance, continued": ("#cc5599", "^"),
    "slipmode, surface": ("#c1272d", "s"),
    "paper formulation, surface": ("#e69f00", "s"),
    "scheme (31) from the corner": ("#e69f00", "o"),
    "scheme (31) from both axes": ("#e69f00", "^"),
}
_OTHER = ("#333333", "x")
_STYLE: Any = {
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
        _legend(figure, panels)
        written = [folder / f"{name}.png", folder / f"{name}.svg"]
        for path in written:
            figure.savefig(path, dpi=170, metadata={"Date": None} if path.suffix == ".svg" else {})
    return written


def _panel(axes: Axes, section: Section) -> None:
    from matplotlib.ticker import NullFormatter

    for series, rows in _series(section.rows).items():
        colour, marker = _STYLES.get(series, _OTHER)
        axes.plot(
            [row.seconds for row in rows],
            [row.error for row in rows],
            marker,
            color=colour,
            markersize=5,
            markerfacecolor=colour if marker == "o" else "white",
            linestyle="-" if _is_a_sequence(rows) else "none",
            linewidth=0.9,
            label=series,
        )
    axes.set(xscale="log", yscale="log", title=section.title)
    axes.set_xlabel(_per_run(section))
    axes.set_ylabel(f"relative error, {section.errors[0]}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(which="major", linewidth=0.4, color="#dddddd")
    axes.set_axisbelow(True)
    axes.margins(0.07)


def _legend(figure: Figure, panels: Sequence[Axes]) -> None:
    """One legend for all panels: a method looks the same in each."""
    handles = {
        label: handle
        for panel in panels
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    ordered = sorted(handles, key=[*_STYLES, *handles].index)
    figure.legend(
        [handles[label] for label in ordered], ordered, loc="outside lower center", ncols=5
    )


def _per_run(section: Section) -> str:
    unit = {"steady": "state", "friction": "amplitude pair"}
    return f"time per {unit.get(section.key.split()[0], 'run')} [s]"


def _series(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows of each method, in the order of their settings."""
    series: dict[str, list[Row]] = {}
    for row in rows:
        series.setdefault(row.method, []).append(row)
    return series


def _is_a_sequence(rows: Sequence[Row]) -> bool:
    """Whether the settings are ever finer ones of one kind, worth a line."""
    return not any(row.setting.startswith("table") for row in rows)
