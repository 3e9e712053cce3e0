"""A scene compared with full order: `slipmode validate`.

validate.py    both motions and their difference. Start here.
reference.py   the motion at full order, and how accurate it is
"""
