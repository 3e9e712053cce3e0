"""Recordings of other programs.

messages.py finds the numbers in JSON and protobuf messages, recording.py makes channels of them.
"""
