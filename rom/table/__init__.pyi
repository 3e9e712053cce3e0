"""Names of slipmode.rom.table for other rooms, each imported when it is first used."""

from .cache import model_from_cache as model_from_cache
from .dof_response import DofResponse as DofResponse
from .local.local_contacts import LocalContacts as LocalContacts
from .tabulation import tabulate_problem as tabulate_problem
