"""Public names of slipmode.fmu, each imported from its module when it is first used."""

from .archive.export import export as export
from .component import Component as Component
from .stepping import Steppable as Steppable
from .stepping import StoppedError as StoppedError

__version__: str
