"""What a study comes to, in lines and files."""

from __future__ import annotations

import logging
from collections import Counter
from typing import Any

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.command_words import command_words
from slipmode.runner.study.results import FAILED
from slipmode.runner.study.study import StudyResults
from slipmode.runner.study.summary.choice import Choice, choice
from slipmode.runner.study.summary.picture import draw
from slipmode.runner.study.summary.recording import record
from slipmode.runner.study.summary.sensitivity import sensitivity
from slipmode.runner.study.summary.shown import shown_as

_log = logging.getLogger("slipmode.study")

_MOST_REASONS = 3


def summarise(done: StudyResults) -> list[str]:
    """Lines that say what was found, failures first; picture and recording are beside it."""
    dataset = done.dataset()
    lines = _failures(dataset)
    if done.failed == done.samples:
        return [*lines, str(done.path)]
    chosen: Choice | None = None
    if done.study.choose is not None:
        try:
            chosen = choice(dataset, done.study.choose, shown_as(done.study))
        except SlipmodeError as refusal:
            lines.append(str(refusal))
        else:
            lines.append(chosen.text())
    if done.study.sampling.method == "saltelli":
        lines += _sensitivities(dataset, done)
    found = list(lines)
    lines.append(str(done.path))
    picture = done.path.with_suffix(".png")
    try:
        draw(dataset, done.study, chosen, picture)
    except SlipmodeError as refusal:  # no matplotlib: the results are there all the same
        _log.warning("%s: not drawn: %s", picture, refusal)
    else:
        lines.append(str(picture))
    recording = done.path.with_suffix(".rrd")
    record(dataset, done.study, chosen, found, recording)
    return [*lines, str(recording)]


def _failures(dataset: Any) -> list[str]:
    """The most frequent reasons."""
    reasons = Counter(dataset["reason"].values[dataset["status"].values == FAILED].tolist())
    lines = [
        f"failed: {n} x {command_words(why)}" for why, n in reasons.most_common(_MOST_REASONS)
    ]
    left = len(reasons) - len(lines)
    return [*lines, f"and {left} other reasons"] if left > 0 else lines


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
            except SlipmodeError as refusal:
                lines.append(str(refusal))
            else:
                lines += found.text()
    return lines
