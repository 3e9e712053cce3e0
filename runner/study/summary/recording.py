"""Outputs of a study against what varies, as a recording in Rerun."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.study.results import FAILED
from slipmode.runner.study.study_file import Study, Varied
from slipmode.runner.study.summary.choice import Choice
from slipmode.runner.study.summary.picture import (
    BANDS,
    is_logarithmic,
    is_scattered,
    outputs,
    quantiles,
    some_samples,
)
from slipmode.runner.view.charts import Axis, Chart, Layer, write_charts
from slipmode.runner.view.labels import BLUE, GREEN, GREY, ORANGE, RED

_MOST_ROWS = 4  # of charts, that they can be read
_MOST_BINS = 40
_MOST_LISTED = 200  # failures, one by one


def record(
    dataset: Any, study: Study, choice: Choice | None, lines: Sequence[str], path: Path
) -> None:
    """A row of charts per output: against each key, and how its values are distributed.

    Parameters
    ----------
    dataset : xarray.Dataset
        The results.
    study : Study
    choice : Choice, optional
        The best value of a key: points are the samples with it.
    lines : sequence of str
        What the study came to.
    path : Path
        Of the .rrd file.
    """
    shown = some_samples(dataset, choice)
    failed = dataset["status"].values == FAILED
    rows = []
    for label, values in outputs(dataset, study)[:_MOST_ROWS]:
        name, _, unit = label.partition("\n")
        of = f"{name} {unit}".replace("kg^1/2", "kg^0.5")
        entity = f"/{name.replace(' ', '_')}"
        row = [
            _against(each, dataset, values, shown, failed, (entity, name, of), choice)
            for each in study.varied
        ]
        rows.append([*row, _distribution(values, entity, name, of)])
    texts = {
        "What was found": "\n\n".join([f"# {study.title}", *lines]),
        "Failures": _failures(dataset, failed),
        "Study": f"```toml\n{study.text}\n```",
        "Scene": f"```toml\n{study.scene.text}\n```",
    }
    write_charts(path, study.title, rows, texts)


def _against(
    varied: Varied,
    dataset: Any,
    values: Floats,
    shown: NDArray[np.intp],
    failed: NDArray[np.bool_],
    named: tuple[str, str, str],
    choice: Choice | None,
) -> Chart:
    """An output against a key: points, or quantiles at its values; where samples failed."""
    entity, name, label = named
    column = dataset[varied.key].values
    names: tuple[str, ...] = ()
    if column.dtype.kind not in "if":
        kinds, column = np.unique([str(value) for value in column], return_inverse=True)
        names = tuple(kinds.tolist())
    column = column.astype(float)
    log = False
    layers: list[Layer] = []
    if is_scattered(varied, dataset[varied.key].values):
        layers.append(Layer(column[shown], values[shown], BLUE, "samples", False, 2.0))
    else:
        at, found = quantiles(column, values)
        log = is_logarithmic(at)
        layers.append(Layer(at, found[0.5], BLUE, "median", at.size > 1, 2.5))
        for (low, high), color in zip(BANDS, (GREY, GREEN), strict=True):
            layers += [
                Layer(at, found[low], color, f"{low:.0%} to {high:.0%}", at.size > 1, 1.0),
                Layer(at, found[high], color, "", at.size > 1, 1.0),
            ]
    if failed.any():
        at = np.unique(column[failed])
        layers.append(Layer(at, np.zeros(at.size), RED, "failed", False, 4.0))
    if choice is not None and choice.of.key == varied.key:
        best = float(np.flatnonzero(choice.values == choice.values[choice.best])[0])
        if not names:
            best = float(choice.values[choice.best])
        top = np.nanmax(values)
        layers.append(Layer(np.full(2, best), np.array([0.0, top]), ORANGE, "best"))
    unit = dataset[varied.key].attrs.get("units", "-")
    return Chart(
        f"{entity}/{varied.key.replace('.', '_')}",
        f"{name} against {varied.key}",
        Axis(f"{varied.key} [{unit}]", names, log),
        Axis(label),
        layers,
    )


def _distribution(values: Floats, entity: str, name: str, label: str) -> Chart:
    """How many samples have which values."""
    there = values[np.isfinite(values)]
    counts, edges = np.histogram(there, min(_MOST_BINS, max(1, round(2 * there.size ** (1 / 3)))))
    x, y = np.repeat(edges, 2), np.concatenate(([0], np.repeat(counts, 2), [0])).astype(float)
    layers = [Layer(x, y)]
    for part in (0.05, 0.5, 0.95):
        at = float(np.quantile(there, part))
        line = Layer(
            np.full(2, at), np.array([0.0, counts.max()]), ORANGE, f"{part:.0%}: {at:.4g}"
        )
        layers.append(line)
    return Chart(
        f"{entity}/distribution",
        f"Distribution of {name}",
        Axis(label),
        Axis("samples"),
        layers,
    )


def _failures(dataset: Any, failed: NDArray[np.bool_]) -> str:
    """How many failed of what, and the samples."""
    if not failed.any():
        return "None."
    reasons = dataset["reason"].values[failed].tolist()
    found = [f"- {n} x {why}" for why, n in Counter(reasons).most_common()]
    numbers = np.flatnonzero(failed)
    each = [f"- sample {k}: {why}" for k, why in zip(numbers, reasons, strict=True)]
    left = len(each) - _MOST_LISTED
    more = [f"- and {left} others"] if left > 0 else []
    return "\n".join([*found, "", *each[:_MOST_LISTED], *more])
