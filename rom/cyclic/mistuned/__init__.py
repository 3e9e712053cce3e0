"""Disks whose blades differ: all nodal diameters respond at one frequency.

mistuned_disk.py       MistunedDisk: steady states and transients of many patterns. Start here.
disk_response.py       blade amplitudes along frequencies or in time
patterns.py            deviations of blades, random or measured
amplification.py       statistics of many patterns
disk_modes.py          modes of the tuned disk and of disks whose blades differ
script.py              inputs of transients
internal_resonance.py  harmonics that come close to modes

Steady states and transients are computed as many modes on one tone, slow/tone/.
"""
