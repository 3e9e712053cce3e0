"""The methods that slipmode is compared with.

first_order.py    LSODA and CVODE on a compiled right-hand side
newmark.py        a hand-written Newmark loop for Jenkins contacts
hbm.py            harmonic balance
paper_scheme.py   the source paper's scheme, Eq. (31)
bare_contacts.py  a loop with nothing but the arithmetic of a friction table
library.py        compiles the C of these
"""
