"""What the answers cost that engineers ask for, beside others: make bench-study, bench-curves.

studies.py    studies on a cluster: what a second worker, a task, and many samples cost
curves.py     response curves beside harmonic balance with continuation
"""
