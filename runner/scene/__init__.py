"""Scenes: TOML files with a structure, its friction, and scripted forces."""
