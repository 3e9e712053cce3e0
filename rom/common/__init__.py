"""What all rooms have in common, for packages on top of the core.

Array types, checks of arguments and refusals, findings, representations in one line, progress.
"""

from slipmode.rom.arrays import Complexes, Flags, Floats, as_complexes, as_floats, in_one_line
from slipmode.rom.errors import Finding, UnsettledError, naming, one_line_reason, warn
from slipmode.rom.extras import extra
from slipmode.rom.frequencies import RPM
from slipmode.rom.progress import progress_bar
from slipmode.rom.representable import ALLOWED, fits
from slipmode.rom.short_repr import frozen, percentage, short_list

__all__ = [
    "ALLOWED",
    "RPM",
    "Complexes",
    "Finding",
    "Flags",
    "Floats",
    "UnsettledError",
    "as_complexes",
    "as_floats",
    "extra",
    "fits",
    "frozen",
    "in_one_line",
    "naming",
    "one_line_reason",
    "percentage",
    "progress_bar",
    "short_list",
    "warn",
]
