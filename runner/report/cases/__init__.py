"""The structures and forces of the report.

cases.py has the cases by name, structures.py those structures that are not the paper's;
blade.py makes large ones for make bench-scale.
"""
