"""Names of slipmode.rom.slow for other rooms, each imported when it is first used."""

from .branches.curve_result import axes_or_current as axes_or_current
from .branches.curve_result import axes_or_new as axes_or_new
from .branches.curve_result import label_point as label_point
from .branches.curve_result import plot_band as plot_band
from .motion import SPIN_UP_PERIODS as SPIN_UP_PERIODS
from .motion import prescribed_motion as prescribed_motion
from .tone.contact_balance import ContactBalance as ContactBalance
from .tone.coupled_contacts import CoupledContacts as CoupledContacts
from .tone.coupled_contacts import FastModes as FastModes
from .tone.tone_modes import ToneModes as ToneModes
from .units import SI as SI
from .units import Unit as Unit
from .units import parse_unit as parse_unit
