"""What is plotted from which channel: titles, curves, colours, order and explanations.

Rerun, Foxglove, charts (colours) and the page of `slipmode explore` (titles) take them from here.
A new plot of a channel is one entry of `PLOTS`, or one portrait.
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
        if "_abs_" in name:
            text += f", {name.rpartition('_')[2]} % of the samples"
        return f"{text}, full order" if channel.topic.startswith(FULL) else text


_OF_CONTACT = "{name} contact {contact}"
PLOTS = (
    Plot("A", "Displacement", DISPLACEMENT, "A*", tab="A"),
    Plot("amplitude_A", "Modal amplitude", "/modes", "A*_abs A_abs_*", "|{0}|", "A"),
    Plot("B", "Displacement", DISPLACEMENT, "B*", tab="B"),
    Plot("amplitude_B", "Modal amplitude", "/modes", "B*_abs B_abs_*", "|{0}|", "B"),
    Plot("amplitude", "Blade amplitudes", "/blades", "*_amplitude", "blade {1}"),
    Plot("force", "Force amplitude", "/forcing", "*_force", "mode {0}", "forcing"),
    Plot("frequency", "Forcing frequency", "/forcing", "*_frequency", "mode {0}", "forcing"),
    Plot("scale", "Friction limit", "/control", "limit_scale", "relative to the model"),
    Plot("power", "Power balance", "/energy", "*_power", "{0}", "energy"),
    Plot("energy", "Dissipated energy", "/energy", "dissipated_energy", "contacts", "energy"),
    Plot("displacement", "Elastic displacement", "/elastic", "x_*", "DOF {1}", "elastic", True),
    Plot("displacement", "Contact displacement", "/contact", "x y", _OF_CONTACT, "contact", True),
    Plot("normal", "Normal displacement", "/contact", "x_n", _OF_CONTACT, "contact", True),
    Plot("gap", "Gap", "/contact", "gap", _OF_CONTACT, "contact", True),
    Plot("friction_force", "Friction force", "/contact", "f f_y", _OF_CONTACT, "forces", True),
    Plot("normal_force", "Normal force", "/contact", "N", _OF_CONTACT, "forces", True),
    Plot("state", "0 stuck, 1 slipping, 2 open", "/contact", "state", _OF_CONTACT, "state", True),
)


class Curves(NamedTuple):
    """Columns of a channel that share a plot."""

    channel: Channel
    name: str  # Of the plot in files, "" for a number of another program
    columns: tuple[int, ...]
    names: tuple[str, ...]  # In a legend, without units


def curves(channel: Channel) -> list[Curves]:
    """Return the curves of a channel by plot, at last the curves of fields without a plot."""
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
    units = {each.channel.fields[column].unit for each in found for column in each.columns}
    names = [name for each in found for name in each.names]
    title = f"{plot.title}: {names[0]}" if len(names) == 1 else plot.title
    return f"{title} [{units.pop()}]" if len(units) == 1 and units != {"1"} else title


class Axis(NamedTuple):
    """A recorded quantity as the axis of a portrait."""

    topic: str
    field: str
    label: str


@dataclass(frozen=True)
class Portrait:
    """One recorded quantity over another."""

    kind: str  # "plane" (of a mode), "response", "trajectory", "loop", "full loop" or "orbit"
    entity: str  # Where it is logged
    title: str
    x: Axis
    y: Axis  # Upwards
    color: Color = BLUE

    @property
    def fast(self) -> bool:
        """Whether it shows the motion within a cycle."""
        return self.kind not in ("plane", "response")


def portraits(channels: Iterable[Channel]) -> list[Portrait]:
    """Return the portraits of recorded channels.

    Phase portraits of the modes; their amplitudes over their frequencies, for sweeps; the
    trajectory of two contacts; hysteresis loops of the first contacts, and their orbits if they
    slide in two directions.
    """
    by_topic = {channel.topic: channel for channel in channels}
    contacts = [topic for topic in by_topic if topic.startswith("/contact/")]

    def names(topic: str) -> tuple[str, ...]:
        return by_topic[topic].names if topic in by_topic else ()

    modes = names("/modes")
    planes, responses = [], []
    for mode in [name.removesuffix("_re") for name in modes if name.endswith("_re")]:
        x, y = (Axis("/modes", f"{mode}_{p.lower()}", f"{p} {mode}") for p in ("Re", "Im"))
        place, color = f"/phase_plane/{mode}", ORANGE if mode.startswith("B") else BLUE
        planes.append(Portrait("plane", place, f"Mode {mode}", x, y, color))
        carrier = f"{mode[0]}_frequency"
        if f"{mode}_abs" in modes and carrier in names("/forcing"):
            x = Axis("/forcing", carrier, "frequency")
            y = Axis("/modes", f"{mode}_abs", f"|{mode}|")
            for name in reversed(names(DISPLACEMENT)):  # the first one, without percentiles
                y = Axis(DISPLACEMENT, name, name) if name.startswith(f"{mode} ") else y
            place, title = f"/response/{mode}", f"Mode {mode} over its frequency"
            responses.append(Portrait("response", place, title, x, y, color))
    found = [*planes, *responses]
    if len(contacts) > 1:
        x, y = (Axis(topic, "x", f"x of contact {topic.split('/')[-1]}") for topic in contacts[:2])
        found.append(Portrait("trajectory", "/trajectory", "Contacts", x, y))
    full = [topic for topic in by_topic if topic.startswith(f"{FULL}/contact/")]
    for topic in (*contacts[:LOOPS], *full[:LOOPS]):
        number = topic.split("/")[-1]
        where = f"of contact {number}{', full order' if topic in full else ''}"
        kind, color = "full loop" if topic in full else "loop", LINES[int(number) % len(LINES)]
        x, y = Axis(topic, "x", "x"), Axis(topic, "f", "f")
        place, title = f"/loop{topic}", f"Hysteresis {where}"
        found.append(Portrait(kind, place, title, x, y, color))
        if "y" in by_topic[topic].names:
            y, title = Axis(topic, "y", "y"), f"Orbit {where}"
            found.append(Portrait("orbit", f"/orbit{topic}", title, x, y, color))
    return found


_WORDS = {  # in Markdown, by a part of the title
    "Displacement": "amplitude of a mode in slow time, at the DOF that it moves most.",
    "Modal amplitude": "|A| in slow time: a DOF moves as `2 Re(phi A exp(i theta))`.",
    "Blade amplitudes": "of one DOF of each blade. Blades far above the others hold the energy.",
    "Power balance": "input = dissipated by contacts + structural damping + stored in modes.",
    "Mode A": "complex amplitude in its plane. The angle is the phase against the forcing; a "
    "steady state is a point.",
    "over its frequency": "amplitude against forcing frequency as the sweep went on. It lags "
    "behind the steady response curve where the sweep is quick.",
    "Hysteresis": "friction force against displacement of a contact. The area of a loop is the "
    "energy it takes out in a cycle; steep sides are sticking, level ones sliding.",
    "over the phases": "displacement (height) and friction force (colour) of a contact against "
    "the phases of both forcings, while amplitudes stand still. The white point is its motion.",
    "Disk": "the displacement of one DOF in every sector, drawn outwards, at the end of the last "
    "window. Points are the contacts: grey while stuck, orange while slipping, red while open.",
}


def reading(channels: Sequence[Channel], drawings: Sequence[str]) -> str:
    """Return Markdown that explains plots of channels, drawings with titles, and their use."""
    plots = [*find_plots(channels, fast=False), *find_plots(channels, fast=True)]
    titles = [*(plot.title for plot, _ in plots), *drawings]
    found = {part: next((each for each in titles if part in each), None) for part in _WORDS}
    lines = [f"**{title}**: {_WORDS[part]}" for part, title in found.items() if title]
    use = (
        "Drag the time below, or press space. Drag a plot, scroll to zoom, double-click to reset."
    )
    return "\n\n".join([*lines, use])
