"""Names of slipmode.runner.view for other rooms, each imported when it is first used."""

from .labels import units_of as units_of
from .plots import PLOTS as PLOTS
