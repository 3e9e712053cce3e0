"""Results of samples whose disks are mistuned: steady states of all blades, without a table."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.runner.messages import one_line
from slipmode.runner.plan.blades import plan_blades
from slipmode.runner.scene.sections import Scene
from slipmode.runner.study.design import Design
from slipmode.runner.study.sample_outputs import Batch, Curve
from slipmode.runner.study.scene_model import Samples


def compute_mistuned(samples: Samples, design: Design) -> Batch:
    """Return the results of samples. Disks that differ in mistuning alone are solved together."""
    outputs = samples.outputs
    assert outputs.curve is not None  # `load_study` refuses other outputs
    batch = Batch.empty(outputs, samples.modes, design.samples)
    together: dict[str, list[tuple[int, Scene]]] = {}
    found = zip(samples.contents(design), samples.scenes(design), strict=True)
    for place, (content, scene) in enumerate(found):
        if isinstance(scene, str):
            batch.reason[place] = scene
            continue
        others = {name: part for name, part in content.items() if name != "mistuning"}
        together.setdefault(json.dumps(others), []).append((place, scene))
    for group in together.values():
        places, scenes = [place for place, _ in group], [scene for _, scene in group]
        try:
            values = _steady_states(outputs.curve, scenes)
        except SlipmodeError as refusal:
            batch.refuse(places, one_line(refusal))
            continue
        inside = np.zeros(len(places), dtype=bool)
        batch.add(places, [0], Batch(values, [""] * len(places), inside))
    return batch


def _steady_states(curve: Curve, scenes: Sequence[Scene]) -> dict[str, Floats]:
    """Return the results of scenes that differ in mistuning alone, each (samples, 1, ...)."""
    blades = plan_blades(scenes[0]).excited
    tuned = (0.0,) * blades.disk.structure.sectors
    disks = blades.disk.with_deviation([tuned, *(scene.mistuning for scene in scenes)])
    force = blades.force * scenes[0].forcing["A"].amplitude.value_before(scenes[0].run.duration)
    envelope = disks.envelope(curve.frequency, blades.engine_order, force, blades.dof)
    reference, *peaks = envelope.max(axis=1)
    values = {
        "curve": envelope[1:],
        "resonance": np.array(peaks),
        "resonance_frequency": curve.frequency[envelope[1:].argmax(axis=1)],
        "amplification": peaks / reference,
    }
    return {name: each[:, np.newaxis] for name, each in values.items()}
