"""Labels of views, whatever program draws them: titles, legends, units and explanations."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import floor, log10

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.slow.units import SI, Units
from slipmode.runner.recording.channels import (
    DISK,
    FULL,
    OTHER,
    PHASES,
    SHARE,
    TORUS,
    Channel,
    Field,
)

Color = tuple[int, int, int]
BLUE, ORANGE, GREEN, RED = (76, 159, 230), (240, 145, 60), (110, 190, 110), (224, 82, 82)
LINES = (BLUE, ORANGE, GREEN, (205, 110, 190), (200, 190, 90))  # of a plot
GREY, DARK = (145, 153, 165), (75, 80, 90)  # grey is readable on black and on white, as the others
LOOPS = 3  # hysteresis loops of the first contacts: more would be too small to read

# A plot is about 110 pixels high. Rerun labels the multiples of a power of ten that are at least
# 25 pixels apart.
_LABELLED = 4.4
_MARGIN = 1.05  # of a scale, relative to the largest value

SLOW_PLOTS = (  # topic, quantity, title
    ("/modes", "amplitude_A", "Modal amplitude |A|"),
    ("/modes", "amplitude_B", "Modal amplitude |B|"),
    ("/blades", "amplitude", "Blade amplitudes"),
    ("/forcing", "force", "Force amplitude"),
    ("/forcing", "frequency", "Forcing frequency"),
    ("/control", "scale", "Friction limit"),
    ("/energy", "power", "Power balance"),
    ("/energy", "energy", "Dissipated energy"),
)
MOTION_PLOTS = (
    ("/elastic", "displacement", "Elastic displacement"),
    ("/contact", "displacement", "Contact displacement"),
    ("/contact", "friction_force", "Friction force"),
    ("/contact", "normal_force", "Normal force"),
    ("/contact", "gap", "Gap"),
    ("/contact", "state", "0 stuck, 1 slipping, 2 open"),
)

# The last word of a field's name is its quantity; fields of one quantity share a plot.
_QUANTITIES = {"re": "components", "im": "components", "N": "normal_force"}
_QUANTITIES |= dict.fromkeys(("x", "y", "x_n"), "displacement")
_QUANTITIES |= dict.fromkeys(("v", "v_y", "v_n"), "velocity")
_QUANTITIES |= dict.fromkeys(("f", "f_y"), "friction_force")


@dataclass(frozen=True)
class Series:
    """Columns of a channel that share a plot."""

    quantity: str
    columns: tuple[int, ...]


def series(channel: Channel) -> list[Series]:
    """Return the plots of a channel: one for each quantity, or for an external number."""
    if channel.topic.startswith(OTHER):
        return [Series("", (0,))]
    if channel.topic in (PHASES, TORUS, SHARE, DISK):  # drawings or an event show them
        return []
    columns: dict[str, list[int]] = {}
    for column, name in enumerate(channel.names):
        columns.setdefault(_quantity(name), []).append(column)
    return [Series(quantity, tuple(members)) for quantity, members in columns.items()]


def find_plots(
    channels: Sequence[Channel], wanted: Iterable[tuple[str, str, str]]
) -> dict[str, list[tuple[Channel, Series]]]:
    """Return the series of wanted plots by title, full-order ones too; only plots that have any.

    `wanted` has topics, quantities and titles, as `SLOW_PLOTS`.
    """
    found = {}
    for topic, quantity, title in wanted:
        own = [
            (channel, plot)
            for channel in channels
            if (channel.topic.removeprefix(FULL) + "/").startswith(f"{topic}/")
            for plot in series(channel)
            if plot.quantity == quantity
        ]
        if own:
            found[title] = own
    return found


def is_contact(channel: Channel) -> bool:
    """Return whether a channel has the motion of a contact."""
    return channel.topic.removeprefix(FULL).startswith("/contact/")


def _quantity(name: str) -> str:
    if name.endswith("_abs"):  # modes of two tones differ too much in size for one scale
        return f"amplitude_{name[0]}"
    word = "x" if name.startswith("x_") else name.split("_")[-1]
    return _QUANTITIES.get(name, _QUANTITIES.get(word, word))


def legend(channel: Channel, column: int) -> str:
    """Return the name of a column in a legend, with its unit."""
    unit = channel.fields[column].unit
    return f"{label(channel, column)} [{unit}]" if unit else label(channel, column)


def titled(title: str, found: Iterable[tuple[Channel, Series]]) -> str:
    """Return the title of a plot with the unit of its series."""
    units = {channel.fields[k].unit for channel, plot in found for k in plot.columns}
    return f"{title} [{units.pop()}]" if len(units) == 1 and units != {"1"} else title


def label(channel: Channel, column: int) -> str:
    """Return the name of a column in a plot whose title has the unit."""
    field = channel.fields[column]
    mode, _, part = field.name.partition("_")
    if channel.topic.startswith(OTHER):
        return field.name
    if channel.topic == "/energy":
        return _BALANCE[field.name]
    if part == "abs":
        text = f"|{mode}|"
    elif part in ("re", "im"):
        text = f"{part.capitalize()} {mode}"
    elif is_contact(channel):
        text = f"{field.name} contact {channel.topic.split('/')[-1]}"
        text += ", full order" if channel.topic.startswith(FULL) else ""
    else:
        text = field.name
    return text


_BALANCE = {
    "input_power": "input",
    "dissipated_power": "contacts",
    "dissipated_energy": "contacts",
    "structural_power": "structural damping",
    "stored_power": "change of energy",
}

_WORDS = {
    "|A|": "**|A|, |B|**: amplitudes of the two modes in slow time. The displacement of a DOF is "
    "`2 Re(phi A exp(i theta))`, so that a mass-normalised mode moves by twice its amplitude.",
    "Blade amplitudes": "**Blade amplitudes**: the amplitude of one DOF of every blade of a "
    "mistuned disk in slow time. Blades that lie far above the others hold the energy.",
    "Power balance": "**Power balance**: the power of the forces is the sum of what the contacts "
    "dissipate, what structural damping dissipates, and the change of the energy of the modes.",
    "Mode A": "**Mode A, Mode B**: complex amplitudes in their planes. The angle is the phase "
    "against the forcing; a steady state is a point.",
    "over its frequency": "**|A| over its frequency**: amplitude against forcing frequency as the "
    "sweep went on. It lags behind the steady response curve where the sweep is quick.",
    "Hysteresis": "**Hysteresis**: friction force against displacement of a contact. The area of "
    "a loop is the energy it takes out in a cycle; steep sides are sticking, level ones sliding.",
    "Orbit": "**Orbit**: displacement of a contact in its plane.",
    "Contacts": "**Contacts**: displacement of one contact against that of another.",
    "over the phases": "**Contact over the phases of both carriers**: while amplitudes stand "
    "still, the motion of a contact depends on two angles alone, the phases of both forcings. The "
    "height of the surface is its displacement there, the colour its friction force: orange "
    "slides one way, blue the other, grey is without force. The white point is the motion itself: "
    "it crosses the square again and again, and comes back at the opposite edge.",
    "Disk": "**Disk**: the displacement of one DOF in every sector, drawn outwards, at the end of "
    "the last window. Points between the blades are the contacts: grey while they stick, orange "
    "while they slip, red while they are open.",
    "stuck": "**State**: 0 while a contact sticks, 1 while it slips, 2 while it is open.",
}


def reading(titles: Iterable[str]) -> str:
    """Return Markdown that explains the views with these titles, and how to use them."""
    shown = "\n".join(titles)
    found = [words for part, words in _WORDS.items() if part in shown]
    use = (
        "Time runs below: drag it or press space. Drag in a plot to move it, scroll to zoom, "
        "double-click to see all of it."
    )
    return "\n\n".join([*found, use])


def readable(value: float, unit: str) -> str:
    """Return a value with its unit, to three digits: 174 µm for 0.000174 m, but 0.25 m."""
    size = abs(value)
    # a prefix of kg^0.5 m would be ambiguous
    if unit in ("m", "m/s", "N", "W", "J") and size > 0.0 and not 0.1 <= size < 1000.0:
        power = 3 * floor(log10(float(f"{size:.3g}")) / 3)
        power = min(max(power, -9), 9)
        prefix = ("n", "µ", "m", "", "k", "M", "G")[power // 3 + 3]
        return f"{value / 10.0**power:.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}"


def units_of(scene_text: str) -> Units:
    """Return the [units] of a scene; SI units if it has none, or if there is no scene."""
    try:
        return Units(**tomllib.loads(scene_text).get("units", {}))
    except (tomllib.TOMLDecodeError, TypeError, SlipmodeError):
        return SI  # a scene of another version, or another program


def in_units(channel: Channel, units: Units) -> tuple[Channel, Floats]:
    """Return a channel with the units in which views show it, and factors of its values."""
    shown = {
        "rad/s": (units.frequency, float(units.of_frequency(1.0))),
        "m": (units.displacement, float(units.of_displacement(1.0))),
    }
    found = [shown.get(field.unit, (field.unit, 1.0)) for field in channel.fields]
    fields = [Field(name, unit) for name, (unit, _) in zip(channel.names, found, strict=True)]
    return replace(channel, fields=tuple(fields)), np.array([factor for _, factor in found])


def readable_scale(low: float, high: float) -> tuple[float, float] | None:
    """Return the ends of a scale with at least two labels for values from `low` to `high`.

    None for values that are all of one sign and far from zero: a viewer fits these better.
    """
    if not np.isfinite((low, high)).all() or low == high == 0.0:
        return None
    if low > 0.8 * high or high < 0.8 * low:
        return None
    low, high = _MARGIN * min(low, 0.0), _MARGIN * max(high, 0.0)
    unit = 10.0 ** floor(log10(max(high, -low)))
    if high - low > _LABELLED * unit:  # zero would have the only label: as far as the next power
        largest = _MARGIN * 10.0 * unit
        low = -largest if -low > 0.6 * largest else low
        high = largest if low == 0.0 or high > 0.6 * largest else high
    return low, high


def with_room(start: int, end: int) -> tuple[int, int]:
    """Return the times [ns] of a plot whose legend stands to the right of its curves."""
    return start, end + (end - start) // 2
