"""A model for a browser: the C core as WebAssembly, and the resource files that it reads."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from slipmode.fmu.archive.binaries import sources_without
from slipmode.fmu.archive.resources import identity, model_arrays, packed_files
from slipmode.fmu.archive.zig import Target, compiled
from slipmode.fmu.handle import ComponentOptions
from slipmode.fmu.variables.variable import Variable
from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.force_response import ForcePatterns

_STACK = 1 << 20  # bytes; the search for steady states takes 40 kB
_LINKING = ("-mexec-model=reactor", f"-Wl,-z,stack-size={_STACK}")
_TARGET = Target("wasm32-wasi", "explore", ("-msimd128",), _LINKING)

# Arrays of a model that fill most of a page: bits of their entries that are kept, below the
# largest entry along some axes. Amplitudes keep 1e-10 and contact forces 1e-8
# (tests/runner/explore/test_core.py).
_BITS = {
    "table": (40, (0, 1)),
    "rate_correction": (30, (0, 1)),
    "detuning": (30, (0, 1)),
    "contact_reaction": (28, (0, 1, 2, 3)),
    "elastic_response": (24, (0, 1, 2, 3)),
    "samples": (48, (0,)),
}


def browser_module() -> bytes:
    """Return the core with its face for JavaScript, as WebAssembly.

    Raises SlipmodeError if zig is not installed, or it fails.
    """
    return compiled(browser_sources(), _TARGET)


def browser_sources() -> dict[str, Path]:
    """Return the C sources and headers of the module by their names."""
    return sources_without("faces/fmi", "resources/location.c")


def browser_files(
    model: Model,
    force_patterns: ForcePatterns | None,
    options: ComponentOptions,
    variables: Sequence[Variable],
) -> bytes:
    """Return the resource files of a model in one block, as fmu/src/faces/browser/ reads them.

    Large arrays are rounded to bits that amplitudes and motion depend on. The bytes of the block
    are in eight planes, every eighth byte after the other: so it compresses to half its size.
    """
    arrays = model_arrays(model, force_patterns, options, variables)
    for name, (bits, axes) in _BITS.items():
        arrays[name] = _rounded(arrays[name], bits, axes)
    files = packed_files(arrays, variables, identity(model, force_patterns))
    block = b"".join(
        struct.pack("<56sQ", name.encode(), len(content)) + content + bytes(-len(content) % 64)
        for name, content in files.items()
    )
    return np.frombuffer(block, dtype=np.uint8).reshape(-1, 8).T.tobytes()


def _rounded(array: Floats, bits: int, axes: tuple[int, ...]) -> Floats:
    """Round to so many bits below the largest entry along the axes."""
    if not array.size:
        return array
    largest = np.abs(array).max(axis=axes, keepdims=True)
    unit = np.exp2(np.ceil(np.log2(np.where(largest > 0.0, largest, 1.0))) - bits)
    return np.asarray(np.round(array / unit) * unit)
