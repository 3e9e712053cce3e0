"""Models of damping and frequency that depend on the amplitudes, without contacts.

In free vibration the amplitudes obey da_j/dt = (s_j(|a|) - i Omega_j) a_j, s_j = -delta_j +
i omega_j. The amplitude equation, as rom/kernel/slow/slow_flow.c has it, has this solution with

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
from slipmode.rom.contact.error_norm import SMALLEST_SHARE, ErrorNorm
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.errors import Finding, SlipmodeError, naming, warn
from slipmode.rom.frequencies import (
    HIGHEST_CARRIER,
    LOWEST_CARRIER,
    can_carry,
    mode_frequency_findings,
)
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.representable import ALLOWED, LARGEST, fits
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.rates.decay_rates import decay_rates
from slipmode.rom.slow.rates.rate_samples import (
    friction_terms,
    modes_at_rest,
    node_amplitudes,
    with_rate_correction,
)
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.hermite import Table
from slipmode.rom.table.model import Model
from slipmode.rom.table.refinement.refine import refine
from slipmode.rom.table.refinement.sampling import Sampling
from slipmode.rom.table.tabulation import check_request

Rates = Callable[[Floats], tuple[ArrayLike, ArrayLike]]


def model_of_rates(
    rates: Rates,
    amplitude: Sequence[float],
    tolerance: float = 1e-3,
    *,
    mode_shapes: ArrayLike | None = None,
    samples: Sequence[Rates] = (),
    warned: bool = True,
) -> Model:
    """Return a model of one or two modes with given damping and frequency of free vibration.

    The rates may come from measurements. The model has no contacts. All functions for models
    accept it, except functions that scale or vary friction limits.

    Parameters
    ----------
    rates : callable
        Function ``damping, frequency = rates(amplitudes)`` of amplitudes |a_j| (points, modes)
        [kg^1/2 m]. It returns the damping delta_j [1/s] and the frequency omega_j [rad/s] of free
        vibration, (points, modes) each, and is defined from 0 to `amplitude`. They mean
        q_j = 2 |a_j| cos(theta_j), d|a_j|/dt = -delta_j |a_j|, dtheta_j/dt = omega_j.
    amplitude : sequence of one or two float
        Largest amplitude |a_j| of each mode [kg^1/2 m].
    tolerance : float, default 0.001
        Relative error of the amplitude equation [-], as in `rom.tabulate`. `Model.accuracy` states
        the error that is reached.
    mode_shapes : (n, modes) array_like, optional
        Mass-normalised mode shapes at the DOFs of sensors and forces [kg^-1/2]. Mode j moves DOF i
        with the displacement amplitude 2 |mode_shapes[i, j]| |a_j| [m]. At a DOF with the modal
        mass m the entry is 1 / sqrt(m). Default: one DOF for each mode, with a modal mass of 1 kg.
    samples : sequence of callable
        Other rates that are as likely, for instance the samples of a posterior. They travel with
        the model, see `sample_of`, and are interpolated between the nodes of its table.
    warned : bool, default True
        Issue the warnings listed under Warns.

    Returns
    -------
    Model
        Model with `NoContacts`, for steady states, transients, curves and FMUs.

    Raises
    ------
    SlipmodeError
        If rates are not finite, or have a wrong shape. If a frequency is outside 0.62 to 10 times
        the frequency at rest, or both modes have one frequency at rest. If the tolerance cannot
        be reached.

    Warns
    -----
    ValidityWarning
        If the model misses the tolerance, because rates jump or change too fast for the slow flow.
        If the frequency of a mode is outside 1e-3 to 1e6 Hz.

    Notes
    -----
    With the rates s_j = -delta_j + i omega_j, and s_0j at rest, the friction terms are::

        S_j = (s_j - s_0j) (s_j - conj(s_0j)) |a_j|.

    The amplitude equations, source Eqs. (18) and (19), then have the solutions a_j ~ exp(s_j t) at
    constant rates. Modal damping and natural frequency of the model are the rates at rest.
    Negative damping makes a mode self-excited, see `rom.limit_cycles`. The friction terms do not
    depend on the forcing frequency. The model has no higher harmonics and no internal resonances.

    Steady vibration of this model has the damping of free vibration at equal amplitude. Friction
    contacts have less damping in steady vibration than in free vibration, because friction lags
    behind decaying amplitudes. Steady states of two masses whose frequency falls by 1.8 % differ
    by up to 1.7 % (tests/rom/slow/rates/test_model_of_rates.py).

    Examples
    --------
    A mode at 100 rad/s whose damping grows in proportion to its amplitude:

    >>> def rates(r):
    ...     return 0.5 + 100.0 * r, np.full_like(r, 100.0)
    >>> model = rom.model_of_rates(rates, amplitude=[0.01])
    >>> rom.backbone(model, amplitude=[0.005]).damping
    array([0.01])
    """
    ends = np.atleast_1d(as_floats("amplitude", amplitude))
    check_request(ends, min(max(ends.size, 1), 2), tolerance, amplitude)
    law = _RatesLaw(rates, ends.size)
    reduced = law.reduced(mode_shapes)
    modes, problem = ends.size, ContactProblem(reduced, NoContacts())
    sampling = Sampling(law.sample, problem, ends, noise=0.0)
    table, _, error = refine(sampling, tolerance, TimeBudget(np.inf))
    table = law.corrected(table)
    points, nodes = node_amplitudes(table), tuple(axis.size for axis in table.axes)
    with naming("samples"):
        others = [_RatesLaw(each, modes).exponent(points.reshape(-1, modes)) for each in samples]
    nothing = np.zeros((*nodes, modes, 0))
    carriers = Harmonics(table.axes, CARRIERS[:modes], nothing.astype(complex), nothing[..., 0, :])
    accuracy = Accuracy(tolerance, error, solved=law.sampled)
    model = Model(reduced, NoContacts(), table, carriers, (), accuracy)
    if others:
        model = replace(model, samples=np.stack(others).reshape(-1, *points.shape))
    model = replace(model, accuracy=replace(accuracy, resolution=_decay_error(model, law)))
    if warned:
        warn(mode_frequency_findings("AB", reduced.frequency))
        warn(_findings(model.accuracy))
    return model


def _decay_error(model: Model, law: _RatesLaw) -> float:
    """Return the largest error of free vibration at the nodes, as an error of S_j.

    The slow flow is of first order in the rates: the error grows with the square of their change.
    """
    axes = np.meshgrid(*model.table.axes, indexing="ij")
    points = np.stack(axes, axis=-1).reshape(-1, model.modes)
    norm = ErrorNorm.of(model.reduced, model.table.amplitude_range)
    points = points[norm.share(points) >= SMALLEST_SHARE]
    damping, frequency = decay_rates(model, points)
    off = np.abs(-damping + 1j * frequency - law.exponent(points))
    of_friction = 2.0 * model.reduced.frequency * points * off
    return float((of_friction / model.error_scale(points)).max())


def _findings(accuracy: Accuracy) -> list[Finding]:
    """Return a warning of rates that jump, or that change too much for the slow flow."""
    tolerance, jump, change = accuracy.tolerance, accuracy.interpolation, accuracy.resolution
    if max(jump, change) <= tolerance:
        return []
    choice, what = (
        ("jump at some amplitudes", "the friction table")
        if jump > tolerance
        else ("change strongly with the amplitude", "free vibration")
    )
    size = f"{percentage(max(jump, change))} (tolerance {percentage(tolerance)})"
    return [Finding("rates", choice, f"the relative error of {what} is up to {size}", "warning")]


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
                "rates: modes A and B must have different frequencies at rest, both have "
                f"{natural[0]:g} rad/s"
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
        follows = (np.abs(s) <= LARGEST) & (frequency > 0.0) & can_carry(at_rest, frequency)
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
        """Return the tabulated columns (points, modes + 1)."""
        self.sampled += len(amplitudes)
        return friction_terms(self.exponent(amplitudes), self._at_rest, amplitudes)

    def corrected(self, table: Table) -> Table:
        """Return the table with the rate correction."""
        points = node_amplitudes(table)
        s = self.exponent(points.reshape(-1, self._modes)).reshape(points.shape)
        return with_rate_correction(table, s)

    def reduced(self, mode_shapes: ArrayLike | None) -> Reduced:
        """Return the modes, which have no contacts."""
        modes = self._modes
        shapes = as_floats("mode_shapes", np.eye(modes) if mode_shapes is None else mode_shapes)
        if shapes.ndim != 2 or shapes.shape[1] != modes or not len(shapes) or not fits(shapes):
            raise SlipmodeError(
                f"mode_shapes: must be (n, {modes}) numbers, one row per DOF and one column per "
                f"mode [kg^-1/2], {ALLOWED}, got shape {shapes.shape}"
            )
        return modes_at_rest(self._at_rest, shapes)
