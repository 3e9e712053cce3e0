"""From matrices to modes and a contact problem: the reference modes, residual flexibility,
the modes that respond off resonance, and what the forces do past their own mode.
"""
