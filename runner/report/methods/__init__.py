"""What the report measures of each method.

signals.py      whole signals from rest; steady.py: steady amplitudes; friction.py: Q_A, Q_B
accuracy.py     other structures; figures.py: single figures
ours.py         slipmode on a case; contact_solves.py, break_even.py: make bench-table;
                recordings.py: make bench-recordings; scale.py: make bench-scale;
                full_order.py: make bench-full
"""
