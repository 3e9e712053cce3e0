"""What samples of a study share: the plan of their scene, and friction tables on a ladder.

A sample is computed on the smallest table of its model that holds it, of ranges that double from
step to step: so its result depends on the study alone, not on what is computed beside it.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom import Model, Structure
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.combination import CombinationResonance, combination_resonances
from slipmode.rom.short_repr import short_repr
from slipmode.rom.slow.units import Units
from slipmode.rom.table.cache import cached_model
from slipmode.runner.plan.amplitude_range import Excited
from slipmode.runner.plan.plan import Plan, make_plan
from slipmode.runner.scene.scene import Scene, read_scene
from slipmode.runner.scene.toml_writer import toml_text
from slipmode.runner.study.outputs.asked import Asked
from slipmode.runner.study.scene_keys import Content, get, is_load, with_value
from slipmode.runner.study.shared_limits import is_limit, on_shared_limits

MOST_STEPS = 10  # up the ladder
_SCALE = "limits.scale"


@dataclass(frozen=True)
class Samples:
    """The scene of a study, and how samples are made of it."""

    content: Content
    folder: Path
    keys: tuple[str, ...]
    asked: Asked
    recordings: Path | None = None

    def contents(self, rows: Sequence[tuple[Any, ...]]) -> list[Content]:
        """Scenes of some samples, as parsed TOML, on limits that they share."""
        found = []
        for row in rows:
            content = self.content
            for key, value in zip(self.keys, row, strict=True):
                content = with_value(content, key, value)
            found.append(on_shared_limits(content, self.content))
        return found

    def scenes(self, rows: Sequence[tuple[Any, ...]]) -> list[Scene | str]:
        """Of some samples, or why there is none."""
        found: list[Scene | str] = []
        for content in self.contents(rows):
            try:
                found.append(self.scene(content))
            except SlipmodeError as refusal:
                found.append(said(refusal))
        return found

    def scene(self, content: Content) -> Scene:
        """Of a sample; refused by the reader of scenes, or for having no friction table."""
        text = "" if self.recordings is None else toml_text(content)  # recordings attach it
        scene = read_scene(content, self.folder, text)
        scene.check_tabulated()
        return scene


@dataclass(frozen=True, eq=False)
class SceneModel:
    """What is modelled of a scene, without the table.

    Attributes
    ----------
    excited : Excited
    amplitude : tuple of float
        Range of the table on the lowest step of the ladder [kg^1/2 m].
    may_grow : bool
        Whether there are more: not where the scene gives model.amplitude.
    combinations : tuple of CombinationResonance
        Anywhere between the samples; steady states have none.
    detuned : bool
        Whether forcing frequencies differ between them.
    tolerance : float
    """

    excited: Excited
    amplitude: tuple[float, ...]
    may_grow: bool
    combinations: tuple[CombinationResonance, ...]
    detuned: bool
    tolerance: float

    __repr__ = short_repr

    @classmethod
    def of(
        cls, samples: Samples, contents: Sequence[Content], frequencies: dict[str, Any]
    ) -> SceneModel:
        """The plan of a scene that stands for several.

        Parameters
        ----------
        contents : sequence of dict
            Their scene with loads that may stand for all; the first that has a plan does.
        frequencies : {"A": (lowest, highest), ...}
            Of the forces among them, where they differ [rad/s].

        Raises
        ------
        SlipmodeError
            Of the first, if none has.
        """
        plan = _first_plan(samples, contents)
        scene = plan.scene
        excited, terms = plan.excited, plan.combinations if samples.asked.runs else ()
        detuned = any(mode in frequencies for mode in excited.modes)
        if detuned and samples.asked.runs and scene.model.formulation == "consistent":
            terms = _combinations(plan.excited, plan.schedule, frequencies)
        may_grow = scene.model.amplitude is None
        return cls(excited, plan.amplitude, may_grow, terms, detuned, scene.model.tolerance)

    def model(self, step: int) -> Model:
        """With the table of a step of the ladder, numbered from 0.

        Raises
        ------
        SlipmodeError
            If the contacts have no answer that far.
        """
        ranges = [2.0**step * r for r in self.amplitude]
        model, _ = cached_model(
            *(self.excited.reduced, self.excited.law, ranges, self.tolerance),
            combinations=self.combinations,
            detuning=self.detuned,
        )
        return model


def typical(
    samples: Samples, columns: Sequence[np.ndarray]
) -> tuple[list[Content], dict[str, Any]]:
    """What `SceneModel.of` has of several samples of one model.

    The scenes have loads in the middle of those of the samples, and the study's own.
    """
    row, frequencies = [], {}
    for key, column in zip(samples.keys, columns, strict=True):
        value = column[0]
        numbers = column[column > 0.0] if column.dtype.kind in "if" else np.zeros(0)
        if key.endswith("frequency") and key.startswith("forcing") and numbers.size:
            low, high = float(numbers.min()), float(numbers.max())
            value = np.quantile(numbers, 0.5, method="lower")
            if low < high:
                per_unit = Units(get(samples.content, "units.frequency") or "rad/s").per_frequency
                frequencies[key.split(".")[1]] = per_unit * low, per_unit * high
        elif numbers.size and (key.endswith(".amplitude") or is_limit(key) or key == _SCALE):
            value = float(np.sqrt(numbers.min() * numbers.max()))
        row.append(value.item() if isinstance(value, np.generic) else value)
    own = [
        get(samples.content, key) if is_load(key) else value
        for key, value in zip(samples.keys, row, strict=True)
    ]
    rows = [tuple(row)] + [tuple(own)] * (None not in own)
    return samples.contents(rows), frequencies


def _first_plan(samples: Samples, contents: Sequence[Content]) -> Plan:
    refused: list[SlipmodeError] = []
    for content in contents:
        try:
            scene = samples.scene(content)
            return make_plan(scene, structure=_structure(scene))
        except SlipmodeError as refusal:
            refused.append(refusal)
    raise refused[0]


def model_of(content: Content) -> Content:
    """What of a scene its model depends on: all but the loads."""
    kept = copy.copy(content)
    for mode in ("A", "B"):
        if isinstance(get(content, f"forcing.{mode}"), dict):
            kept["forcing"] = dict(kept["forcing"])
            kept["forcing"][mode] = {
                key: value
                for key, value in content["forcing"][mode].items()
                if key not in ("amplitude", "frequency", "phase")
            }
    kept.pop("limits", None)
    return kept


def _combinations(
    excited: Excited, schedule: Any, frequencies: dict[str, Any]
) -> tuple[CombinationResonance, ...]:
    """Combination resonances anywhere between the frequencies of samples.

    A harmonic is as near to a carrier as at a corner of these ranges, or passes it between two.
    """
    if len(excited.modes) < 2:
        return ()
    held = schedule.mean_frequency(excited.modes)
    ends = [frequencies.get(m, (mean, mean)) for m, mean in zip(excited.modes, held, strict=True)]
    corners = np.array([(a, b) for a in ends[0] for b in ends[1]])
    pairs = np.array(list(combinations(range(4), 2)))
    return combination_resonances(
        corners[pairs[:, 0]], corners[pairs[:, 1]], even=excited.reduced.even
    )


_built: list[tuple[object, Structure]] = []  # the last one, for its modes are kept with it


def _structure(scene: Scene) -> Structure:
    """Of a scene; it is built once in a row of scenes that have the same."""
    for section, structure in _built:
        if section == scene.structure:
            return structure
    _built[:] = [(scene.structure, scene.structure.build())]
    return _built[0][1]


def step_refusal(may_grow: bool, reason: str) -> str:
    """Why a sample has no result that leaves every table."""
    if not may_grow:
        return f"{reason}; leave out model.amplitude, and it is found"
    return "forcing: the amplitudes grow without bound; give structure.damping a value > 0"


def said(error: Exception) -> str:
    """The reason that an error gives, on a line."""
    words = " ".join(str(error).split())
    if isinstance(error, SlipmodeError) and words:
        return words
    return f"{type(error).__name__}: {words}" if words else type(error).__name__
