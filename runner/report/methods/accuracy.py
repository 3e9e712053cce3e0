"""Accuracy on other structures: signals, contacts, energy and steady amplitudes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.cases.cases import Case
from slipmode.runner.report.measure import Row, Section
from slipmode.runner.report.methods.ours import SlowCase
from slipmode.runner.report.methods.signals import ERRORS as SIGNAL_ERRORS
from slipmode.runner.report.methods.signals import SLOW, Reference, full_rows, slow_row

ERRORS = (*SIGNAL_ERRORS, "steady amplitude")
_FLOW = (20.0, 1e-6)


def check(case: Case, tolerance: float, refinements: tuple[int, ...]) -> Section:
    """Ours, and the full order at several steps, on one structure."""
    reference = Reference.of(case)
    rows = [*_slow(reference, tolerance), *full_rows(reference, refinements)]
    padded = [replace(row, errors=(*row.errors, np.nan)[: len(ERRORS)]) for row in rows]
    return Section(
        key=case.name,
        title=case.name,
        task=f"{case.duration:g} s from rest",
        errors=ERRORS,
        reference_error=reference.error,
        rows=tuple(padded),
        ours=(0,),
    )


def _slow(reference: Reference, tolerance: float) -> Iterator[Row]:
    slow = SlowCase.tabulate(reference.case, tolerance)
    row = slow_row(reference, slow, slow.march(*_FLOW), SLOW, f"table {tolerance:g}")
    yield replace(row, errors=(*row.errors, _steady_error(slow)))


def _steady_error(slow: SlowCase) -> float:
    """Worst relative error of the modal amplitudes."""
    case, model = slow.case, slow.model
    to_modal = as_dense(case.structure.mass @ model.reduced.mode_shapes).T
    exact = full.steady_amplitude(
        *(case.structure, case.law, case.excitation), outputs=to_modal, tolerance=3e-5
    )
    found = rom.steady(model, case.frequency, case.force)
    return float(np.abs(found / np.diag(exact.amplitude) - 1.0).max())
