"""What is plotted from which channel: titles, curves, colours, order and explanations.

Rerun, Foxglove, charts and the page of `slipmode explore` take them from here. A new plot of a
channel is one entry of `PLOTS` or one portrait.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import NamedTuple

from slipmode.runner.recording.channels import DISK, FULL, OTHER, PHASES, SHARE, TORUS, Channel

Color = tuple[int, int, int]
BLUE, ORANGE, GREEN, RED = (76, 159, 230), (240, 145, 60), (110, 190, 110), (224, 82, 82)
LINES = (BLUE, ORANGE, GREEN, (205, 110, 190), (200, 190, 90))  # of a plot
GREY, DARK = (145, 153, 165), (75, 80, 90)  # grey is readable on black and on white, as the others
STATE_COLORS = {"grey": GREY, "orange": ORANGE, "red": RED}  # of stuck, slipping, open contacts
DISPLACEMENT = "/displacement"  # topic of modal amplitudes as displacements of a DOF
LOOPS = 3  # hysteresis loops of the first contacts: more would be too small to read


@dataclass(frozen=True)
class Plot:
    """Curves of one quantity over time."""

    name: str  # Of the plot in files
    title: str  # Without its unit
    topic: str  # Of a channel, or of all channels below it
    fields: str  # Names of its fields: patterns with *
    label: str = "{name}"  # Of a curve; {0}, {1} are the parts of the name of its field
    tab: str = ""  # Plots with the same word share a place, the first one in front
    fast: bool = False  # Whether it shows the motion within a cycle
    words: str = ""  # Explanation in Markdown

    def columns(self, channel: Channel) -> tuple[int, ...]:
        """Return the columns of a channel that are plotted; of full-order motion too."""
        if not (channel.topic.removeprefix(FULL) + "/").startswith(f"{self.topic}/"):
            return ()
        patterns = self.fields.split()
        return tuple(
            column
            for column, name in enumerate(channel.names)
            if any(fnmatchcase(name, pattern) for pattern in patterns)
        )

    def curve(self, channel: Channel, column: int) -> str:
        """Return the name of a curve, without its unit."""
        name, number = channel.names[column], channel.topic.rpartition("/")[2]
        text = self.label.format(*name.split("_"), name=name, contact=number)
        text = _BALANCE.get(name, text)
        return f"{text}, full order" if channel.topic.startswith(FULL) else text


_BALANCE = {
    "input_power": "input",
    "dissipated_power": "contacts",
    "dissipated_energy": "contacts",
    "structural_power": "structural damping",
    "stored_power": "change of energy",
}

PLOTS = (
    Plot(
        "A", "Displacement", DISPLACEMENT, "A*", tab="A",
        words="**Displacement**: amplitude of a mode in slow time, at the DOF that it moves most.",
    ),
    Plot(
        "amplitude_A", "Modal amplitude", "/modes", "A*_abs", "|{0}|", "A",
        words="**|A|, |B|**: amplitudes of the modes in slow time. The displacement of a DOF is "
        "`2 Re(phi A exp(i theta))`, so that a mass-normalised mode moves by twice its amplitude.",
    ),
    Plot("B", "Displacement", DISPLACEMENT, "B*", tab="B"),
    Plot("amplitude_B", "Modal amplitude", "/modes", "B*_abs", "|{0}|", "B"),
    Plot(
        "amplitude", "Blade amplitudes", "/blades", "*_amplitude", "blade {1}",
        words="**Blade amplitudes**: the amplitude of one DOF of every blade of a mistuned disk "
        "in slow time. Few blades with amplitudes far above the others hold the energy.",
    ),
    Plot("force", "Force amplitude", "/forcing", "*_force", "mode {0}", "forcing"),
    Plot("frequency", "Forcing frequency", "/forcing", "*_frequency", "mode {0}", "forcing"),
    Plot("scale", "Friction limit", "/control", "limit_scale", "relative to the model"),
    Plot(
        "power", "Power balance", "/energy", "*_power", tab="energy",
        words="**Power balance**: the power of the forces is the sum of what the contacts "
        "dissipate, what structural damping dissipates, and the change of the energy of the "
        "modes.",
    ),
    Plot("energy", "Dissipated energy", "/energy", "dissipated_energy", tab="energy"),
    Plot("displacement", "Elastic displacement", "/elastic", "x_*", "DOF {1}", fast=True),
    Plot(
        "displacement", "Contact displacement", "/contact", "x y", "{name} contact {contact}",
        "contact", fast=True,
    ),
    Plot("normal_displacement", "Normal displacement", "/contact", "x_n", "contact {contact}",
         "contact", fast=True),
    Plot("gap", "Gap", "/contact", "gap", "contact {contact}", "contact", fast=True),
    Plot("friction_force", "Friction force", "/contact", "f f_y", "{name} contact {contact}",
         "forces", fast=True),
    Plot("normal_force", "Normal force", "/contact", "N", "contact {contact}", "forces",
         fast=True),
    Plot(
        "state", "0 stuck, 1 slipping, 2 open", "/contact", "state", "contact {contact}",
        fast=True,
        words="**State**: 0 while a contact sticks, 1 while it slips, 2 while it is open.",
    ),
)  # fmt: skip


class Curves(NamedTuple):
    """Columns of a channel that share a plot."""

    channel: Channel
    name: str  # Of the plot in files, "" for a number of another program
    columns: tuple[int, ...]
    names: tuple[str, ...]  # In a legend, without units

    @property
    def units(self) -> set[str]:
        """Units of the curves."""
        return {self.channel.fields[column].unit for column in self.columns}


def curves(channel: Channel) -> list[Curves]:
    """Return the curves of a channel by plot, at last those of its fields without a plot."""
    if channel.topic.startswith(OTHER):
        return [Curves(channel, "", (0,), (legend(channel, 0, channel.names[0]),))]
    if channel.topic in (PHASES, TORUS, SHARE, DISK):  # drawings or an event show them
        return []
    found = [_curves(plot, channel) for plot in PLOTS if plot.columns(channel)]
    plotted = {column for each in found for column in each.columns}
    rest = tuple(k for k in range(len(channel.names)) if k not in plotted)
    names = tuple(legend(channel, k, channel.names[k]) for k in rest)
    return [*found, Curves(channel, "other", rest, names)] if rest else found


def _curves(plot: Plot, channel: Channel) -> Curves:
    columns = plot.columns(channel)
    return Curves(channel, plot.name, columns, tuple(plot.curve(channel, k) for k in columns))


def find_plots(channels: Sequence[Channel], *, fast: bool) -> list[tuple[Plot, list[Curves]]]:
    """Return the plots that have curves in slow time, or of fast motion, with these."""
    every = [
        (plot, [_curves(plot, each) for each in channels if plot.columns(each)])
        for plot in PLOTS
        if plot.fast == fast
    ]
    return [(plot, found) for plot, found in every if found]


def is_contact(channel: Channel) -> bool:
    """Return whether a channel has the motion of a contact."""
    return channel.topic.removeprefix(FULL).startswith("/contact/")


def legend(channel: Channel, column: int, name: str) -> str:
    """Return the name of a column in a legend, with its unit."""
    unit = channel.fields[column].unit
    return f"{name} [{unit}]" if unit else name


def titled(plot: Plot, found: Sequence[Curves]) -> str:
    """Return the title of a plot with the unit of its curves, and the name of a single one."""
    units = set().union(*(each.units for each in found))
    names = [name for each in found for name in each.names]
    title = f"{plot.title}: {names[0]}" if len(names) == 1 else plot.title
    return f"{title} [{units.pop()}]" if len(units) == 1 and units != {"1"} else title


@dataclass(frozen=True)
class Axis:
    """A recorded quantity as the axis of a portrait."""

    topic: str
    field: str
    label: str
    unit: str


@dataclass(frozen=True)
class Portrait:
    """One recorded quantity over another."""

    kind: str  # Those of one kind stand together
    entity: str  # Where it is logged
    title: str
    x: Axis
    y: Axis  # Upwards
    one_scale: bool = False  # Whether both axes share a scale, so that angles are true
    tail: bool = False  # Whether the moving point draws a tail: fast motion
    color: Color = BLUE
    # Whether the axes meet in the corner, x from its least value and y from 0
    corner: bool = False


def portraits(channels: Iterable[Channel]) -> list[Portrait]:
    """Return the portraits of recorded channels.

    Phase portraits of the modes; their amplitudes over their frequencies, for sweeps; the
    trajectory of two contacts; hysteresis loops of the first contacts, and their orbits if they
    slide in two directions.
    """
    by_topic = {channel.topic: channel for channel in channels}
    contacts = [topic for topic in by_topic if topic.startswith("/contact/")]

    def axis(topic: str, field: str, label: str) -> Axis:
        return Axis(topic, field, label, by_topic[topic].units[field])

    def names(topic: str) -> tuple[str, ...]:
        return by_topic[topic].names if topic in by_topic else ()

    modes = names("/modes")
    planes, responses = [], []
    for mode in [name.removesuffix("_re") for name in modes if name.endswith("_re")]:
        x, y = (axis("/modes", f"{mode}_{p.lower()}", f"{p} {mode}") for p in ("Re", "Im"))
        place, color = f"/phase_plane/{mode}", ORANGE if mode.startswith("B") else BLUE
        planes.append(Portrait("plane", place, f"Mode {mode}", x, y, one_scale=True, color=color))
        carrier = f"{mode[0]}_frequency"
        if f"{mode}_abs" in modes and carrier in names("/forcing"):
            x = axis("/forcing", carrier, "frequency")
            y = axis("/modes", f"{mode}_abs", f"|{mode}|")
            for name in names(DISPLACEMENT):
                y = axis(DISPLACEMENT, name, name) if name.startswith(f"{mode} ") else y
            place, title = f"/response/{mode}", f"Mode {mode} over its frequency"
            responses.append(Portrait("response", place, title, x, y, color=color, corner=True))
    found = [*planes, *responses]
    if len(contacts) > 1:
        x, y = (axis(topic, "x", f"x of contact {topic.split('/')[-1]}") for topic in contacts[:2])
        found.append(Portrait("trajectory", "/trajectory", "Contacts", x, y, tail=True))
    full = [topic for topic in by_topic if topic.startswith(f"{FULL}/contact/")]
    for topic in (*contacts[:LOOPS], *full[:LOOPS]):
        number = topic.split("/")[-1]
        where = f"of contact {number}{', full order' if topic in full else ''}"
        kind, color = "full loop" if topic in full else "loop", LINES[int(number) % len(LINES)]
        x, y = axis(topic, "x", "x"), axis(topic, "f", "f")
        place, title = f"/loop{topic}", f"Hysteresis {where}"
        found.append(Portrait(kind, place, title, x, y, tail=True, color=color))
        if "y" in by_topic[topic].names:
            y, title = axis(topic, "y", "y"), f"Orbit {where}"
            shape = {"one_scale": True, "tail": True}
            found.append(Portrait("orbit", f"/orbit{topic}", title, x, y, color=color, **shape))
    return found


_WORDS = {
    "Mode A": "**Mode A, Mode B**: complex amplitudes in their planes. The angle is the phase "
    "against the forcing; a steady state is a point.",
    "over its frequency": "**Mode A over its frequency**: amplitude against forcing frequency as "
    "the sweep went on. It lags behind the steady response curve where the sweep is quick.",
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
}


def reading(channels: Sequence[Channel], titles: Iterable[str]) -> str:
    """Return Markdown that explains the plots of channels, the drawings with titles, their use."""
    plots = [*find_plots(channels, fast=False), *find_plots(channels, fast=True)]
    shown = "\n".join(titles)
    use = (
        "Time runs below: drag it or press space. Drag in a plot to move it, scroll to zoom, "
        "double-click to see all of it."
    )
    found = [plot.words for plot, _ in plots if plot.words]
    found += [words for part, words in _WORDS.items() if part in shown]
    return "\n\n".join([*found, use])
