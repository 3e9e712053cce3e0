"""A full-order motion, and the states in which it starts and ends."""

from __future__ import annotations

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen


@frozen
class State:
    """The state in which a motion starts or ends.

    Attributes
    ----------
    time : float
        [s]
    displacement, velocity : (n,) ndarray
        Of every DOF of the structure [m], [m/s].
    contact_force : (N_c,) ndarray, optional
        Force of rigid friction [N]; by default the law's force at this velocity. For a contact at
        rest under exact Coulomb friction that is 0, which the first step corrects.
    contact_memory : ndarray, optional
        Memory of elastic contacts and their sliders [m], of an end state. By default they moved
        monotonically from rest to here.
    """

    time: float
    displacement: Floats
    velocity: Floats
    contact_force: Floats | None = None
    contact_memory: Floats | None = None


@frozen
class FullMotion:
    """A motion at the sample times.

    Attributes
    ----------
    time : (samples,) ndarray
        [s]
    displacement, velocity : (samples, outputs) ndarray
        [m], [m/s]
    contact_displacement, contact_velocity, contact_force : (samples, N_c) ndarray
        x_c = W^T x [m], x_c' [m/s], friction force [N]; along a normal direction N - N0.
    dissipated : (samples,) ndarray
        Work done on the contacts since the start [J]: energy lost to friction, and the change of
        the energy in the springs of elastic contacts, which is 0 over a cycle.
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
