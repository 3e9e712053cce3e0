"""What the modes of a plan move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom import Structure
from slipmode.runner.plan.plan import Plan
from slipmode.runner.plan.shared_tone import SharedTonePlan
from slipmode.runner.recording.channels import Moved


def moved_by(plan: Plan | SharedTonePlan) -> dict[str, Moved]:
    """Return the DOF that each mode moves most, by mode; views show its displacement."""
    reduced, known = plan.excited.reduced, tuple[float, ...]()
    structure: Structure | None
    names: Sequence[str]
    if isinstance(plan, Plan):
        structure, names, known = plan.known_structure, plan.excited.modes, plan.amplitude
    else:
        structure, names = plan.structure, reduced.mode_names
    shapes, contacts = np.abs(reduced.mode_shapes), np.zeros((1, len(names)))
    if structure is not None:
        contacts = np.abs(np.asarray(structure.directions.T @ reduced.mode_shapes))
        if structure.labels is not None:  # rotations are no displacements
            shapes[structure.labels.direction > 3] = 0.0
    largest = [*known, *np.zeros(len(names))]
    columns = zip(names, shapes.T, contacts.T, largest, strict=False)
    return {name: Moved(x.max(), int(x.argmax()), c.max(), a) for name, x, c, a in columns}
