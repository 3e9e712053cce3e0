"""Stated errors of answers against true ones, from the independent solutions in oracles/."""
