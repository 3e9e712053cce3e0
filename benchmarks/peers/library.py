"""The peers that are written in C, compiled at first use."""

from __future__ import annotations

import ctypes
import os
import subprocess
from functools import cache
from pathlib import Path

from slipmode.rom import SlipmodeError, kernel

_HERE = Path(__file__).parent
_ROOT = _HERE.parents[1]
_FLAGS = (  # as in CMakeLists.txt
    *("-std=c99", "-O3", "-shared", "-fPIC", "-fvisibility=hidden"),
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"),
)
# What CMakeLists.txt adds where the compiler has it; the first that compiles is taken.
_OPTIONAL = (
    ("-fopenmp-simd", "-DSM_OPENMP_SIMD", "-DSM_CLONES"),
    ("-fopenmp-simd", "-DSM_OPENMP_SIMD"),
    (),
)


@cache
def library() -> ctypes.CDLL:
    """Return the compiled peers.

    They are linked with the archive of the core that the build of slipmode leaves in build/, so
    that both sides of a comparison are compiled alike. `CC` names another compiler than cc.
    """
    archives = sorted(_ROOT.glob("build/*/libarchive.a"), key=lambda path: path.stat().st_mtime)
    if not archives:
        raise SlipmodeError(f"no libarchive.a in {_ROOT / 'build'}: run make .venv/.installed")
    sources = sorted(_HERE.glob("*.c"))
    target = _ROOT / "build" / "benchmarks" / "peers.so"
    newest = max(path.stat().st_mtime for path in (archives[-1], *sources))
    if not target.exists() or target.stat().st_mtime < newest:
        _compile(sources, archives[-1], target)
    loaded = ctypes.CDLL(str(target))
    _declare(loaded)
    return loaded


def _compile(sources: list[Path], archive: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    made = target.with_suffix(f".{os.getpid()}")  # tests compile side by side
    compiler, include = os.environ.get("CC", "cc"), f"-I{_ROOT / 'rom' / 'kernel'}"
    for optional in _OPTIONAL:
        command = (compiler, *_FLAGS, *optional, include, *sources, archive, "-lm", "-o", made)
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except FileNotFoundError:
            raise SlipmodeError(f"no C compiler {compiler}: install one, or set CC") from None
        if done.returncode == 0:
            made.replace(target)
            return
    raise SlipmodeError(f"{compiler} does not compile {_HERE}:\n{done.stderr}")


def _declare(loaded: ctypes.CDLL) -> None:
    contact, pointer = ctypes.POINTER(kernel.Contact), ctypes.c_void_p
    integer, number, count = ctypes.c_int32, ctypes.c_double, ctypes.c_size_t
    loaded.peer_paper_scheme.argtypes = [
        *(contact, pointer, integer, integer, integer, count, pointer, pointer)
    ]
    loaded.peer_bare_contacts.argtypes = [
        *(contact, number, integer, integer, integer, pointer, pointer, pointer, pointer)
    ]
    loaded.peer_newmark.argtypes = [pointer, count, count, pointer]
    loaded.peer_first_order_rate.argtypes = [pointer, number, pointer, pointer]
    loaded.peer_first_order_jacobian.argtypes = [pointer, pointer, pointer]
    for returns_nothing in (loaded.peer_first_order_rate, loaded.peer_first_order_jacobian):
        returns_nothing.restype = None
