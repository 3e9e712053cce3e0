"""The face for browsers (fmu/src/faces/browser/) compiled for this machine: no zig, no browser."""

import ctypes
import shutil
from ctypes import c_double, c_int, c_size_t, c_void_p

import numpy as np
import pytest
from native import WARNINGS, compile_all, run

from slipmode.fmu.archive.binaries import INCLUDE_FOLDERS
from slipmode.fmu.archive.browser import browser_sources
from slipmode.fmu.archive.zig import FACE_OPTIONS

MOST_ROWS = 4000

_TYPES = {  # result and arguments after the instance
    "browser_message": (ctypes.c_char_p, ()),
    "browser_clear_message": (None, ()),
    "browser_is_open": (c_int, ()),
    "browser_output_count": (c_size_t, ()),
    "browser_get": (c_int, (c_void_p, c_size_t, c_void_p)),
    "browser_set": (c_int, (c_void_p, c_size_t, c_void_p)),
    "browser_play": (c_size_t, (c_double, c_size_t, c_void_p, c_size_t, c_void_p)),
    "browser_perturb": (c_int, (c_double,)),
    "browser_beat": (c_size_t, (c_size_t, c_size_t, c_void_p)),
    "browser_curve": (c_size_t, (c_int, c_double, c_double, c_size_t, c_void_p)),
}


class BrowserCore:
    """An instance of a model, as page/core.js has it; variables by name."""

    def __init__(self, library, files, variables):
        library.browser_open.restype, library.browser_open.argtypes = (
            c_void_p,
            (ctypes.c_char_p, c_size_t),
        )
        for name, (result, arguments) in _TYPES.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, (c_void_p, *arguments)
        self._library = library
        self._references = {v.name: k for k, v in enumerate(variables)}
        self._instance = library.browser_open(files, len(files))

    def call(self, name, *arguments):
        return getattr(self._library, f"browser_{name}")(self._instance, *arguments)

    @property
    def is_open(self):
        return bool(self.call("is_open"))

    def message(self):
        said = self.call("message").decode()
        self.call("clear_message")
        return said

    def _of(self, names):
        return np.array([self._references[name] for name in names], dtype=np.uint32)

    def get(self, *names):
        references, values = self._of(names), np.empty(len(names))
        assert self.call("get", references.ctypes.data, len(names), values.ctypes.data)
        return values

    def set(self, **inputs):
        references, values = self._of(inputs), np.array(list(inputs.values()))
        return bool(self.call("set", references.ctypes.data, len(inputs), values.ctypes.data))

    def play(self, duration, steps, *names):
        references, rows = self._of(names), np.empty((steps, len(names)))
        at = references.ctypes.data, len(names), rows.ctypes.data
        return rows[: self.call("play", duration, steps, *at)]

    def perturb(self, part):
        return bool(self.call("perturb", part))

    def beat(self, per_cycle):
        rows = np.empty((MOST_ROWS, self.call("output_count")))
        return rows[: self.call("beat", per_cycle, MOST_ROWS, rows.ctypes.data)]

    def curve(self, mode, span, modes=2):
        rows = np.empty((MOST_ROWS, modes + 3))
        return rows[: self.call("curve", mode, *span, MOST_ROWS, rows.ctypes.data)]


@pytest.fixture(scope="session")
def browser_library(request, tmp_path_factory):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler (cc)")
    cache = getattr(request.config, "cache", None)
    folder = tmp_path_factory.mktemp("browser")
    kept = cache.mkdir("browser") if cache else folder
    flags = (*WARNINGS, "-O1", "-fPIC", *(f"-I{each}" for each in INCLUDE_FOLDERS))
    own = {True: FACE_OPTIONS, False: ()}
    commands = {
        source: (*flags, *own[source.is_relative_to(INCLUDE_FOLDERS[0])])
        for source in browser_sources().values()
        if source.suffix == ".c"
    }
    objects = compile_all(compiler, kept, commands)
    library = folder / "browser.so"
    linked = run(compiler, "-shared", *objects.values(), "-lm", "-o", library)
    assert linked.returncode == 0, linked.stderr
    return ctypes.CDLL(str(library))
