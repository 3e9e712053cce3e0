"""Outputs of a study against its keys, as charts for pictures and for Rerun."""

from __future__ import annotations

from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.slow.units import Shown
from slipmode.runner.pictures import page_figure
from slipmode.runner.study.results import FAILED
from slipmode.runner.study.sample_outputs import MODAL
from slipmode.runner.study.study_file import Distribution, Study, Varied
from slipmode.runner.study.summary.statistics import Choice
from slipmode.runner.view.charts import Axis, Chart, Layer
from slipmode.runner.view.plots import BLUE, GREEN, GREY, ORANGE, RED

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class ShownOutput(NamedTuple):
    """An output (sample, mode, ...) with its unit, and its DOF in words."""

    values: Any
    unit: str
    where: str


def shown_as(study: Study) -> Shown:
    """Return how a study shows amplitudes: of its first DOF if it has any, in scene units."""
    dofs = study.outputs.dofs
    return Shown(dofs[0] if dofs else None, study.scene.units, MODAL)


def shown_output(dataset: Any, kind: str, shown: Shown) -> ShownOutput:
    """Return the output of a kind, "steady" or "resonance" for instance, as it is shown."""
    if shown.dof is not None:
        metres = dataset[f"{kind}_displacement"].isel(dof=0)
    elif dataset[kind].attrs["units"] == "m":  # of blades
        metres = dataset[kind]
    else:
        return ShownOutput(dataset[kind], dataset[kind].attrs["units"], "")
    where = "" if shown.dof is None else f" at DOF {shown.dof}"
    values = metres.copy(data=shown.units.of_displacement(metres.values))
    return ShownOutput(values, shown.units.displacement, where)


def outputs(dataset: Any, study: Study) -> list[tuple[str, str, Floats]]:
    """Return name, unit and values (samples,) of each output with a chart."""
    shown, found = shown_as(study), []
    across = {
        "amplification": "",
        "resonance": "",
        "steady": "",
        "peak": "",
        "curve": "frequency",
        "at": "time",
    }
    for kind, dimension in across.items():
        if kind not in dataset or (kind == "curve" and study.outputs.mistuned):
            continue  # the largest of the curve of a mistuned disk is its resonance
        output = shown_output(dataset, kind, shown)
        values = output.values.max(dimension) if dimension else output.values
        for mode in values["mode"].values:
            own = values.sel(mode=mode).values
            if dimension or np.any(np.nan_to_num(own) > 0.0):
                name = f"largest of {kind}" if dimension else kind
                found.append((f"{name} {mode}{output.where}", output.unit, own))
    return found


def study_charts(dataset: Any, study: Study, choice: Choice | None) -> list[list[Chart]]:
    """Return a row of charts per output: against each key, and the distribution of its values.

    If a best value of a key is chosen, points are the samples with it.
    """
    rows = []
    for name, unit, values in outputs(dataset, study)[:4]:  # more would not be legible
        label = f"{name} [{unit}]".replace("kg^1/2", "kg^0.5")  # Rerun has no formulae
        entity = f"/{name.replace(' ', '_')}"
        row = []
        for each in study.varied:
            x, layers = _against(dataset, each, values, choice)
            title = f"{name} against {each.key}"
            place = f"{entity}/{each.key.replace('.', '_')}"
            row.append(Chart(place, title, x, Axis(label), layers))
        title, place = f"Distribution of {name}", f"{entity}/distribution"
        row.append(Chart(place, title, Axis(label), Axis("samples"), _histogram(values)))
        rows.append(row)
    return rows


