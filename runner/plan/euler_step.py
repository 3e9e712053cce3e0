"""A step that the simplest integrator of an importer can take."""

from __future__ import annotations

from itertools import product
from math import ceil

import numpy as np

from slipmode.rom import Model
from slipmode.rom.slow.slow_flow import inputs_of, rate_and_jacobian, slow_flow
from slipmode.runner.plan.plan import Plan

_SHARE = 0.05  # of the decay of free vibrations that explicit Euler may leave out
_LEAST_DAMPED = 0.01  # Re / |.| of an eigenvalue, below which no decay is followed


def euler_step(plan: Plan, model: Model) -> float:
    """The scene's step, or a whole part of it, with which explicit Euler follows the amplitudes.

    A step h of explicit Euler takes h |lambda|^2 / 2 off the decay -Re lambda of a free vibration
    with eigenvalue lambda of the slow flow. It stays below 5 % of it at all nodes of the friction
    table, under the least, middle and largest frequencies of the scene.
    """
    modes = plan.excited.modes
    flow = slow_flow(model, plan.excited.force_patterns)
    nodes = [model.table.node_a, model.table.node_b][: model.modes]
    points = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, model.modes)
    least, most = plan.schedule.extremes([f"frequency_{mode}" for mode in modes])
    longest = plan.scene.run.step
    for frequency in product(*zip(least, 0.5 * (least + most), most, strict=True)):
        inputs = inputs_of(np.zeros(points.shape, complex), np.tile(frequency, (len(points), 1)))
        _, jacobian = rate_and_jacobian(flow, inputs, points.astype(complex))
        eigenvalue = np.linalg.eigvals(jacobian[np.isfinite(jacobian).all(axis=(1, 2))])
        size = np.abs(eigenvalue)
        decay = np.maximum(np.abs(eigenvalue.real), _LEAST_DAMPED * size)
        longest = min(longest, float(np.min(2.0 * _SHARE * decay / size**2)))
    return plan.scene.run.step / ceil(plan.scene.run.step / longest * (1.0 - 1e-9))
