"""What `slipmode identify` writes of an identification.

files.py     model, scene, FMU, backbones and pictures. Start here.
pictures.py  backbones, decays, frequency responses
report.py    the report in words and numbers
loops.py     report, picture and scene tables of laws from loops
"""
