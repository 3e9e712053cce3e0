"""Names of slipmode.rom.identification for other rooms, each imported when it is first used."""

from .first_look import demodulate as demodulate
from .models.sensor_units import sensor_unit as sensor_unit
from .models.sensor_units import shape_at_sensor as shape_at_sensor
from .sine.levels import complex_rate as complex_rate
from .sine.responses import ORDERS as ORDERS
from .slow_laws import LAWS as LAWS
