"""The picture of the report: error against time, one panel per kind of task."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.report.sections import OURS, Row, Section, by_method
from benchmarks.report.text import time_in_words
from slipmode.rom.extras import extra
from slipmode.rom.short_repr import percentage
from slipmode.runner.pictures import page_figure, write_beside

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Colours by the beginning of a label.
_COLOURS = {
    OURS: "#c1272d",
    "paper formulation": "#b97a00",
    "full order": "#1b4f8f",
    "Craig-Bampton": "#2f8fbf",
    "LSODA": "#6a3d9a",
    "harmonic balance": "#b8407f",
    "scheme (31)": "#b97a00",
}
# What else than the slow flow is timed: fast motion at every sample, or a single steady state.
_VARIANTS = {"motion": "\n+ motion", "sums": "\n+ motion", "one state": "\none state"}


def draw(sections: Sequence[Section], folder: Path) -> Path:
    """Write speed-error.png into a folder and return its path."""
    path = folder / "speed-error.png"
    folder.mkdir(parents=True, exist_ok=True)
    shown = _shown(sections)
    rows = -(-len(shown) // 2)
    once = _time(_labelled(sections[0]).table_seconds)
    title = (
        f"Error against time: lower left is better\n(friction tables, {once} here, are made once)"
    )
    with page_figure(path, title, 0.6 + 3.3 * rows) as figure:
        panels = figure.subplots(rows, 2, squeeze=False).ravel()
        for panel, section in zip(panels, shown, strict=False):
            _panel(panel, section)
        for panel in panels[len(shown) :]:
            panel.remove()
    return path


def _shown(sections: Sequence[Section]) -> list[Section]:
    """Return the first section of each kind of run, and the last one: the largest structure."""
    first = {section.run: section for section in reversed(sections)}
    last = [] if sections[-1] in first.values() else [sections[-1]]
    return [section for section in sections if section in first.values()] + last


def result(section: Section) -> str:
    """Return our error and time, and the time of the fastest other method at this error."""
    ours = _labelled(section)
    rivals = sorted(section.rivals(ours), key=lambda row: row.seconds)
    words = f"{OURS}: {percentage(ours.error)} in {_time(ours.seconds)};"
    if not rivals:
        return f"{words}\nno other method is as accurate"
    return f"{words}\n{rivals[0].method}: {_time(rivals[0].seconds)}"


def _labelled(section: Section) -> Row:
    """Return our fastest setting, at whose point the label stands."""
    return _front(_curves(section.rows)[OURS])[0]


def _panel(axes: Axes, section: Section) -> None:
    for label, rows in _curves(section.rows).items():
        color = next((c for name, c in _COLOURS.items() if label.startswith(name)), "black")
        front = _front(rows)
        seconds, errors = [row.seconds for row in front], [100.0 * row.error for row in front]
        axes.plot(seconds, errors, "o-", color=color, markersize=4, linewidth=1.0)
        place = (seconds[0], errors[0]) if label == OURS else (seconds[-1], errors[-1])
        write_beside(axes, place, label, color, above=label == OURS)
    axes.set(xscale="log", yscale="log", ylabel=f"relative error, {section.errors[0]} [%]")
    axes.set_title(f"{section.title.capitalize()}\n{result(section)}")
    axes.set_xlabel(f"time per {section.run}")
    low, high = axes.get_xlim()
    axes.set_xlim(0.2 * low, 30.0 * high)  # labels stand beside the curves
    locator = extra("matplotlib.ticker", "pictures").LogLocator(numticks=4)
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(lambda seconds, _: _time(seconds))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("")
    axes.yaxis.set_minor_formatter("")


def _curves(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return the rows by label: variants of a method, and both solvers, share a curve."""
    methods = by_method(rows)
    solvers = ", ".join(name for name in ("LSODA", "CVODE") if name in methods)
    found: dict[str, list[Row]] = {}
    for method, own in methods.items():
        name, _, variant = method.partition(", ")
        label = name.partition(" from ")[0]  # of the printed scheme
        if label == OURS:
            label += _VARIANTS.get(variant, "")
        found.setdefault(solvers if label in ("LSODA", "CVODE") else label, []).extend(own)
    return found


def _time(seconds: float) -> str:
    return time_in_words(seconds).replace("us", "µs")


def _front(rows: Sequence[Row]) -> list[Row]:
    """Return the rows that no row is both faster and more accurate than, the fastest first."""
    front: list[Row] = []
    for row in sorted(rows, key=lambda row: (row.seconds, row.error)):
        if not front or row.error < front[-1].error:
            front.append(row)
    return front
