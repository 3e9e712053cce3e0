"""Cost of stepping an FMU: `python -m benchmarks.fmu.steps`."""
