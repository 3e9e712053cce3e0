"""How much memory there is."""

from __future__ import annotations

from pathlib import Path

from slipmode.rom.errors import SlipmodeError

GIB = 2.0**30


def check_memory(needed: float, purpose: str, advice: str = "") -> None:
    """Refuse work that needs more memory than there is, where the system tells.

    Parameters
    ----------
    needed : float
        [bytes]
    purpose : str
        Of the work: "factorising stiffness (100000 DOFs)".
    advice : str
        What would need less.
    """
    available = _available()
    if available is not None and needed > available:
        raise SlipmodeError(
            f"{purpose}: needs about {needed / GIB:.1f} GiB of memory, "
            f"{available / GIB:.1f} GiB are free{advice}"
        )


def _available() -> float | None:
    """Free memory [bytes], that of caches included; None where the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    entries = dict(line.split(":", 1) for line in lines)
    return float(entries["MemAvailable"].split()[0]) * 1024.0
