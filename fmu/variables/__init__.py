"""The variables of an FMU: one list, from which everything else about them is derived.

listing.py      which variables a model has, in which order, what they depend on. Start here.
variable.py     Variable: its kind and slot tell fmu/src/instance/variables.c where its value is
quantities.py   declared types and units
"""
