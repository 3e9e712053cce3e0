"""The findings of a study, from its results.

summary.py       all of it, in lines and files
choice.py        the value of a key for which an output is least
sensitivity.py   the share of an output's variance due to each key
charts.py        outputs against what varies, as a picture and for Rerun
"""
