"""Files kept on disk, per user, to be found again: tables, reductions, compiled libraries.

All of them together stay within a bound; those that were not used for longest go first.
"""

from __future__ import annotations

import logging
import os
import re
import time
from collections.abc import Callable
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import TypeVar

import platformdirs

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.storage.files import PART

MIB = 1024 * 1024

_ENTRY = re.compile(r"[0-9a-f]{32}\.[a-z]+")  # in a folder that others may use too

_log = logging.getLogger("slipmode.cache")

Found = TypeVar("Found")


def folder() -> Path:
    """Where files are kept; the environment variable SLIPMODE_CACHE overrides the default."""
    override = os.environ.get("SLIPMODE_CACHE")
    return Path(override) if override else Path(platformdirs.user_cache_dir("slipmode"))


def bound() -> int:
    """Bytes that may be kept; SLIPMODE_CACHE_MIB overrides the default of 1024 MiB.

    Raises
    ------
    SlipmodeError
        If that variable is no number >= 0.
    """
    given = os.environ.get("SLIPMODE_CACHE_MIB") or 1024.0
    try:
        most = float(given)
    except ValueError:
        most = -1.0
    if not (isfinite(most) and most >= 0):
        raise SlipmodeError(f"SLIPMODE_CACHE_MIB: must be a number >= 0 [MiB], got {given}")
    return int(most * MIB)


def entries() -> dict[Path, int]:
    """Files that are kept and their sizes [bytes], those not used for longest first."""
    used = {}
    for path in _files(_ENTRY.fullmatch):
        with suppress(OSError):  # another process may have removed it
            found = path.stat()
            used[path] = (found.st_mtime_ns, found.st_size)
    return {path: size for path, (_, size) in sorted(used.items(), key=lambda item: item[1])}


def clear() -> None:
    """Remove all files that are kept.

    Raises
    ------
    OSError
        If one cannot be removed.
    """
    for path in entries():
        path.unlink(missing_ok=True)
    _remove_abandoned(0.0)


def find(name: str, load: Callable[[Path], Found]) -> Found | None:
    """What `load` reads from the file of a name; None if there is none, or it is damaged.

    `load` raises SlipmodeError for a damaged file. The next `keep` replaces that.
    """
    path = folder() / name
    try:
        found = load(path) if path.is_file() else None
    except (SlipmodeError, OSError) as error:
        _log.info("%s; it is computed again", error)
        return None
    with suppress(OSError):  # where it cannot be marked as used it will go a little earlier
        os.utime(path)
    return found


def keep(name: str, save: Callable[[Path], None]) -> None:
    """Have `save` write the file of a name; where it cannot, a line of the log says so.

    Raises
    ------
    SlipmodeError
        As `bound`.
    """
    most = bound()
    path = folder() / name
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save(path)
    except OSError as error:
        reason = error.strerror or error
        _log.warning("%s: cannot be stored (%s); the next run computes it again", path, reason)
        return
    # nobody finishes a file that has not changed for an hour
    _remove_abandoned(3600.0)
    _shrink(most)


def _shrink(most: int) -> None:
    kept = entries()
    total = sum(kept.values())
    for path, size in kept.items():
        if total <= most:
            return
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            _log.warning("%s: cannot be removed (%s)", path, error.strerror)
        else:
            total -= size


def _remove_abandoned(age: float) -> None:
    """Remove what a process that was killed has left unfinished."""
    for path in _files(lambda name: name.startswith(".slipmode-") and name.endswith(PART)):
        with suppress(OSError):
            if time.time() - path.stat().st_mtime >= age:
                path.unlink()


def _files(wanted: Callable[[str], object]) -> list[Path]:
    try:
        return [path for path in folder().iterdir() if wanted(path.name)]
    except OSError:
        return []
