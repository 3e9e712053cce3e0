"""Names of slipmode.rom.rotor for other rooms, each imported when it is first used."""

from .reduction import reduce_rotating as reduce_rotating
from .rotating import RotatingStructure as RotatingStructure
from .speed_modes import SpeedModes as SpeedModes
