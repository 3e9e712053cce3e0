"""Hard cases: where friction, forcing or scaling strain a simulation, each with its bound.

found = hard_report()           # several minutes
print(found.text())

hard_case.py says what a case is, matrix.py lists them, cases/ holds them by what strains;
others.py lets other integrators try.
"""

from slipmode.runner.report.hard.assemble import HardReport, hard_report
from slipmode.runner.report.hard.matrix import CASES

__all__ = ["CASES", "HardReport", "hard_report"]
