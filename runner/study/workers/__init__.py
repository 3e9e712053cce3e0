"""Work on the samples of a study.

foreman.py   batches of samples by model, and who computes them. Start here
cluster.py   processes on this machine, or those of a Dask scheduler
"""
