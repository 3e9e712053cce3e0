"""Work on the samples of a study.

foreman.py   batches of samples by model, and who computes them. Start here
cluster.py   processes on this machine, or workers of a Dask scheduler
"""
