"""Names of slipmode.runner.plan for other rooms, each imported when it is first used."""

from .plan import ModesPlan as ModesPlan
