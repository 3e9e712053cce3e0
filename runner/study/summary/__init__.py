"""What a study comes to, from its results.

summary.py       all of it, in lines and files
choice.py        the value of a key for which an output is least
sensitivity.py   how much of an output's variance each key explains
picture.py       outputs against what varies; recording.py: the same in Rerun
"""
