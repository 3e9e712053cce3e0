"""Speed against error, measured here and now: slipmode beside what else could be used.

found = report("logs")          # several minutes; quick=True for a look
print(found.text())
"""

from slipmode.runner.report.assemble import Report, report

__all__ = ["Report", "report"]
