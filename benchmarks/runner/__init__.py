"""The runner: how long commands take to start, start.py, and studies on a cluster, studies.py."""
