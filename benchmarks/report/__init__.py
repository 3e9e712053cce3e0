"""Speed against error beside other methods: python -m benchmarks.report.

tasks.py      what is measured, and in which order
signals.py    signals from rest; steady.py: steady amplitudes; friction.py: friction functions
sections.py   rows and sections, and what they say of each other
text.py, picture.py   the output
"""
