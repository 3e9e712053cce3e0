"""Fast motion of a run: what it is reconstructed from, and what of it is recorded.

record.py        slow channels, contact motion and contact states. Start here.
trajectory.py    the slow trajectory; motion over the phases of both carriers
"""
