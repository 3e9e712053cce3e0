"""Public names of slipmode.fmu, each imported from its module when it is first used."""

from .archive.export import export
from .component import Component
from .stepping import Steppable, StoppedError

__version__: str

__all__ = ["Component", "Steppable", "StoppedError", "__version__", "export"]
