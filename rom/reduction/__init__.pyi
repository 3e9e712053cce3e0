"""Names of slipmode.rom.reduction for other rooms, each imported when it is first used."""

from .combination import CARRIERS as CARRIERS
from .combination import Order as Order
from .combination import harmonic_orders as harmonic_orders
from .interaction.internal_resonance import InternalResonance as InternalResonance
from .interaction.internal_resonance import harmonic_decay as harmonic_decay
from .interaction.internal_resonance import harmonic_gain as harmonic_gain
from .modes_alone import modes_alone as modes_alone
from .nonresonant import HIGHEST_HARMONIC as HIGHEST_HARMONIC
from .nonresonant import MOST_MODES as MOST_MODES
from .nonresonant import STATIC_FROM as STATIC_FROM
