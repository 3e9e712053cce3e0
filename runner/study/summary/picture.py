"""Outputs of a study against what varies, as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.extras import extra
from slipmode.runner.study.outputs.asked import Asked
from slipmode.runner.study.study_file import Distribution, Study
from slipmode.runner.study.summary.choice import Choice

_MOST_POINTS = 4000  # of a panel: more are no clearer
_MOST_ROWS = 6
_BANDS = ((0.05, 0.95), (0.25, 0.75))
_BLUE, _RED = "#1f5fa8", "#c92a2a"


def draw(dataset: Any, study: Study, choice: Choice | None, path: Path) -> None:
    """A row of panels per output, a column per key; of drawn ones, at the best value if one is."""
    keys = [each.key for each in study.varied]
    rows = _outputs(dataset, study.asked)[:_MOST_ROWS]
    figure = extra("matplotlib.figure", "pictures").Figure(
        figsize=(1.5 + 3.5 * len(keys), 0.8 + 2.4 * len(rows)), layout="constrained"
    )
    panels = figure.subplots(len(rows), len(keys), squeeze=False, sharex="col", sharey="row")
    # any samples but every second: what is drawn of distributions has patterns of its own
    shown = np.random.default_rng(0).permutation(dataset.sizes["sample"])
    if choice is not None:
        shown = shown[dataset[choice.of.key].values[shown] == choice.values[choice.best]]
    shown = shown[:_MOST_POINTS]
    for line, (label, values) in zip(panels, rows, strict=True):
        line[0].set_ylabel(label)
        for ax, each in zip(line, study.varied, strict=True):
            column = dataset[each.key].values
            if isinstance(each.values, Distribution) or column.dtype.kind not in "if":
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


def _outputs(dataset: Any, asked: Asked) -> list[tuple[str, Floats]]:
    """Label and values (samples,) of what is drawn: displacements where there are any."""
    found = []
    for kind in ("resonance", "steady", "peak"):
        if kind not in dataset:
            continue
        shown = dataset[f"{kind}_displacement"].isel(dof=0) if asked.dofs else dataset[kind]
        unit = shown.attrs["units"]
        where = f" of DOF {asked.dofs[0]}" if asked.dofs else ""
        for mode in shown["mode"].values:
            values = shown.sel(mode=mode).values
            if np.any(np.nan_to_num(values) > 0.0):
                found.append((f"{kind} {mode}{where}\n[{unit}]", values))
    for kind, across in (("curve", "frequency"), ("at", "time")):
        if kind in dataset:
            highest = dataset[kind].max(across)
            found += [
                (f"largest of {kind} {mode}\n[kg^1/2 m]", highest.sel(mode=mode).values)
                for mode in highest["mode"].values
            ]
    return found


def _bands(ax: Any, column: Floats, values: Floats) -> None:
    """Median and bands of the samples with each value."""
    at, group = np.unique(column, return_inverse=True)
    own = [values[(group == k) & ~np.isnan(values)] for k in range(at.size)]
    kept = [k for k, each in enumerate(own) if each.size]
    at, own = at[kept], [own[k] for k in kept]
    for low, high in _BANDS:
        edges = [np.array([np.quantile(each, q) for each in own]) for q in (low, high)]
        ax.fill_between(at, *edges, color=_BLUE, alpha=0.2, lw=0, label=f"{low:.0%} to {high:.0%}")
    ax.plot(at, [np.median(each) for each in own], color=_BLUE, label="median")
    if at.size > 2 and at[0] > 0.0 and np.allclose(np.diff(np.log(at)), np.log(at[1] / at[0])):
        ax.set_xscale("log")
    ax.legend(frameon=False, fontsize="small")


def _mark(ax: Any, choice: Choice) -> None:
    best = choice.values[choice.best]
    label = f"best: {best:.3g}" if isinstance(best, float) else f"best: {best}"
    ax.axvline(best, color=_RED, lw=1.0, label=label)
    ax.legend(frameon=False, fontsize="small")
