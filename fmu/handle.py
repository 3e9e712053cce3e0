"""The core's component that steps a model."""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Sequence

from slipmode.rom import Model, kernel
from slipmode.rom.contact.torus.march import contact_problem
from slipmode.rom.reduction.force_response import ForcePatterns
from slipmode.rom.slow.nonresonant.response_surface import forces_out, response_surface
from slipmode.rom.slow.slow_flow import slow_flow

STEPS_PER_PERIOD = 40
MEMORY_PERIODS = 8.0


def create_component(
    model: Model,
    force_patterns: ForcePatterns | None,
    contact: bool,
    elastic: Sequence[int],
    tolerance: float,
) -> ctypes.c_void_p:
    """Return the core's component, which is freed with the handle."""
    motion = kernel.Motion(
        steps_per_period=STEPS_PER_PERIOD,
        memory_periods=MEMORY_PERIODS,
    )
    if contact:
        surface = response_surface(model, elastic)
        contacts_out = kernel.contiguous(model.reduced.contact_shapes[list(elastic)])
        motion.wanted, motion.elastic = 1, len(elastic)
        motion.modes_out = surface.modes_out.ctypes.data
        by_forces = forces_out(model, force_patterns, elastic)
        motion.forces_out = by_forces.ctypes.data
        motion.contacts_out = contacts_out.ctypes.data
        motion.orders_count = len(surface.orders)
        motion.orders = surface.orders.ctypes.data
        motion.reaction, motion.response = (
            surface.reaction.ctypes.data,
            surface.elastic.ctypes.data,
        )
    flow = slow_flow(model, force_patterns)
    problem = contact_problem(model.reduced, model.law)
    handle = ctypes.c_void_p()
    status = kernel.lib.sm_component_create(
        *(ctypes.byref(flow), ctypes.byref(problem), ctypes.byref(motion), tolerance),
        ctypes.byref(handle),
    )
    kernel.check(status, "component")
    weakref.finalize(handle, kernel.lib.sm_component_free, handle.value)
    return handle
