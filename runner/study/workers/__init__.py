"""Work on the samples of a study.

foreman.py    batches of samples by model, and the tables that they share. Start here
processes.py  workers on this machine
cluster.py    workers of a Dask scheduler
"""
