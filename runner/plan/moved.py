"""What the modes of a plan move."""

from __future__ import annotations

import numpy as np

from slipmode.rom import Reduced
from slipmode.rom.arrays import Floats
from slipmode.runner.plan.plan import Plan
from slipmode.runner.plan.shared_tone import SharedTonePlan
from slipmode.runner.recording.channels import Moved


def displacement_shapes(reduced: Reduced) -> Floats:
    """Return |mode_shapes| (n_dofs, modes) [kg^-1/2], 0 for rotations."""
    shapes, structure = np.abs(reduced.mode_shapes), reduced.structure
    if structure is not None and structure.labels is not None:
        shapes[structure.labels.direction > 3] = 0.0
    return shapes


def moved_by(plan: Plan | SharedTonePlan) -> dict[str, Moved]:
    """Return the DOF that each mode moves most, by mode; views show its displacement."""
    reduced, names = plan.excited.reduced, plan.excited.mode_names
    largest = np.zeros(len(names))
    if isinstance(plan, Plan):
        largest = np.array(plan.amplitude or largest)
    contacts = np.zeros((1, len(names)))
    if reduced.structure is not None:
        contacts = np.abs(np.asarray(reduced.structure.directions.T @ reduced.mode_shapes))
    columns = zip(names, displacement_shapes(reduced).T, contacts.T, largest, strict=True)
    return {name: Moved(x.max(), int(x.argmax()), c.max(), a) for name, x, c, a in columns}
