"""Damping and frequency of free vibration at any amplitudes, by the slow flow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.slow.slow_flow import inputs_of, rates, shifted_flow
from slipmode.rom.table.hermite import outside_table
from slipmode.rom.table.model import Model


def decay_rates(model: Model, amplitudes: ArrayLike) -> tuple[Floats, Floats]:
    """Return damping and frequency of free vibration at given amplitudes.

    Parameters
    ----------
    model : Model
        Model with one or two modes.
    amplitudes : (..., modes) array_like
        Amplitudes |a_j| >= 0 of all modes, which vibrate together [kg^1/2 m].

    Returns
    -------
    damping : (..., modes) ndarray
        Damping delta_j = -d|a_j|/dt / |a_j| [1/s], including structural damping.
    frequency : (..., modes) ndarray
        Frequency omega_j [rad/s].

    Raises
    ------
    SlipmodeError
        If an amplitude is negative, not finite, or outside the friction table.

    Notes
    -----
    The rates solve the amplitude equations, source Eqs. (18) and (19), without forces:
    da_j/dt = -delta_j a_j in the frame of omega_j. Combination resonances are neglected, because
    their mean over the phases of the modes is zero. `rom.model_of_rates` is the inverse function.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(4.0,))
    >>> damping, frequency = rom.decay_rates(model, [3.0])
    >>> damping.round(4), frequency.round(3)
    (array([0.0118]), array([0.983]))
    """
    model.refuse_spin("a free vibration")
    given = as_floats("amplitudes", amplitudes)
    if given.ndim == 0 or given.shape[-1] != model.modes:
        raise SlipmodeError(
            f"amplitudes: must have a last axis of length {model.modes}, got shape {given.shape}"
        )
    if not np.all(np.isfinite(given) & (given >= 0.0)):
        raise SlipmodeError("amplitudes: must be finite numbers >= 0 [kg^1/2 m]")
    table = model.table
    # a mode at rest has the rates of a small amplitude, to which friction is in proportion
    points = np.maximum(given, 1e-9 * table.amplitude_range).reshape(-1, model.modes)
    if np.any(points > table.amplitude_range):
        raise outside_table(points, table)
    values = table.values.copy()
    values[..., 2 * model.modes : 2 * (model.modes + len(model.combinations))] = 0.0
    flow = shifted_flow(replace(model, table=replace(table, values=values)), 0.0)
    a = points.astype(complex)
    frequency = np.tile(model.reduced.frequency, (len(points), 1))
    for _ in range(50):
        growth = rates(flow, inputs_of(np.zeros_like(a), frequency), a) / a
        frequency = frequency + growth.imag
        if np.abs(growth.imag).max(initial=0.0) <= 1e-13 * frequency.max(initial=1.0):  # rounding
            break
    return -growth.real.reshape(given.shape), frequency.reshape(given.shape)
