"""Names of slipmode.runner.plan for other rooms, each imported when it is first used."""

from .moved import moved_by as moved_by
