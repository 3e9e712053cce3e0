"""Estimate of the error that a transient has in slow time.

The slow flow takes friction from motion with steady amplitudes, corrected to first order in their
rates. While an amplitude changes, a contact slips further one way than back. The difference leaves
a mean force on the contact, which displaces the modes, and which the slow flow neglects. This
force is about the change of the contact force in one cycle. Steady states do not have this error.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.laws.elements import SLIDERS, Elements
from slipmode.rom.laws.friction import Friction, limits
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen, percentage
from slipmode.rom.validity.friction import elastic_force


def friction_threshold(reduced: Reduced, law: Friction) -> Floats:
    """Amplitude (modes,) at which a mode alone makes its first contact slip, or open.

    Infinite for a mode that moves no contact.
    """
    on_contacts = elastic_force(reduced, np.eye(len(reduced.modes)))
    hold = np.broadcast_to(limits(law, reduced.n_contacts), on_contacts.shape)
    threshold = np.full(on_contacts.shape, np.inf)
    np.divide(hold, on_contacts, out=threshold, where=on_contacts > 0)
    return np.asarray(threshold.min(axis=1))


@frozen
class TransientError:
    """Error of the amplitudes of a reduced model while they change."""

    load: Floats  # (modes, parts), peak force on stuck parts per amplitude [N kg^-1/2 m^-1]
    # (modes, parts), peak force that is compared with `onset`: under a varying normal load it
    # includes the loss of friction
    slip_load: Floats
    onset: Floats  # (parts,), force at which slip begins [N]
    largest: Floats  # (parts,), bound of the mean force [N]
    displacement: Floats  # (modes, parts), amplitude error per mean force [kg^1/2 m/N]

    @classmethod
    def of(cls, reduced: Reduced, law: Friction) -> Self:
        """Build the estimate for a reduced model and its contact law; 0 without contacts."""
        if not reduced.n_contacts:
            none = np.zeros((len(reduced.modes), 0))
            return cls(none, none, none[0], none[0], none)
        # The mean force on a slipping contact is half the change of its force in one cycle, and
        # twice that on elastic contacts, which slip one way for several cycles under varying
        # normal loads. The estimate then exceeds the RMS error from rest
        # (tests/runner/transients/test_transient_errors.py).
        coupling = np.abs(reduced.coupling)
        per_force = 0.5 / reduced.frequency[:, np.newaxis] ** 2
        if reduced.contacts is None:
            # a force on rigid contacts moves them on the flexibility of the structure
            moved = np.abs(reduced.coupling @ np.linalg.pinv(reduced.stiffness))
            hold = np.array(limits(law, reduced.n_contacts))
            load = 2.0 * coupling
            return cls(load, load, hold, hold, moved * per_force)
        parts = map(np.array, zip(*_friction_parts(reduced.contacts), strict=True))
        column, stiffness, onset, largest, slip_load = parts
        moved = coupling[:, column]
        load = 2.0 * moved * stiffness
        return cls(load, 2.0 * coupling @ slip_load.T, onset, largest, 2.0 * moved * per_force)

    def at(
        self, rate: Complexes | Floats, frequency: Floats, amplitude: Complexes | Floats
    ) -> Floats:
        """Return the estimated error of the amplitudes, (points, modes) [kg^1/2 m].

        `rate` is da/dt [kg^1/2 m/s] and `amplitude` the effective amplitude at the contacts, both
        (points, modes) and divided by the scale of the friction limits; `frequency`
        (points, modes) or (modes,) are the carriers [rad/s].
        """
        growth = 2.0 * np.pi * np.abs(rate) / np.min(frequency, axis=-1, keepdims=True)
        slips = (np.abs(amplitude) + growth) @ self.slip_load >= self.onset
        force = np.minimum(0.5 * growth @ self.load, self.largest)
        return np.asarray(np.where(slips, force, 0.0) @ self.displacement.T)


def _friction_parts(contacts: Elements) -> Iterator[tuple[int, float, float, float, Floats]]:
    """Yield sliders, and DOFs of contacts under varying normal loads.

    Each is a contact DOF, a stiffness [N/m], the force at which slip begins [N], the bound of the
    mean force [N], and the force compared with `onset` per contact displacement, (N_c,) [N/m].
    """
    for element in contacts.element:
        load = np.zeros(contacts.reference.size)
        if element["law"] == SLIDERS:
            column, first = element["column"][0], element["first_slider"]
            for limit, spring in contacts.slider[first : first + element["sliders"]]:
                load[column] = spring
                yield column, spring, limit, limit, load.copy()
            continue
        tangential, (normal,) = np.split(element["column"][: element["tangents"] + 1], [-1])
        load[tangential] = element["tangential_stiffness"]
        load[normal] = element["friction"] * element["normal_stiffness"]
        hold = element["friction"] * element["preload"]
        for column in tangential:
            yield column, element["tangential_stiffness"], hold, np.inf, load
        yield normal, element["normal_stiffness"], hold, np.inf, load


def said_error(modes: Sequence[str], error: Floats) -> str:
    """Return the largest relative errors (modes,) in words."""
    each = ", ".join(f"|{m}| {percentage(part)}" for m, part in zip(modes, error, strict=True))
    return f"estimated transient error: {each}"
