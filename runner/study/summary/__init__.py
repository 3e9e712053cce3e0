"""The findings of a study, from its results.

summary.py         all of it, in lines and files
statistics.py      the best value of a key, and the share of the variance due to each key
amplifications.py  of mistuned disks: distribution, extreme values and Whitehead's bound
charts.py          outputs against what varies, as a picture and for Rerun
"""
