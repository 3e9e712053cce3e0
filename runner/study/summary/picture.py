"""Outputs of a study against what varies, as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.extras import extra
from slipmode.runner.study.study_file import Distribution, Study, Varied
from slipmode.runner.study.summary.choice import Choice
from slipmode.runner.study.summary.shown import shown_as, shown_output

_MOST_POINTS = 4000  # of a panel: more are no clearer
_MOST_ROWS = 6
BANDS = ((0.05, 0.95), (0.25, 0.75))
_BLUE, _RED = "#1f5fa8", "#c92a2a"


def draw(dataset: Any, study: Study, choice: Choice | None, path: Path) -> None:
    """A row of panels per output, a column per key; of drawn ones, at the best value if one is."""
    keys = [each.key for each in study.varied]
    rows = outputs(dataset, study)[:_MOST_ROWS]
    figure = extra("matplotlib.figure", "pictures").Figure(
        figsize=(1.5 + 3.5 * len(keys), 0.8 + 2.4 * len(rows)), layout="constrained"
    )
    panels = figure.subplots(len(rows), len(keys), squeeze=False, sharex="col", sharey="row")
    shown = some_samples(dataset, choice)
    for line, (label, values) in zip(panels, rows, strict=True):
        line[0].set_ylabel(label)
        for ax, each in zip(line, study.varied, strict=True):
            column = dataset[each.key].values
            if is_scattered(each, column):
                ax.plot(column[shown], values[shown], ".", color=_BLUE, ms=3, alpha=0.4)
            else:
                _bands(ax, column, values)
            if choice is not None and choice.of.key == each.key:
                _mark(ax, choice)
    for ax, key in zip(panels[-1], keys, strict=True):
        unit = dataset[key].attrs.get("units", "-")
        ax.set_xlabel(f"{key} [{unit}]")
    figure.suptitle(study.title + (f"\n{choice.text()}" if choice else ""))
    figure.savefig(path, dpi=120)


def outputs(dataset: Any, study: Study) -> list[tuple[str, Floats]]:
    """Label and values (samples,) of what is drawn: displacements where there are any.

    These are in the units of the study's scene.
    """
    shown, found = shown_as(study), []
    for kind in ("resonance", "steady", "peak"):
        if kind not in dataset:
            continue
        output = shown_output(dataset, kind, shown)
        for mode in output.values["mode"].values:
            values = output.values.sel(mode=mode).values
            if np.any(np.nan_to_num(values) > 0.0):
                found.append((f"{kind} {mode}{output.where}\n[{output.unit}]", values))
    for kind, across in (("curve", "frequency"), ("at", "time")):
        if kind in dataset:
            output = shown_output(dataset, kind, shown)
            highest = output.values.max(across)
            found += [
                (
                    f"largest of {kind} {mode}{output.where}\n[{output.unit}]",
                    highest.sel(mode=mode).values,
                )
                for mode in highest["mode"].values
            ]
    return found


def some_samples(dataset: Any, choice: Choice | None) -> NDArray[np.intp]:
    """Samples that are drawn as points: those of the best value, if one is chosen.

    Any but every second: what is drawn of distributions has patterns of its own.
    """
    shown = np.random.default_rng(0).permutation(dataset.sizes["sample"])
    if choice is not None:
        shown = shown[dataset[choice.of.key].values[shown] == choice.values[choice.best]]
    return shown[:_MOST_POINTS]


def is_scattered(varied: Varied, column: NDArray[Any]) -> bool:
    """Whether outputs against a key are points: others have quantiles at each of its values."""
    return isinstance(varied.values, Distribution) or column.dtype.kind not in "if"


def quantiles(column: Floats, values: Floats) -> tuple[Floats, dict[float, Floats]]:
    """Values of a key with results, and quantiles of the output there: edges of bands, median."""
    at, group = np.unique(column, return_inverse=True)
    own = [values[(group == k) & ~np.isnan(values)] for k in range(at.size)]
    kept = [k for k, each in enumerate(own) if each.size]
    wanted = (0.5, *(edge for band in BANDS for edge in band))
    return at[kept], {q: np.array([np.quantile(own[k], q) for k in kept]) for q in wanted}


def is_logarithmic(at: Floats) -> bool:
    """Whether values are evenly spaced on a logarithmic scale."""
    return bool(
        at.size > 2 and at[0] > 0.0 and np.allclose(np.diff(np.log(at)), np.log(at[1] / at[0]))
    )


def _bands(ax: Any, column: Floats, values: Floats) -> None:
    """Median and bands of the samples with each value."""
    at, found = quantiles(column, values)
    for low, high in BANDS:
        label = f"{low:.0%} to {high:.0%}"
        ax.fill_between(at, found[low], found[high], color=_BLUE, alpha=0.2, lw=0, label=label)
    ax.plot(at, found[0.5], color=_BLUE, label="median")
    if is_logarithmic(at):
        ax.set_xscale("log")
    ax.legend(frameon=False, fontsize="small")


def _mark(ax: Any, choice: Choice) -> None:
    best = choice.values[choice.best]
    label = f"best: {best:.3g}" if isinstance(best, float) else f"best: {best}"
    ax.axvline(best, color=_RED, lw=1.0, label=label)
    ax.legend(frameon=False, fontsize="small")
