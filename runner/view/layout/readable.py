"""Quantities as people write them: 174 µm, not 0.000174 m."""

from __future__ import annotations

import math

_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_WITH_PREFIX = ("m", "m/s", "N", "W", "J")  # not kg^0.5 m, whose prefix would not say of what
_LEAST = 0.1  # 0.25 m stays as it is


def readable(value: float, unit: str) -> str:
    """A value with its unit, to three digits.

    Parameters
    ----------
    value : float
        In `unit`.
    unit : str
        ``"m"``, ``"N"``, ``"rad/s"``.

    Returns
    -------
    str
        ``"174 µm"`` for 0.000174 and ``"m"``.
    """
    size = abs(value)
    if unit in _WITH_PREFIX and size > 0.0 and not _LEAST <= size < 1000.0:
        power = 3 * math.floor(math.log10(float(f"{size:.3g}")) / 3)
        power = min(max(power, min(_PREFIXES)), max(_PREFIXES))
        return f"{value / 10.0**power:.3g} {_PREFIXES[power]}{unit}"
    return f"{value:.3g} {unit}"
