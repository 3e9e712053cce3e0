"""What is computed of each sample of a study.

outputs.py   the outputs of a study, and the arrays that hold them
batch.py     a batch of samples on one model
steady.py    without time: steady states, resonance peaks, curves
runs.py      through slow time: peaks, amplitudes at given times, recordings
"""
