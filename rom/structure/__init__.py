"""Structures: mass, damping and stiffness with contacts, Eq. (1), checked and partitioned."""
