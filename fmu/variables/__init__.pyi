"""Names of slipmode.fmu.variables for other rooms, each imported when it is first used."""

from .listing import list_variables as list_variables
from .variable import Variable as Variable
