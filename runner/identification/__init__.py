"""What `slipmode identify` writes of an identification.

files.py     model, scene, FMU, backbones and pictures. Start here.
report.py    the report in words and numbers
"""
