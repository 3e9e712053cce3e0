"""Names of slipmode.fmu.description for other rooms, each imported when it is first used."""

from .options import ExportOptions as ExportOptions
