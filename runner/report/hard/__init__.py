"""Hard cases: where friction, forcing or scaling strain a simulation, each with its bound.

found = hard_report()           # several minutes
print(found.text())
"""

from slipmode.runner.report.hard.assemble import HardReport, hard_report
from slipmode.runner.report.hard.matrix import CASES

__all__ = ["CASES", "HardReport", "hard_report"]
