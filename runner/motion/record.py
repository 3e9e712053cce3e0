"""What a run records: slow channels, fast motion of windows, and the states of the contacts."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from slipmode.rom import Reduced
from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import SLIDERS
from slipmode.rom.laws.states import STATES, contact_states
from slipmode.rom.short_repr import frozen
from slipmode.rom.validity import Finding
from slipmode.runner.plan.plan import Plan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder


@frozen
class FastMotion:
    """Motion at given times, in slow time or at full order."""

    time: Floats  # (n,) [s]
    # displacement, velocity, force: (n, N_c): Motion of the contacts [m], [m/s], and force on them
    # [N]
    displacement: Floats
    velocity: Floats
    force: Floats
    modal: Floats  # (n, modes): Displacements of the retained modes [kg^1/2 m]
    elastic: Floats  # (n, dofs): Displacements of the scene's output.elastic [m]


def record_findings(recorder: Recorder, found: Iterable[Finding]) -> None:
    """Record the warnings of a plan and a model as events at t = 0."""
    for each in found:
        if each.level != "info":
            recorder.event(0.0, each.level, each.line())


def record_points(
    plan: Plan, recorder: Recorder, first: int, amplitude: Floats, energy: Floats
) -> None:
    """Record the slow channels of communication points from number `first` on.

    `amplitude` (points, 2 modes) has the real and imaginary part of each a_j, `energy` (points, 3)
    input power, dissipated power and dissipated energy.
    """
    schedule, points = plan.schedule, slice(first, first + len(amplitude))
    time = schedule.time(points)
    moduli = np.hypot(amplitude[:, 0::2], amplitude[:, 1::2])
    recorder.write("/modes", time, np.hstack((amplitude, moduli)))
    names = [f"{q}_{m}" for m in plan.excited.modes for q in ("force", "frequency", "phase")]
    recorder.write("/forcing", time, schedule.at_points(names, points))
    recorder.write("/energy", time, energy)


def contact_channels(reduced: Reduced, prefix: str = "") -> list[channels.Channel]:
    """Return the channels of the contacts: contact DOFs if rigid, elements of an elastic law."""
    if reduced.contacts is None:
        return [channels.contact(i, prefix) for i in range(reduced.n_contacts)]
    return [
        channels.elastic_contact(i, _tangents(element), prefix)
        for i, element in enumerate(reduced.contacts.element)
    ]


def record_contacts(
    recorder: Recorder,
    reduced: Reduced,
    motion: FastMotion,
    scale: Floats | float = 1.0,
    prefix: str = "",
) -> Floats | None:
    """Record the motion of contacts; return the shares of the states of elastic ones."""
    moved, elements = (motion.displacement, motion.velocity, motion.force), reduced.contacts
    listed = contact_channels(reduced, prefix)
    if elements is None:
        for i, channel in enumerate(listed):
            rows = np.stack([part[:, i] for part in moved], axis=1)
            recorder.write(channel.topic, motion.time, rows)
        return None
    states = contact_states(elements, motion.displacement, motion.force, scale)
    for k, (channel, element) in enumerate(zip(listed, elements.element, strict=True)):
        tangents = _tangents(element)
        along = element["column"][: max(tangents, 1)].tolist()
        columns = [part[:, i] for i in along for part in moved]
        if tangents:
            normal = element["column"][tangents]
            columns += [motion.displacement[:, normal], motion.velocity[:, normal]]
            columns += [states.normal_force[:, k], states.gap[:, k]]
        rows = np.stack([*columns, states.state[:, k]], axis=1)
        recorder.write(channel.topic, motion.time, rows)
    return states.shares()


def _tangents(element: np.void) -> int:
    """Return the number of tangential directions; 0 for a law without a normal."""
    return 0 if element["law"] == SLIDERS else int(element["tangents"])


def shares_in_words(shares: Floats) -> str:
    """Return in words the shares of time (elements, 3) that contacts spend in each state."""
    parts = []
    for name, part in zip(STATES, shares.T, strict=True):
        low, high = part.min(), part.max()
        range_ = f"{high:.0%}" if high - low < 5e-3 else f"{low:.0%} to {high:.0%}"
        parts.append(f"{name} {range_}")
    return f"contacts are {', '.join(parts)} of the time"
