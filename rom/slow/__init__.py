"""Slow time: the amplitude equations, their steady states, and the fast motion with them.

Start with slow_flow.py: Eqs. (18), (19) as the core evaluates them. steady.py solves them at rest,
Eqs. (22)-(25). trajectory.py holds what a run did; motion.py makes contact and elastic motion of it,
Eqs. (12), (14), with the modal response of response.py and response_surface.py.
"""
