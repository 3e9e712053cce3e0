"""Motions with an error estimate, from a time step and half of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.full.excitation import Excitation
from slipmode.rom.full.integration import Integrator
from slipmode.rom.full.motion import FullMotion, State
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.structure import Structure


@frozen
class Converged:
    """Hold the motion at half a time step, and its difference from the motion at the full step.

    Attributes
    ----------
    motion : FullMotion
        Motion of the finer run.
    displacement_error, velocity_error : (outputs,) ndarray
        RMS of the difference relative to the RMS of the signal [-]. It bounds the error of the
        finer run if halving the step at least halves the error. For motion that is smooth over a
        step it is about 15 times the error.
    contact_displacement_error, contact_velocity_error : (N_c,) ndarray
        RMS of the difference of contact motion, relative to the RMS of the signal [-].
    """

    motion: FullMotion
    displacement_error: Floats
    velocity_error: Floats
    contact_displacement_error: Floats
    contact_velocity_error: Floats


def converged(
    structure: Structure,
    law: Friction | Elastic,
    excitation: Excitation,
    times: ArrayLike,
    *,
    steps_per_period: float = 64,
    step: float | None = None,
    outputs: Sequence[int] | ArrayLike | None = None,
    start: State | None = None,
) -> Converged:
    """Return the motion at half a time step, and its difference from the motion at the full step.

    Parameters
    ----------
    structure : Structure
        Structure with free contacts.
    law : Tanh, Coulomb, or an elastic law
        Law of the contacts.
    excitation : Excitation
        Harmonic forces.
    times : (samples,) array_like or float
        Increasing times of the samples [s]. A number is the end, with samples at all steps of the
        coarser run.
    steps_per_period : float, default 64
        Smallest number of steps per period of the fastest forcing, in the coarser run.
    step : float, optional
        Largest time step of the coarser run [s], instead of `steps_per_period`.
    outputs : sequence of int, or (outputs, n) array_like, optional
        DOFs whose displacement is returned, or rows that combine DOFs. Default: all DOFs.
    start : State, optional
        Initial state. Default: undeformed and at rest.

    Returns
    -------
    Converged
        Motion of the finer run, and relative differences.

    Raises
    ------
    SlipmodeError
        If an argument is not allowed, or the motion grows without bound.
    """
    integrator = Integrator(structure, law, excitation, outputs, steps_per_period, step)
    coarse = integrator.run(times, start)
    fine = integrator.run(times, start, refine=2)
    signals = ("displacement", "velocity", "contact_displacement", "contact_velocity")
    errors = {
        f"{name}_error": relative_rms(getattr(coarse, name), getattr(fine, name))
        for name in signals
    }
    return Converged(fine, **errors)


def relative_rms(signal: Floats, reference: Floats) -> Floats:
    """Return the RMS difference relative to the RMS of the reference, per column; 0 if equal."""
    difference = np.linalg.norm(signal - reference, axis=0)
    size = np.linalg.norm(reference, axis=0)
    error = np.divide(difference, size, out=np.full(size.shape, np.inf), where=size > 0)
    error[difference == 0.0] = 0.0
    return np.asarray(error)
