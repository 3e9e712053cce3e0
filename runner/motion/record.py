"""What a run records: slow channels, fast motion of windows, and the states of the contacts."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.elements import SLIDERS, Elements
from slipmode.rom.laws.states import STATES, ContactStates, contact_states
from slipmode.rom.short_repr import frozen
from slipmode.rom.validity import Finding
from slipmode.runner.plan.plan import Plan
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Recorder
from slipmode.runner.scene.scene import Window


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
            recorder.event(0.0, each.level, f"{each.subject} {each.choice}: {each.reason}")


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


class WindowRecord:
    """Records the fast motion of a window and the states of the contacts in it."""

    def __init__(self, plan: Plan, recorder: Recorder, window: Window) -> None:
        reduced = plan.excited.reduced
        self._contacts = ContactRecord(reduced.contacts, reduced.n_contacts)
        self._recorder = recorder
        self._window = window
        self._elastic = bool(plan.scene.output.elastic)
        self._shares: list[Floats] = []  # of the states, times the samples of a batch
        self._of_contacts = window in plan.scene.contact
        self._samples = 0

    def add(self, motion: FastMotion, scale: Floats | float = 1.0) -> None:
        """Record the next samples; limits and preloads are multiplied by `scale`."""
        if self._of_contacts:
            moved = motion.displacement, motion.velocity, motion.force
            rows = self._contacts.rows(*moved, scale)
            for channel, values in zip(self._contacts.channels, rows, strict=True):
                self._recorder.write(channel.topic, motion.time, values)
            states = self._contacts.states(motion.displacement, motion.force, scale)
            if states is not None:
                self._shares.append(motion.time.size * states.shares())
        if self._elastic:
            self._recorder.write("/elastic", motion.time, motion.elastic)
        self._samples += motion.time.size

    def finish(self) -> None:
        """Record the share of the window that contacts spent in each state."""
        if not self._shares:
            return
        start, end = self._window.start, self._window.end
        shares = np.sum(self._shares, axis=0) / self._samples
        self._recorder.write(channels.SHARE, np.array([end]), shares.reshape(1, -1))
        self._recorder.event(end, "info", f"{start:g} to {end:g} s: {_in_words(shares)}")


class ContactRecord:
    """Channels of the contacts of a structure, and rows for them.

    A contact is one of the contact DOFs with rigid friction (`elements` is None), or an element of
    the law with elastic friction. Topics begin with `prefix`.
    """

    def __init__(self, elements: Elements | None, contacts: int, prefix: str = "") -> None:
        self._elements = elements
        if elements is None:
            self.channels = [channels.contact(i, prefix) for i in range(contacts)]
            return
        self.channels = [
            channels.elastic_contact(i, _tangents(element), prefix)
            for i, element in enumerate(elements.element)
        ]

    def rows(
        self, displacement: Floats, velocity: Floats, force: Floats, scale: Floats | float = 1.0
    ) -> list[Floats]:
        """Return the samples of each channel from motion (n, N_c); see `WindowRecord.add`."""
        if self._elements is None:
            every = (displacement, velocity, force)
            return [np.stack([part[:, i] for part in every], axis=1) for i in range(len(force.T))]
        states = contact_states(self._elements, displacement, force, scale)
        rows = []
        for k, element in enumerate(self._elements.element):
            tangents = _tangents(element)
            along = element["column"][: max(tangents, 1)].tolist()
            columns = [part[:, i] for i in along for part in (displacement, velocity, force)]
            if tangents:
                normal = element["column"][tangents]
                columns += [displacement[:, normal], velocity[:, normal]]
                columns += [states.normal_force[:, k], states.gap[:, k]]
            rows.append(np.stack([*columns, states.state[:, k]], axis=1))
        return rows

    def states(
        self, displacement: Floats, force: Floats, scale: Floats | float = 1.0
    ) -> ContactStates | None:
        """Return the states of elastic contacts; None for rigid contacts."""
        if self._elements is None:
            return None
        return contact_states(self._elements, displacement, force, scale)


def _tangents(element: np.void) -> int:
    """Return the number of tangential directions; 0 for a law without a normal."""
    return 0 if element["law"] == SLIDERS else int(element["tangents"])


def _in_words(shares: Floats) -> str:
    """Return in words the shares of time (elements, 3) that contacts spend in each state."""
    parts = []
    for name, part in zip(STATES, shares.T, strict=True):
        low, high = part.min(), part.max()
        range_ = f"{high:.0%}" if high - low < 5e-3 else f"{low:.0%} to {high:.0%}"
        parts.append(f"{name} {range_}")
    return f"contacts are {', '.join(parts)} of the time"
