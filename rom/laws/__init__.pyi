"""Names of slipmode.rom.laws for other rooms, each imported when it is first used."""

from .contacts import Elastic as Elastic
from .directions import contact_directions as contact_directions
from .friction import is_homogeneous as is_homogeneous
