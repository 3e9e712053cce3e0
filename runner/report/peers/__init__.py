"""What slipmode is compared with, each in the strongest form at hand.

first_order.py    LSODA, CVODE on a compiled right-hand side; newmark.py: a hand-written loop
hbm.py            harmonic balance
paper_scheme.py   Eq. (31) in C; bare_contacts.py: a bare loop of a table's arithmetic
"""
