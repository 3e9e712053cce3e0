"""The variables of an FMU: one list, from which everything else about them is derived.

listing.py      variables of a model, in their order, and what they depend on. Start here.
variable.py     Variable: kind and slot say where fmu/src/instance/variables.c finds its value
"""
