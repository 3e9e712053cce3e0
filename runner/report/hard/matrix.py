"""All hard cases, in the order of the table."""

from __future__ import annotations

from runner.report.hard.changes import change_cases
from runner.report.hard.contacts import contact_cases
from runner.report.hard.growth import growth_cases
from runner.report.hard.levels import level_cases
from runner.report.hard.ratios import ratio_cases
from runner.report.hard.sharpness import sharpness_cases
from runner.report.hard.stepping import stepping_cases
from runner.report.hard.units import unit_cases

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
