"""A hash of the code of slipmode, for results on disk: between releases the version stays."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from slipmode.rom import kernel


@cache
def code_digest(*packages: str) -> str:
    """Return a hash of the Python sources of packages, "slipmode.rom", and of the kernel."""
    found = hashlib.sha256(Path(kernel.lib._name).read_bytes())
    for package in packages:
        spec = find_spec(package)
        assert spec is not None and spec.origin is not None
        folder = Path(spec.origin).parent
        for file in sorted(folder.rglob("*.py")):
            content = file.read_bytes()
            found.update(f"{file.relative_to(folder).as_posix()} {len(content)} ".encode())
            found.update(content)
    return found.hexdigest()
