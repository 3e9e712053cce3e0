"""Writing the .fmu file.

export.py           export: a model as a zip archive. Start here.
resources.py        resources/*.npy, which fmu/src/resources/model.c reads
binaries.py         the host's library, those of other platforms, and the C sources
browser.py          the core as WebAssembly, and the resources as a page holds them
zig.py              the compiler for other machines
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
