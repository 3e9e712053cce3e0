"""Names of slipmode.fmu.archive for other rooms, each imported when it is first used."""

from .browser import browser_files as browser_files
from .browser import browser_module as browser_module
