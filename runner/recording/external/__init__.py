"""Recordings of other programs."""
