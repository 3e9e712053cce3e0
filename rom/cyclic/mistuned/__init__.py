"""Disks whose blades differ: all nodal diameters respond at one frequency.

mistuned_disk.py       MistunedDisk: steady states and transients of many patterns. Start here.
disk_response.py       blade amplitudes along frequencies or in time
patterns.py            deviations of blades, random or measured
amplification.py       statistics of many patterns
disk_modes.py          modes of the tuned disk and of disks whose blades differ
disk_balance.py        steady states by Newton's method
disk_flow.py           amplitudes in time, step by step; stuck_modes.py: their modes
local_contacts.py      what each contact does by itself
coupled_contacts.py    all contacts together, at the higher harmonics too
internal_resonance.py  harmonics that come close to modes
"""
