"""What is computed of each sample of a study.

asked.py     what may be asked for, and the arrays that it fills
batch.py     a batch of samples on one model
steady.py    without time: steady states, resonance peaks, curves
runs.py      through slow time: peaks, amplitudes at given times, recordings
"""
