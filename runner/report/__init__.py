"""Speed against error, measured here and now: slipmode beside what else could be used.

found = report("logs")          # several minutes; quick=True for a look
print(found.text())

tasks.py       what is measured, in which order. Start here; assemble.py: the whole report.
cases/         on which structures; methods/: how; peers/: against whom; scope.py: how much
hard/          the hard cases; text.py, picture.py: what comes out
"""

from slipmode.runner.report.assemble import Report, report

__all__ = ["Report", "report"]
