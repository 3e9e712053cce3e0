"""Options of an FMU, and its descriptions.

options.py          ExportOptions
xml_files.py        modelDescription.xml in FMI 2.0 and 3.0, further files of FMI 3.0. Start here.
documentation.py, reference_result.py   documentation/ and extra/ of the archive; their static
                    parts are the files beside
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
