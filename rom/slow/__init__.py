"""Slow time: the amplitude equations, their steady states, and the fast motion with them.

Start with slow_flow.py: Eqs. (18), (19), which the core evaluates. steady.py solves them at rest,
Eqs. (22)-(25), in a table; steady_state.py one of them without, by forced_balance.py,
or integrated.py where that finds none;
limit_cycle.py where a mode excites itself. trajectory.py holds what a run did;
motion.py makes contact and elastic motion, Eqs. (12), (14), of it, with the modal response of
response.py and response_surface.py.
"""
