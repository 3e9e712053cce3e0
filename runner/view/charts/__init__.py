"""Charts without time in Rerun: one quantity against another, of studies and curves.

chart.py     what is drawn in a chart
rrd_file.py  charts and texts as an .rrd file with its layout
"""
