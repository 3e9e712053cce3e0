"""All hard cases, in the order of the table."""

from __future__ import annotations

from slipmode.runner.report.hard.cases.changes import change_cases
from slipmode.runner.report.hard.cases.contacts import contact_cases
from slipmode.runner.report.hard.cases.growth import growth_cases
from slipmode.runner.report.hard.cases.levels import level_cases
from slipmode.runner.report.hard.cases.ratios import ratio_cases
from slipmode.runner.report.hard.cases.sharpness import sharpness_cases
from slipmode.runner.report.hard.cases.stepping import stepping_cases
from slipmode.runner.report.hard.cases.units import unit_cases

CASES = (
    *sharpness_cases(),
    *level_cases(),
    *contact_cases(),
    *growth_cases(),
    *ratio_cases(),
    *change_cases(),
    *stepping_cases(),
    *unit_cases(),
)
