"""Assumptions of the method, checked for Python, scenes and FMUs alike.

assumptions.py     violations by a model, a motion or a force, as findings. Start here.
friction.py        whether friction limits are plausible at the amplitudes reached
../frequencies.py  limits of frequencies; `rom.reduce` needs them too
"""

from slipmode.rom.errors import Finding as Finding
from slipmode.rom.errors import warn as warn
from slipmode.rom.frequencies import can_carry as can_carry
from slipmode.rom.frequencies import carrier_findings as carrier_findings
from slipmode.rom.frequencies import carrier_range as carrier_range
from slipmode.rom.frequencies import carrier_refusal as carrier_refusal
from slipmode.rom.frequencies import check_carrier as check_carrier
from slipmode.rom.frequencies import check_table_carriers as check_table_carriers
from slipmode.rom.frequencies import is_near as is_near
from slipmode.rom.frequencies import mode_frequency_findings as mode_frequency_findings
from slipmode.rom.frequencies import spin_of as spin_of
from slipmode.rom.validity.assumptions import carriers_meet as carriers_meet
from slipmode.rom.validity.assumptions import check_carriers as check_carriers
from slipmode.rom.validity.assumptions import check_carriers_along as check_carriers_along
from slipmode.rom.validity.assumptions import contact_findings as contact_findings
from slipmode.rom.validity.assumptions import detuning_findings as detuning_findings
from slipmode.rom.validity.assumptions import direction_findings as direction_findings
from slipmode.rom.validity.assumptions import force_findings as force_findings
from slipmode.rom.validity.assumptions import forcing_findings as forcing_findings
from slipmode.rom.validity.assumptions import meeting_refusal as meeting_refusal
from slipmode.rom.validity.assumptions import model_findings as model_findings
from slipmode.rom.validity.assumptions import proposal_findings as proposal_findings
from slipmode.rom.validity.assumptions import (
    reference_frequency_finding as reference_frequency_finding,
)
from slipmode.rom.validity.assumptions import share_findings as share_findings
from slipmode.rom.validity.friction import friction_findings as friction_findings
from slipmode.rom.validity.friction import frictionless_findings as frictionless_findings
