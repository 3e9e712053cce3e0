"""Names of physical units as people write them in files and options."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from functools import lru_cache
from math import pi
from typing import NamedTuple

STANDARD_GRAVITY = 9.80665  # [m/s^2], of accelerometers in g
# Exponents of the base units of each quantity.
_QUANTITIES = {
    "displacement": {"m": 1},
    "velocity": {"m": 1, "s": -1},
    "acceleration": {"m": 1, "s": -2},
    "force": {"N": 1},
    "angle": {"rad": 1},
    "frequency": {"rad": 1, "s": -1},
    "time": {"s": 1},
}
# Size in SI units, quantity and prefixes of each symbol.
_SYMBOLS = {
    "m": (1.0, "displacement", "numck"),
    "in": (0.0254, "displacement", ""),
    "ft": (0.3048, "displacement", ""),
    "s": (1.0, "time", "num"),
    "min": (60.0, "time", ""),
    "h": (3600.0, "time", ""),
    "g": (STANDARD_GRAVITY, "acceleration", "um"),
    "N": (1.0, "force", "umkM"),
    "lbf": (4.4482216152605, "force", ""),
    "rad": (1.0, "angle", "um"),
    "deg": (pi / 180.0, "angle", ""),
    "Hz": (2.0 * pi, "frequency", "kM"),
    "rpm": (pi / 30.0, "frequency", ""),
}
_PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6}
# Symbols of quantities that nothing here reads are their own base units.
_UNITS = {
    f"{prefix}{name}": (1.0, {name: 1})
    for name, prefixes in {"V": "um", "A": "m", "Pa": "kM", "W": "k", "kg": "", "%": ""}.items()
    for prefix in ("", *prefixes)
}
for _name, (_size, _quantity, _prefixes) in _SYMBOLS.items():
    _UNITS[_name] = (_size, _QUANTITIES[_quantity])
    for _prefix in _prefixes:
        _UNITS[_prefix + _name] = (_PREFIXES[_prefix] * _size, _QUANTITIES[_quantity])
_WORDS = {
    "°": "deg", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad",
    "hertz": "Hz", "newton": "N", "newtons": "N", "meter": "m", "meters": "m", "metre": "m",
    "metres": "m", "inch": "in", "inches": "in", "sec": "s", "second": "s", "seconds": "s",
    "sekunde": "s", "sekunden": "s", "msec": "ms", "millisecond": "ms", "milliseconds": "ms",
    "usec": "us", "microsecond": "us", "microseconds": "us", "micron": "um", "microns": "um",
    "gn": "g", "g_n": "g", "volt": "V", "volts": "V", "1/min": "rpm",
}  # fmt: skip
# By lower case, of which the first one stays: "mn" is mN.
_LOWER = {name.lower(): name for name in reversed(_UNITS)} | _WORDS


class Unit(NamedTuple):
    """A unit: its usual spelling, what it measures ("" for other quantities), its size in SI."""

    name: str
    quantity: str
    size: float


@lru_cache
def parse_unit(text: str) -> Unit | None:
    """Return the unit that a text names, None if it names none.

    Superscripts, "m/s2", "m s^-2", spaces, brackets, any case, and words such as "sec" are
    allowed.
    """
    # NFKC makes superscripts digits, and the micro sign the Greek letter.
    plain = unicodedata.normalize("NFKC", text).replace("μ", "u").replace("−", "-")
    plain = re.sub(r"\bper\b", "/", plain.replace("**", "^"))
    plain = re.sub(r"[\s()\[\]{}<>$·⋅*]+", " ", plain).strip()
    plain = re.sub(r"\s*([\^/])\s*", r"\1", plain)
    powers = Counter[str]()
    for k, part in enumerate([plain] if plain.lower() in _WORDS else plain.split("/")):
        for word in part.split():
            split = re.fullmatch(r"(\d/\D+|\D+?)\^?([-+]?\d+)?", word)
            symbol = split and (split[1] if split[1] in _UNITS else _LOWER.get(split[1].lower()))
            if not split or not symbol:
                return None
            power = int(split[2] or 1)
            if symbol == "ms" and power < 0:  # m s^-2 without a space
                powers["m"] += 1
                symbol = "s"
            powers[symbol] += -power if k else power
    base = Counter[str]()
    size = 1.0
    for symbol, power in powers.items():
        size *= _UNITS[symbol][0] ** power
        for name, own in _UNITS[symbol][1].items():
            base[name] += own * power
    exponents = {name: power for name, power in base.items() if power}
    if not exponents:
        return None
    quantity = next((key for key, own in _QUANTITIES.items() if own == exponents), "")
    above = " ".join(_raised(symbol, power) for symbol, power in powers.items() if power > 0)
    below = "".join(f"/{_raised(symbol, -power)}" for symbol, power in powers.items() if power < 0)
    return Unit((above or "1") + below, quantity, size)


def _raised(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}^{power}"
