"""The findings of a study, in lines and files."""

from __future__ import annotations

import logging
from collections import Counter
from typing import Any

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.transient import said_error
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.study.results import FAILED
from slipmode.runner.study.study import StudyResults
from slipmode.runner.study.study_file import Study
from slipmode.runner.study.summary.amplifications import amplifications
from slipmode.runner.study.summary.charts import (
    draw,
    outputs,
    shown_as,
    shown_output,
    study_charts,
)
from slipmode.runner.study.summary.statistics import choice, sensitivity
from slipmode.runner.view.charts import write_charts

_log = logging.getLogger("slipmode.study")


def summarise(done: StudyResults) -> list[str]:
    """Return lines with the findings, failures first; write a picture and a recording."""
    study, dataset = done.study, done.dataset()
    reasons = dataset["reason"].values[dataset["status"].values == FAILED].tolist()
    lines = _failures(reasons)
    if done.failed == done.samples:
        return [*lines, str(done.path)]
    chosen, best = None, ""
    if study.choose is not None:
        kind, mode = study.choose.output.rsplit("_", 1)
        output = shown_output(dataset, kind, shown_as(study))
        values = output.values.sel(mode=mode).values
        try:
            chosen = choice(dataset[study.choose.key].values, values, study.choose)
            best = chosen.text(output.unit, output.where)
            lines.append(best)
        except SlipmodeError as refusal:
            lines.append(str(refusal))
    if study.sampling.method == "saltelli":
        lines += _sensitivities(dataset, done)
    if study.outputs.mistuned:
        lines += amplifications(dataset, study)
    if study.outputs.runs:
        lines.append(_transient_errors(dataset, study.scene.model.transient_error))
    found = list(lines)
    lines.append(str(done.path))
    charts = study_charts(dataset, study, chosen)
    picture, recording = done.path.with_suffix(".png"), done.path.with_suffix(".rrd")
    try:
        draw(charts, f"{study.title}\n{best or _spread(dataset, study)}".strip(), picture)
        lines.append(str(picture))
    except SlipmodeError as refusal:  # without matplotlib there is no picture
        _log.warning("%s: not drawn: %s", picture, refusal)
    texts = {
        "What was found": "\n\n".join([f"# {study.title}", *found]),
        "Failures": _failed_samples(dataset, reasons),
        "Study": f"```toml\n{study.text}\n```",
        "Scene": f"```toml\n{study.scene.text}\n```",
    }
    write_charts(recording, study.title, charts, texts)
    return [*lines, str(recording)]


def _spread(dataset: Any, study: Study) -> str:
    """Return the range of the first output that has values, without the outer 5 % at each end."""
    for name, unit, values in outputs(dataset, study)[:1]:
        low, high = np.nanquantile(values, (0.05, 0.95))
        return f"90 % of the samples: {name} from {low:.3g} to {high:.3g} {unit}"
    return ""


def _transient_errors(dataset: Any, allowed: float) -> str:
    """Return the largest transient errors of runs, relative to the largest amplitude of all."""
    size = dataset["peak"] if "peak" in dataset else dataset["at"].max("time")
    largest = size.max("sample").values
    error = dataset["run_error"].max("sample").values
    part = np.divide(error, largest, out=np.zeros(error.shape), where=largest > 0.0)
    line = said_error(dataset["mode"].values.tolist(), part)
    if np.all(part <= allowed):
        return line
    return (
        f"{line}, allowed: {percentage(allowed)}; to integrate such stretches at full order, "
        "record the samples (outputs.recording = true)"
    )


def _failures(reasons: list[str]) -> list[str]:
    """Return the most frequent reasons."""
    count = Counter(reasons)
    lines = [f"failed: {n} x {command_words(why)}" for why, n in count.most_common(3)]
    others = len(count) - len(lines)
    return [*lines, f"and {others} other reasons"] if others > 0 else lines


def _failed_samples(dataset: Any, reasons: list[str]) -> str:
    """Return how often each reason occurs, and the samples, in Markdown."""
    if not reasons:
        return "None."
    numbers = np.flatnonzero(dataset["status"].values == FAILED)
    each = [f"- sample {k}: {why}" for k, why in zip(numbers, reasons, strict=True)]
    others = len(each) - 200
    more = [f"- and {others} others"] if others > 0 else []
    count = [f"- {n} x {why}" for why, n in Counter(reasons).most_common()]
    return "\n".join([*count, "", *each[:200], *more])


def _sensitivities(dataset: Any, done: StudyResults) -> list[str]:
    lines = []
    keys = tuple(each.key for each in done.study.varied)
    for kind in ("steady", "resonance", "peak"):
        if kind not in dataset:
            continue
        for mode in dataset["mode"].values:
            values = dataset[kind].sel(mode=mode).values
            if not (values > 0.0).any():
                continue
            try:
                found = sensitivity(f"{kind}_{mode}", values, keys, done.study.sampling.seed)
                lines += found.text()
            except SlipmodeError as refusal:
                lines.append(str(refusal))
    return lines
