"""A full-order motion and the states that it starts from and ends in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import short_repr


@dataclass(frozen=True, eq=False)
class State:
    """Where a motion starts or ends.

    Attributes
    ----------
    time : float
        [s]
    displacement, velocity : (n,) ndarray
        Of every DOF of the structure [m], [m/s].
    contact_force : (N_c,) ndarray, optional
        Friction force [N]; by default what the law says at this velocity, 0 for a contact at rest
        under exact Coulomb friction, which the first step corrects. On elastic contacts it is
        what the law says at this displacement.
    contact_memory : ndarray, optional
        What elastic contacts remember, where their sliders are [m]; by default as at rest.
    """

    time: float
    displacement: Floats
    velocity: Floats
    contact_force: Floats | None = None
    contact_memory: Floats | None = None

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class FullMotion:
    """A motion at the times that were asked for.

    Attributes
    ----------
    time : (samples,) ndarray
        [s]
    displacement, velocity : (samples, outputs) ndarray
        [m], [m/s]
    contact_displacement, contact_velocity, contact_force : (samples, N_c) ndarray
        x_c = W^T x [m], x_c' [m/s], friction force [N]; along a normal direction N - N0.
    dissipated : (samples,) ndarray
        Work done on the contacts since the start [J]: energy lost to friction, and in elastic
        contacts what their springs hold more than at the start. That is 0 over a cycle.
    end : State
        From which `integrate` continues.
    steps : int
        Time steps taken.
    """

    time: Floats
    displacement: Floats
    velocity: Floats
    contact_displacement: Floats
    contact_velocity: Floats
    contact_force: Floats
    dissipated: Floats
    end: State
    steps: int

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class Record:
    """Samples as the core writes them.

    Attributes
    ----------
    displacement, velocity : (samples, outputs) ndarray
    contact : (samples, 3, N_c) ndarray
        Displacement, velocity and friction force.
    dissipated : (samples,) ndarray
    """

    displacement: Floats
    velocity: Floats
    contact: Floats
    dissipated: Floats

    __repr__ = short_repr

    @classmethod
    def empty(cls, samples: int, outputs: int, contacts: int) -> Record:
        """Room for so many samples."""
        return cls(
            np.empty((samples, outputs)),
            np.empty((samples, outputs)),
            np.empty((samples, 3, contacts)),
            np.empty(samples),
        )

    def rows(self, first: int, count: int) -> Record:
        """A view of `count` samples."""
        rows = slice(first, first + count)
        return Record(
            *(self.displacement[rows], self.velocity[rows]),
            *(self.contact[rows], self.dissipated[rows]),
        )

    def scratch(self) -> Record:
        """Room for a sample that nobody asked for."""
        return Record.empty(1, self.displacement.shape[1], self.contact.shape[2])

    def addresses(self) -> tuple[int, int, int, int]:
        """Where the core writes them."""
        arrays = (self.displacement, self.velocity, self.contact, self.dissipated)
        a, b, c, d = (array.ctypes.data for array in arrays)
        return a, b, c, d
