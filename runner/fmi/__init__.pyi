"""Names of slipmode.runner.fmi for other rooms, each imported when it is first used."""

from .export import largest_forces as largest_forces
