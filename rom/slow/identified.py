"""Models of damping and frequency that depend on the amplitudes, without contacts.

In free vibration the amplitudes obey da_j/dt = (s_j(|a|) - i Omega_j) a_j, s_j = -delta_j +
i omega_j. The amplitude equation, as rom/kernel/slow/first_order.c has it, has this solution with

    S_j = (s_j - s_0j) (s_j - conj(s_0j)) |a_j|,    dS_j / d(d|a_k|/dt) = |a_j| ds_j / d|a_k|,

gamma_j = 2 delta_0j and |s_0j| for damping and natural frequency of the mode; s_0j is s_j at rest.
S_j is the friction term of steady motion, the other its rate correction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.contact.error_norm import ErrorNorm
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.errors import SlipmodeError, warn
from slipmode.rom.frequencies import (
    HIGHEST_CARRIER,
    LOWEST_CARRIER,
    can_carry,
    mode_frequency_findings,
)
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.representable import ALLOWED, fits
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.hermite import Table, surface_slopes, surface_values
from slipmode.rom.table.model import Model
from slipmode.rom.table.refinement.refine import refine
from slipmode.rom.table.refinement.sampling import Sampling, amplitude_pairs
from slipmode.rom.table.tabulation import check_request

Rates = Callable[[Floats], tuple[ArrayLike, ArrayLike]]


def model_of_rates(
    rates: Rates,
    amplitude: Sequence[float],
    tolerance: float = 1e-3,
    *,
    mode_shapes: ArrayLike | None = None,
    warned: bool = True,
) -> Model:
    """Return the model of one or two modes with given damping and frequency of free vibration.

    The rates may come from measurements. The model has no contacts. Everything else works as with
    a model of `rom.tabulate`, except what scales or varies friction limits.

    Parameters
    ----------
    rates : callable
        ``damping, frequency = rates(amplitudes)``: damping delta_j [1/s] and frequency omega_j
        [rad/s] of free vibration, arrays (points, modes), at amplitudes |a_j| (points, modes)
        [kg^1/2 m]. A function of the amplitudes alone, defined from 0 to `amplitude`. Then
        q_j = 2 |a_j| cos(theta_j), d|a_j|/dt = -delta_j |a_j|, dtheta_j/dt = omega_j.
    amplitude : sequence of one or two float
        Largest amplitude |a_j| of each mode [kg^1/2 m].
    tolerance : float
        Relative error of the amplitude equation, as in `rom.tabulate`. `Model.accuracy` states
        the error that is reached.
    mode_shapes : (n, modes) array_like, optional
        Mass-normalised modes at the DOFs of sensors and forces [kg^-1/2]: 1 / sqrt(m) at the DOF
        at which m is the modal mass. A sensor has the displacement amplitude
        2 |mode_shapes @ a|. Default: one DOF for each mode, with a modal mass of 1 kg.
    warned : bool
        Warn of implausible frequencies, and of rates that jump.

    Raises
    ------
    SlipmodeError
        If rates are not finite, have another shape, or a frequency is outside 0.62 to 10 times
        the frequency at rest; if the modes have the same frequency at rest; if the tolerance
        cannot be reached.

    Warns
    -----
    ValidityWarning
        If the table misses the tolerance, because the rates jump; if the frequency of a mode is
        outside 1e-3 to 1e6 Hz.

    Notes
    -----
    Damping may be negative: then the mode is self-excited, see `rom.limit_cycles`. Modal damping
    and natural frequency of the model are those at rest. The friction terms do not depend on the
    forcing frequency. Rates at higher harmonics and internal resonances of the modes are not part
    of the model. Steady vibration at an amplitude has the damping of free vibration there.
    """
    ends = np.atleast_1d(as_floats("amplitude", amplitude))
    check_request(ends, min(max(ends.size, 1), 2), tolerance, amplitude)
    law = _RatesLaw(rates, ends.size)
    reduced = law.reduced(mode_shapes)
    norm, modes = ErrorNorm.of(reduced, ends), ends.size
    sampling = Sampling(
        law.sample,
        orders=(*CARRIERS[:modes], CARRIERS[0]),
        drives=tuple(range(modes)),
        norm=norm,
        carrier=reduced.carrier,
        loss=norm.loss,
        amplitude_range=ends,
        onset_lines=np.zeros((0, modes)),
        noise=0.0,
    )
    table, _, error = refine(sampling, tolerance, TimeBudget(np.inf))
    accuracy = Accuracy(
        tolerance=tolerance,
        interpolation=error,
        resolution=0.0,
        periodicity=0.0,
        neglected_response=0.0,
        neglected_modes=0.0,
        detuning=0.0,
        steps=0,
        lines=0,
        solved=law.sampled,
    )
    if warned:
        warn(mode_frequency_findings("AB", reduced.frequency))
        warn(accuracy.findings())
    nodes = tuple(axis.size for axis in table.axes)
    nothing = np.zeros((*nodes, modes, 0))
    carriers = Harmonics(table.axes, CARRIERS[:modes], nothing.astype(complex), nothing[..., 0, :])
    return Model(reduced, NoContacts(), law.corrected(table), carriers, (), accuracy)


class _RatesLaw:
    """The friction terms of given rates."""

    def __init__(self, rates: Rates, modes: int) -> None:
        self._rates, self._modes = rates, modes
        self.sampled = 0  # points
        self._at_rest = np.zeros(modes, dtype=complex)
        self._at_rest = self.exponent(np.zeros((1, modes)))[0]  # s_0j
        natural = np.abs(self._at_rest)
        if modes == 2 and natural[0] == natural[1]:
            raise SlipmodeError(
                f"rates: modes A and B must have different frequencies at rest, got {natural[0]:g} "
                "rad/s for both"
            )

    def exponent(self, amplitudes: Floats) -> Complexes:
        """Return s_j = -delta_j + i omega_j (points, modes), checked, at (points, modes)."""
        given: Any = self._rates(amplitudes.copy())
        if not isinstance(given, tuple | list) or len(given) != 2:
            raise SlipmodeError(
                f"rates: must return damping [1/s] and frequency [rad/s], got {in_one_line(given)}"
            )
        damping, frequency = (as_floats("rates", each) for each in given)
        for name, values in (("damping", damping), ("frequency", frequency)):
            if values.shape != amplitudes.shape:
                raise SlipmodeError(
                    f"rates: {name} must have the shape of the amplitudes (points, modes), "
                    f"{amplitudes.shape}, got {values.shape}"
                )
        s = -damping + 1j * frequency
        at_rest = np.abs(self._at_rest) if self._at_rest.any() else frequency[0]
        follows = np.isfinite(s) & (frequency > 0.0) & can_carry(at_rest, frequency)
        if not follows.all():
            point, j = np.argwhere(~follows)[0]
            where = ", ".join(f"{each:.4g}" for each in amplitudes[point])
            raise SlipmodeError(
                f"rates: damping must be finite and the frequency {LOWEST_CARRIER:g} to "
                f"{HIGHEST_CARRIER:g} times the frequency at rest; mode {'AB'[j]} has "
                f"{damping[point, j]:g} 1/s and {frequency[point, j]:g} rad/s at amplitudes "
                f"{where} kg^1/2 m"
            )
        return np.asarray(s)

    def sample(self, amplitudes: Floats, near: Complexes | None = None) -> Complexes:
        """Return S_j, and no power that is lost elsewhere, (points, modes + 1)."""
        self.sampled += len(amplitudes)
        s, rest = self.exponent(amplitudes), self._at_rest
        S = (s - rest) * (s - rest.conj()) * amplitudes
        return np.hstack((S, np.zeros((len(S), 1))))

    def corrected(self, table: Table) -> Table:
        """Return the table with the rate correction, which makes free vibration exact."""
        modes, nodes = self._modes, (table.node_a, table.node_b)
        points = amplitude_pairs(*nodes, modes)
        s = self.exponent(points.reshape(-1, modes)).reshape(points.shape)
        slopes = surface_slopes(*nodes, s, [(0, 0)] * modes)[..., :modes]  # by j and k
        samples = (points[..., np.newaxis] * slopes).reshape(*points.shape[:2], modes**2)
        odd = [(j != k, j != k) for j in range(modes) for k in range(modes)]
        return replace(table, rate_correction=surface_values(*nodes, samples, odd))

    def reduced(self, mode_shapes: ArrayLike | None) -> Reduced:
        """Return the modes, which have no contacts."""
        modes = self._modes
        shapes = as_floats("mode_shapes", np.eye(modes) if mode_shapes is None else mode_shapes)
        if shapes.ndim != 2 or shapes.shape[1] != modes or not len(shapes) or not fits(shapes):
            raise SlipmodeError(
                f"mode_shapes: must be (n, {modes}) numbers, one row per DOF and one column per "
                f"mode [kg^-1/2], {ALLOWED}, got shape {shapes.shape}"
            )
        n, none = len(shapes), np.zeros((0, 0))
        uncoupled, no_modes = np.zeros((modes, 0)), np.zeros(0)
        return Reduced(
            formulation="consistent",
            modes=tuple(range(modes)),
            frequency=np.abs(self._at_rest),
            carrier=np.abs(self._at_rest),
            modal_damping=-2.0 * self._at_rest.real,
            mode_shapes=shapes.copy(),
            contact_shapes=np.zeros((n, 0)),
            mass=none,
            damping=none,
            stiffness=none,
            spring=uncoupled,
            damper=uncoupled,
            contact_motion=uncoupled.astype(complex),
            carried_mass=none,
            nonresonant_frequency=no_modes,
            nonresonant_damping=no_modes,
            nonresonant_shapes=np.zeros((n, 0)),
            nonresonant_spring=none,
            nonresonant_inertia=none,
            nonresonant_damper=none,
            damping_coupling=np.zeros((modes, modes)),
            contacts=NoContacts().elements(0),
        )
