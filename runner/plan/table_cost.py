"""What a table of the whole plane would cost besides that of a scene's region, measured."""

from __future__ import annotations

import time

import numpy as np

from slipmode.rom import Model
from slipmode.rom.contact.friction_terms import contact_terms
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.table.refinement.refine import least_further
from slipmode.rom.table.region import corners, with_neighbours
from slipmode.rom.validity import Finding as Decision

_BATCH = 32  # nodes that are solved to be timed
_REPEATS = 2  # the least counts


def whole_table_cost(model: Model) -> Decision:
    """What a table of a tabulated region leaves unsolved, and the error it was found to have.

    The number of contact problems is a lower bound; the seconds, of one processor, are those that
    so many would take which are like nodes of the grid that were left out.
    """
    table, accuracy = model.table, model.accuracy
    assert table.region is not None
    left = np.argwhere(~with_neighbours(corners(table.region)))
    picked = left[np.linspace(0, len(left) - 1, _BATCH).astype(int)]
    amplitudes = np.column_stack((table.node_a[picked[:, 0]], table.node_b[picked[:, 1]]))
    each = min(_seconds(model, amplitudes) for _ in range(_REPEATS)) / _BATCH
    further = least_further(table)
    return Decision(
        "its tabulation",
        f"{accuracy.solved} contact problems",
        f"the whole table: at least {further} more, {further * each:.2g} s of a processor; "
        f"error found {accuracy.interpolation:.1g}, model.tolerance is {accuracy.tolerance:g}",
    )


def _seconds(model: Model, amplitudes: np.ndarray) -> float:
    """Processor time of the contact problems at amplitudes (points, 2), as in a tabulation."""
    accuracy = model.accuracy
    started = time.process_time()
    contact_terms(
        model.reduced,
        model.law,
        amplitudes,
        Discretisation(accuracy.steps, accuracy.lines),
        ErrorBudget(accuracy.tolerance).march,
        0.1 * model.table.amplitude_range,
        model.combinations,
    )
    return time.process_time() - started
