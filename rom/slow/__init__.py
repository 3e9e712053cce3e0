"""Slow time: the amplitude equations, their steady states, and the fast motion with them.

Start with slow_flow.py: Eqs. (18), (19), which the core evaluates. steady.py solves them at rest,
Eqs. (22)-(25), in a table, by steady_problem.py, and steady_points.py under many loads at once;
direct/ one of them without a table; branches/ follows them, limit_cycle.py finds those of modes
that excite themselves. trajectory.py holds what a run did;
motion.py makes contact and elastic motion, Eqs. (12), (14), of it, with the response of the modes
that nonresonant/ computes. units.py: Hz and micrometres for pictures and tables.
"""
