"""Units: their names in files and options, in pictures and in tables of curves.

Curves hold values in rad/s and m.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import PER_UNIT, FrequencyUnit

if TYPE_CHECKING:
    from slipmode.rom.slow.steady_motion import SteadyMotion

LengthUnit = Literal["m", "mm", "um"]

_PER_LENGTH = {"m": 1.0, "mm": 1e-3, "um": 1e-6}
MODAL = "kg$^{1/2}$ m"

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


@dataclass(frozen=True)
class Units:
    """Choose the units of plots and tables.

    Attributes
    ----------
    frequency : {"rad/s", "Hz"}
        Unit of frequencies.
    displacement : {"m", "mm", "um"}
        Unit of displacements of DOFs. Modal amplitudes stay in kg^1/2 m.
    """

    frequency: FrequencyUnit = "rad/s"
    displacement: LengthUnit = "m"

    def __post_init__(self) -> None:
        for name, allowed in (("frequency", FrequencyUnit), ("displacement", LengthUnit)):
            unit = parse_unit(str(getattr(self, name)))
            if unit and unit.name in get_args(allowed):  # other spellings
                object.__setattr__(self, name, unit.name)
            else:
                raise SlipmodeError(
                    f"units.{name}: must be one of {', '.join(get_args(allowed))}, got "
                    f"{getattr(self, name)!r}"
                )

    @property
    def per_frequency(self) -> float:
        """The unit of frequencies in rad/s."""
        return PER_UNIT[self.frequency]

    @property
    def frequency_label(self) -> str:
        """Label of an axis of frequencies, for instance "frequency [Hz]"."""
        return f"frequency [{self.frequency}]"

    def of_frequency(self, omega: ArrayLike) -> Floats:
        """Return an angular frequency [rad/s] in these units."""
        return np.asarray(omega, dtype=float) / self.per_frequency

    def of_displacement(self, x: ArrayLike) -> Floats:
        """Return a displacement [m] in these units."""
        return np.asarray(x, dtype=float) / _PER_LENGTH[self.displacement]

    def named(self, name: str) -> str:
        """Return the name of a column of frequencies, with a unit other than rad/s."""
        return name if self.frequency == "rad/s" else f"{name} [{self.frequency}]"

    def frequencies(self, **omega: ArrayLike) -> dict[str, Floats]:
        """Return columns of angular frequencies [rad/s] by name, in these units."""
        return {self.named(name): self.of_frequency(values) for name, values in omega.items()}

    def of_dof(self, name: str, dof: int) -> str:
        """Return the name of a column of amplitudes of a DOF, with the unit."""
        return f"{name} at DOF {dof} [{self.displacement}]"


SI = Units()


@dataclass(frozen=True)
class Shown:
    """How pictures and tables show amplitudes: of modes or of a DOF, in which units."""

    dof: int | None = None
    units: Units = SI
    modal: str = MODAL  # the unit of modal amplitudes, as written

    def size(self, motion: SteadyMotion) -> Floats:
        """Return |a_j| of steady states, or the amplitude of the DOF at each carrier."""
        if self.dof is None:
            return np.abs(motion.amplitude)
        return self.units.of_displacement(motion.displacement(self.dof))

    @property
    def unit(self) -> str:
        """The unit of an amplitude."""
        return self.modal if self.dof is None else self.units.displacement

    def named(self, name: str) -> str:
        """Return the name of an amplitude with its unit."""
        return f"{name} [{self.modal}]" if self.dof is None else self.units.of_dof(name, self.dof)


MODAL_AMPLITUDES = Shown()
