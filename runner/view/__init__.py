"""Recordings in Rerun: layout, curves, phase portraits, replay, live, pictures."""
