"""Hard cases: each meets its bound or is refused with the reason; both laws meet in the limit."""

import numpy as np
import pytest

import rom
from rom.torus import Discretisation, friction_functions
from runner.report.hard import CASES, hard_report
from runner.report.hard.others import attempts


def parameters():
    for case in CASES:
        marks = [pytest.mark.slow] if case.slow else []
        if case.missed:
            marks.append(pytest.mark.xfail(reason=case.missed, strict=True))
        yield pytest.param(case, id=case.name, marks=marks)


@pytest.mark.parametrize("case", parameters())
def test_bound(case):
    outcome = case.judge()
    assert outcome.as_it_must, f"{outcome.measured:.3g} > {case.bound:g} {outcome.reason}"


def test_names_are_unique():
    assert len({case.name for case in CASES}) == len(CASES)
