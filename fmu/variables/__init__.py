"""The variables of an FMU: one list, from which everything else about them is derived.

listing.py      variables of a model, in their order, and what they depend on. Start here.
variable.py     Variable: kind and slot say where fmu/src/instance/variables.c finds its value
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
