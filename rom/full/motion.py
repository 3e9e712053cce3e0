"""A full-order motion, and the states in which it starts and ends."""

from __future__ import annotations

from slipmode.rom.arrays import Floats
from slipmode.rom.short_repr import frozen


@frozen
class State:
    """Hold the state in which a motion starts or ends.

    Attributes
    ----------
    time : float
        Time [s].
    displacement, velocity : (n,) ndarray
        Displacement [m] and velocity [m/s] of every DOF.
    contact_force : (N_c,) ndarray, optional
        Forces of rigid friction [N]. Default: the force of the law at this velocity. For a contact
        at rest with exact Coulomb friction this is 0, which the first step corrects.
    contact_memory : ndarray, optional
        Memory of elastic contacts and their sliders [m], from a final state. Default: contacts
        that moved monotonically from rest to the present displacement.
    """

    time: float
    displacement: Floats
    velocity: Floats
    contact_force: Floats | None = None
    contact_memory: Floats | None = None


@frozen
class FullMotion:
    """Hold a motion at the sample times.

    Attributes
    ----------
    time : (samples,) ndarray
        Times of the samples [s].
    displacement, velocity : (samples, outputs) ndarray
        Displacements [m] and velocities [m/s] of the outputs.
    contact_displacement, contact_velocity, contact_force : (samples, N_c) ndarray
        Contact displacements x_c = W^T x [m], velocities [m/s] and forces [N]. Along a normal
        direction the force is N - N0.
    dissipated : (samples,) ndarray
        Work done on the contacts since the start [J]. It is the energy dissipated by friction
        plus the change of energy in the springs of elastic contacts, which is 0 over a cycle.
    end : State
        Final state, from which `full.integrate` continues.
    steps : int
        Number of time steps.
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
