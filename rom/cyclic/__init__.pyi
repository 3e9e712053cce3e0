"""Names of slipmode.rom.cyclic for other rooms, each imported when it is first used."""

from .mistuned.internal_resonance import resonance_findings as resonance_findings
from .wave.wave_motion import SectorWaves as SectorWaves
from .wave.wave_motion import phase_factor as phase_factor
from .wave.wave_problem import Carrier as Carrier
from .wave.wave_table import cached_waves as cached_waves
from .wave.wave_table import reduced_waves as reduced_waves
