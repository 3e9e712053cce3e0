"""A steady state by integration in time from rest, of the structure that a reduced model has.

For motions that a balance of harmonics does not find: contacts that stick, slip and part so
abruptly that no iteration over harmonics settles. What integration finds is steady, but need not
be periodic: a motion with lines beside n Omega_A + m Omega_B is refused.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.bases.reduced_structure import ReducedStructure
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.motion import State
from slipmode.rom.full.steady import (
    OFF_LATTICE,
    SteadyAmplitude,
    beside_harmonics,
    steady_amplitude,
)
from slipmode.rom.full.window import Window
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import harmonic_orders
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.slow.direct.forced_balance import SteadyHarmonics
from slipmode.rom.slow.direct.receptance import Receptance

_HIGHEST = {1: 31, 2: 13}  # |n| + |m| of the harmonics that are told
_STEPS = (64, 128, 256)  # per period of the fastest carrier, till these reach the tolerance
# Windows: periods of the slowest carrier, and how many. Contacts draw lines of high order near the
# carriers, which shorter windows do not tell from them.
_WINDOWS = ((200.0, 20), (1000.0, 8))
_SAFETY = 2.0
_DECAYS, _MOST_PERIODS = 7.0, 1000.0  # e-folds of a transient, periods of the slowest carrier
_STAGES = 6  # of a time step
_ONE_STAGE = 150.0  # what it takes beside its contacts


def integration_effort(reduced: Reduced) -> float:
    """What it takes, in the unit of `Effort`, until structural damping has ended a transient."""
    slow, fast = reduced.carrier.min(), reduced.carrier.max()
    damped = _DECAYS * slow / (np.pi * max(reduced.modal_damping.min(), np.finfo(float).tiny))
    steps = (min(damped, _MOST_PERIODS) + _MOST_PERIODS) * fast / slow * 3 * _STEPS[0] * _STAGES
    contacts, modes = reduced.n_contacts, len(reduced.damping_coupling)
    return float(steps * (_ONE_STAGE + contacts * (2 * contacts + modes)))


def integrated(
    reduced: Reduced, law: Friction, force: Floats, tolerance: float
) -> tuple[Floats, SteadyHarmonics]:
    """Error (modes,) and harmonics of the steady motion under forces (modes, n).

    Raises
    ------
    SlipmodeError
        If it is not periodic in the phases of the carriers, or does not become steady.
    """
    small = ReducedStructure.of(reduced)
    modes = len(reduced.modes)
    excitation = Excitation.harmonic(small.structure, list(force @ small.shapes), reduced.carrier)
    rows = np.eye(small.shapes.shape[1])[:modes]
    start = None
    for steps in _STEPS:
        found = _settled(small, law, excitation, rows, 0.2 * tolerance, steps, start)
        start = found.end
        error = _SAFETY * np.diagonal(found.error)
        if np.all(error <= tolerance * np.abs(np.diagonal(found.amplitude))):
            break
    return error, _harmonics(reduced, law, force, excitation, small, found, steps)


def _settled(
    small: ReducedStructure,
    law: Friction,
    excitation: Excitation,
    rows: Floats,
    tolerance: float,
    steps: int,
    start: State | None,
) -> SteadyAmplitude:
    """With the shortest windows that do."""
    for periods, most in _WINDOWS:
        try:
            return steady_amplitude(
                *(small.structure, law, excitation),
                outputs=rows,
                tolerance=tolerance,
                steps_per_period=steps,
                start=start,
                most_windows=most,
                periods=periods,
            )
        except SlipmodeError as reason:
            last = reason
    raise last


def _harmonics(
    reduced: Reduced,
    law: Friction,
    force: Floats,
    excitation: Excitation,
    small: ReducedStructure,
    found: SteadyAmplitude,
    steps: int,
) -> SteadyHarmonics:
    """Of the motion from where the amplitudes were found on."""
    assert reduced.contacts is not None
    carrier, modes = reduced.carrier, len(reduced.modes)
    nothing_but_contacts = np.zeros((0, small.structure.n_dofs))
    integrator = Integrator(small.structure, law, excitation, nothing_but_contacts, 2 * steps)
    motion, beside = beside_harmonics(integrator, found.end)
    if beside.share > OFF_LATTICE:
        raise SlipmodeError(
            "frequency: the motion from rest is not periodic in the phases of the forces: "
            f"{beside.share:.0%} of the contacts' is at other frequencies, most at "
            f"{beside.frequency:.4g} rad/s; move the forcing, give damping to the modes near by, "
            "or integrate in time (rom.full)"
        )
    orders = harmonic_orders(_HIGHEST[modes], modes, reduced.even)
    nu = np.array(orders, dtype=float)[:, :modes] @ carrier
    window = Window.of_lines(excitation)
    short = motion.contact_displacement * reduced.contacts.reference - motion.contact_force
    P = window.project(motion.time, short, nu)
    # of what was integrated the other modes are only a part of what moves with the contacts
    modal = Receptance.of(reduced, orders, 0.5 * force).modal(P)
    amplitude = np.diagonal(found.amplitude).copy()
    modal[np.arange(modes), np.arange(modes)] = amplitude
    return SteadyHarmonics(amplitude, orders, nu, modal, P)
