"""What the method assumes, checked once for everything that computes.

assumptions.py     what a model, a motion or a force strains, as findings. Start here.
friction.py        whether friction limits are plausible at the amplitudes reached
../frequencies.py  which frequencies are refused, and which are implausible; reduce needs it too
"""

from slipmode.rom.errors import Finding, Level, warn
from slipmode.rom.frequencies import (
    FARTHEST_FORCING,
    HIGHEST_CARRIER,
    LOWEST_CARRIER,
    can_carry,
    carrier_findings,
    carrier_range,
    carrier_refusal,
    check_carrier,
    check_table_carriers,
    is_near,
    mode_frequency_findings,
)
from slipmode.rom.validity.assumptions import (
    carriers_meet,
    check_carriers,
    check_carriers_along,
    contact_findings,
    detuning_findings,
    direction_findings,
    force_findings,
    forcing_findings,
    meeting_refusal,
    model_findings,
    separation_findings,
    share_findings,
)
from slipmode.rom.validity.friction import friction_findings, frictionless_findings

__all__ = [
    "FARTHEST_FORCING",
    "HIGHEST_CARRIER",
    "LOWEST_CARRIER",
    "Finding",
    "Level",
    "can_carry",
    "carrier_findings",
    "carrier_range",
    "carrier_refusal",
    "carriers_meet",
    "check_carrier",
    "check_carriers",
    "check_carriers_along",
    "check_table_carriers",
    "contact_findings",
    "detuning_findings",
    "direction_findings",
    "force_findings",
    "forcing_findings",
    "friction_findings",
    "frictionless_findings",
    "is_near",
    "meeting_refusal",
    "mode_frequency_findings",
    "model_findings",
    "separation_findings",
    "share_findings",
    "warn",
]
