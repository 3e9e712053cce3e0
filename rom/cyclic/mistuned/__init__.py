"""Disks whose blades differ: all nodal diameters respond at one frequency.

mistuned_disk.py     MistunedDisk, responses of many patterns. Start here.
patterns.py          deviations of blades, random or measured
amplification.py     statistics of many patterns
disk_modes.py        modes of the tuned disk and of disks whose blades differ
disk_flow.py         amplitudes in time, step by step; stuck_modes.py: their modes
disk_balance.py      steady states by Newton's method
local_contacts.py    what each contact does by itself
internal_resonance.py harmonics that come close to modes
coupled_contacts.py  all contacts together, at the higher harmonics too
"""