def _against(
    dataset: Any, varied: Varied, values: Floats, choice: Choice | None
) -> tuple[Axis, list[Layer]]:
    """Return the scale of a key, and layers: points, or quantiles at each of its values."""
    column, names, log = dataset[varied.key].values, (), False
    is_number = column.dtype.kind in "if"
    if not is_number:
        kinds, column = np.unique([str(value) for value in column], return_inverse=True)
        names = tuple(kinds.tolist())
    column = column.astype(float)
    layers: list[Layer] = []
    if isinstance(varied.values, Distribution) or not is_number:
        shown = _some_samples(dataset, choice)
        layers.append(Layer(column[shown], values[shown], BLUE, "", False, 2.0))
    else:
        at, group = np.unique(column, return_inverse=True)
        own = [values[(group == k) & ~np.isnan(values)] for k in range(at.size)]
        at, own = at[[each.size > 0 for each in own]], [each for each in own if each.size]
        curve = at.size > 1
        if at.size > 2 and at[0] > 0.0:
            log = np.allclose(np.diff(np.log(at)), np.log(at[1] / at[0]))
        median = np.array([np.median(each) for each in own])
        for low, high, color in ((0.05, 0.95, GREY), (0.25, 0.75, GREEN)):
            edges = np.array([np.quantile(each, (low, high)) for each in own]).T
            if curve and np.any(edges[0] < edges[1]):
                name = f"{low:.0%} to {high:.0%}"
                layers.append(Layer(at, edges[0], color, name, width=1.0, top=edges[1]))
        layers.append(Layer(at, median, BLUE, "median", curve, 2.5))
    failed = dataset["status"].values == FAILED
    if failed.any():
        at = np.unique(column[failed])
        layers.append(Layer(at, np.zeros(at.size), RED, "failed", False, 4.0))
    if choice is not None and choice.of.key == varied.key:
        best = choice.values[choice.best]
        x, words = (best, f"best: {best:.3g}") if is_number else (names.index(str(best)), "best")
        layers.append(_vertical(float(x), np.nanmax(values), words))
    unit = dataset[varied.key].attrs.get("units", "-")
    return Axis(f"{varied.key} [{unit}]", names, log), layers


def _some_samples(dataset: Any, choice: Choice | None) -> NDArray[np.intp]:
    """Return samples to show as points, in random order: regular selections form patterns."""
    shown = np.random.default_rng(0).permutation(dataset.sizes["sample"])
    if choice is not None:
        shown = shown[dataset[choice.of.key].values[shown] == choice.values[choice.best]]
    return shown[:4000]  # more only overlap


def _histogram(values: Floats) -> list[Layer]:
    known = values[np.isfinite(values)]
    bins = min(40, max(1, round(2 * known.size ** (1 / 3))))  # Rice's rule
    counts, edges = np.histogram(known, bins)
    x, y = np.repeat(edges, 2), np.concatenate(([0], np.repeat(counts, 2), [0])).astype(float)
    quantiles = {part: float(np.quantile(known, part)) for part in (0.05, 0.5, 0.95)}
    lines = [_vertical(at, counts.max(), f"{p:.0%}: {at:.4g}") for p, at in quantiles.items()]
    return [Layer(x, y), *lines]


def _vertical(x: float, top: float, name: str) -> Layer:
    return Layer(np.full(2, x), np.array([0.0, top]), ORANGE, name)


def draw(rows: list[list[Chart]], title: str, path: Path) -> None:
    """Draw up to four charts as a picture: of one output, or two of each of two outputs."""
    rows = rows[:2]
    charts = [chart for *keys, spread in rows for chart in [*keys, spread][: 4 // len(rows)]]
    charts = charts[: max(2 * (len(charts) // 2), 1)]  # no empty place
    height = 0.6 + 2.8 * ceil(len(charts) / 2)
    with page_figure(path, title, height) as figure:
        panels = figure.subplots(ceil(len(charts) / 2), 2, squeeze=False).ravel()
        for ax, chart in zip(panels, charts, strict=False):
            _draw_chart(ax, chart)
        for ax in panels[len(charts) :]:
            ax.remove()


def _draw_chart(ax: Axes, chart: Chart) -> None:
    for layer in chart.layers:
        style = {"lw": layer.width} if layer.curve else {"ls": "", "marker": ".", "ms": 3}
        color, name = np.divide(layer.color, 255), layer.name or None
        if layer.top is not None:
            ax.fill_between(layer.x, layer.y, layer.top, color=color, alpha=0.4, lw=0, label=name)
        else:
            ax.plot(layer.x, layer.y, color=color, label=name, **style)
    scale = "log" if chart.x.log else "linear"
    ax.set(xlabel=chart.x.label, ylabel=chart.y.label, xscale=scale)
    if chart.x.names:
        ax.set_xticks(range(len(chart.x.names)), chart.x.names)
    if any(layer.name for layer in chart.layers):
        ax.legend()
