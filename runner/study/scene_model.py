"""Samples of a study as scenes, and what they share: a plan, and friction tables.

The tables of a model have ranges that double from step to step. A sample is computed on the first
table that holds it, so that its result depends on the study alone, not on other samples.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations as pairs_of
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom import Model, Structure
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import RPM
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.tones import combinations_along
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.units import Units
from slipmode.rom.validity import warn
from slipmode.runner.messages import one_line
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.planning import make_plan
from slipmode.runner.scene.scene import read_scene
from slipmode.runner.scene.sections import Scene
from slipmode.runner.scene.structures import Source
from slipmode.runner.scene.toml_table import Content, get, toml_text
from slipmode.runner.study.design import Design
from slipmode.runner.study.sample_outputs import Outputs
from slipmode.runner.study.scene_keys import is_limit, is_load, with_value
from slipmode.runner.study.shared_limits import on_shared_limits

_log = logging.getLogger("slipmode.study")

Frequencies = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Samples:
    """The scene of a study, as parsed, and how samples are made of it."""

    content: Content
    folder: Path  # The folder of the scene's files
    modes: tuple[str, ...]  # The modes of the scene, in the order of the results
    outputs: Outputs
    recordings: Path | None = None  # The folder for recordings of the samples

    def contents(self, design: Design) -> list[Content]:
        """Return the scenes of samples, as parsed TOML, on limits that they share."""
        return [self.content_with(design.keys, row) for row in design.rows()]

    def content_with(self, keys: Sequence[str], row: Sequence[Any]) -> Content:
        """Return the scene with values of some keys, on the shared limits."""
        content = self.content
        for key, value in zip(keys, row, strict=True):
            content = with_value(content, key, value)
        return on_shared_limits(content, self.content)

    def scenes(self, design: Design) -> list[Scene | str]:
        """Return the scenes of samples, or why they are refused."""
        found: list[Scene | str] = []
        for content in self.contents(design):
            try:
                found.append(self.scene(content))
            except SlipmodeError as refusal:
                found.append(one_line(refusal))
        return found

    def scene(self, content: Content) -> Scene:
        """Return the scene of a sample; refuse one that is neither tabulated nor mistuned."""
        text = "" if self.recordings is None else toml_text(content)  # recordings attach it
        scene = read_scene(content, self.folder, text)
        if scene.wear:
            raise SlipmodeError("limits.wear: must be left out, because studies have no wear")
        if not (self.outputs.mistuned and scene.mistuning):
            scene.check_tabulated()
        return scene


@frozen
class SceneModel:
    """What samples of one model share, without the friction tables.

    It does not hold the structure: it is sent to every worker.
    """

    samples: Samples
    excited: Excited
    # Quasi-static displacement of the DOFs per modal force (n_dofs, modes) [kg^1/2 m/N]; None
    # without `outputs.dofs`
    static: Floats | None
    amplitude: tuple[float, ...]  # Range of the first table [kg^1/2 m]
    table_tolerance: float
    # Those anywhere between the samples; steady states have none
    combinations: tuple[CombinationResonance, ...]
    detuned: bool  # Whether forcing frequencies differ between the samples
    # Whether there are larger tables: not of a saved model, nor if the scene gives model.amplitude
    may_grow: bool
    saved_model: Model | None  # The model, if the scene has a saved one

    @classmethod
    def of(cls, samples: Samples, design: Design) -> SceneModel:
        """Return the model of samples that differ in loads and in a factor on limits.

        The plan is made for loads in the middle of their ranges, or, if this is refused, for the
        study's own loads. Raises SlipmodeError if neither scene has a plan.
        """
        contents, frequencies = _representatives(samples, design)
        plan = _first_plan(samples, contents)
        for line in plan.warnings:
            _log.warning("%s", line)
        model = plan.scene.model
        detuned = any(mode in frequencies for mode in plan.excited.modes)
        combinations = plan.combinations if samples.outputs.runs else ()
        if samples.outputs.runs and detuned and model.formulation == "consistent":
            combinations = _combinations(plan, frequencies)
        return cls(
            samples=samples,
            excited=plan.excited,
            static=_static(plan) if samples.outputs.dofs else None,
            amplitude=plan.amplitude,
            table_tolerance=model.tolerance,
            combinations=combinations,
            detuned=detuned,
            may_grow=model.amplitude is None,
            saved_model=plan.scene.saved_model,
        )

    def model(self, step: int) -> Model:
        """Return the model with the table of a step, numbered from 0.

        Raises SlipmodeError if the contact problem has no solution at such amplitudes.
        """
        if self.saved_model is not None:
            return self.saved_model
        model, _ = self.excited.model(
            [2.0**step * amplitude for amplitude in self.amplitude],
            self.table_tolerance,
            combinations=self.combinations,
            detuning=self.detuned,
        )
        warn(model.accuracy.findings())
        return model


def _static(plan: ModesPlan) -> Floats:
    excited = plan.excited
    applied = AppliedForces.of(excited.reduced, excited.force_patterns, excited.structure)
    return applied.static


def _first_plan(samples: Samples, contents: Sequence[Content]) -> ModesPlan:
    """Return the plan of the first scene that has one; raise the first refusal if none has."""
    refused: list[SlipmodeError] = []
    for content in contents:
        try:
            scene = samples.scene(content)
            return make_plan(scene, structure=_built(scene))
        except SlipmodeError as refusal:
            refused.append(refusal)
    raise refused[0]


def _representatives(samples: Samples, design: Design) -> tuple[list[Content], Frequencies]:
    """Return scenes that stand for samples, and ranges of the frequencies that differ [rad/s]."""
    row, frequencies = [], {}
    units = Units(get(samples.content, "units.frequency") or "rad/s")
    for key, column in zip(design.keys, design.columns, strict=True):
        value = column[0]
        positive = column[column > 0.0] if column.dtype.kind in "if" else np.zeros(0)
        is_speed = is_load(key) and key.endswith(".rotor_speed")
        if (is_speed or (is_load(key) and key.endswith(".frequency"))) and positive.size:
            low, high = float(positive.min()), float(positive.max())
            value = np.quantile(positive, 0.5, method="lower")
            if low < high:
                mode, unit = key.split(".")[1], units.per_frequency
                if is_speed:
                    unit = RPM * (get(samples.content, f"forcing.{mode}.engine_order") or 1)
                frequencies[mode] = unit * low, unit * high
        elif positive.size and (is_limit(key) or (is_load(key) and not key.endswith(".phase"))):
            value = float(np.sqrt(positive.min() * positive.max()))
        row.append(value.item() if isinstance(value, np.generic) else value)
    own = [
        get(samples.content, key) if is_load(key) else value
        for key, value in zip(design.keys, row, strict=True)
    ]
    rows = [row] if None in own else [row, own]
    return [samples.content_with(design.keys, values) for values in rows], frequencies


def without_loads(content: Content) -> Content:
    """Return a scene without the loads: all that its model depends on."""
    kept = {name: part for name, part in content.items() if name != "limits"}
    forcing = content.get("forcing")
    if isinstance(forcing, dict):
        kept["forcing"] = {
            mode: {key: v for key, v in table.items() if not is_load(f"forcing.{mode}.{key}")}
            for mode, table in forcing.items()
            if isinstance(table, dict)
        }
    return kept


def _combinations(plan: ModesPlan, frequencies: Frequencies) -> tuple[CombinationResonance, ...]:
    """Return combination resonances anywhere between the samples' frequencies.

    A harmonic is as close to a carrier as at a corner of these ranges, or passes it between two.
    """
    modes = plan.excited.modes
    if len(modes) < 2:
        return ()
    means = plan.schedule.mean_frequency(modes)
    ends = [frequencies.get(m, (mean, mean)) for m, mean in zip(modes, means, strict=True)]
    corners = np.array([(a, b) for a in ends[0] for b in ends[1]])
    first, second = np.array(list(pairs_of(range(4), 2))).T
    reduced = plan.excited.reduced
    return combinations_along(reduced, corners[first], corners[second], transient=True)


_last_built: list[tuple[Source, Structure]] = []


def _built(scene: Scene) -> Structure | None:
    """Return the structure of a scene, the same object as before if the section is equal.

    The structure keeps its modes, and consecutive scenes of a study often have the same one.
    """
    if scene.structure is None or scene.disk is not None:
        return None
    if not (_last_built and _last_built[0][0] == scene.structure):
        _last_built[:] = [(scene.structure, scene.build())]
    return _last_built[0][1]
