"""Speed and accuracy of slipmode, measured beside other methods. Not installed with slipmode.

report/      speed against error: make report
paper/       figures and claims of the source paper: make paper
break_even.py, contact_solves.py   costs of friction tables: make bench-table
full_order.py, recordings.py, scale.py, curves.py, runner/   the other make bench-* targets
panel.py     responses of a panel predicted from its decays, with a picture
cases.py, blade.py   structures and forces
slow_case.py         slipmode on a case
peers/       the methods that slipmode is compared with
measure.py   times and errors
"""
