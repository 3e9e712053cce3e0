"""Backbones: frequency and damping of a nonlinear mode against its amplitude.

A negative damping -2 zeta Omega x' that holds a mode at a constant amplitude makes it move like a
damped nonlinear mode. In the extended periodic motion concept (Krack 2015) it acts on all modes
and harmonics, here only on the first harmonic of the mode. In the slow flow that is

    omega^2 - Omega^2 + i gamma Omega - Q(|a|) = 2 i zeta Omega^2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.answer_error import TableError, off_carrier_findings
from slipmode.rom.slow.branches.curve_result import ModeCurve, axes_or_new, methods, plot_band
from slipmode.rom.slow.branches.solve_points import flow_at_amplitudes
from slipmode.rom.slow.direct.contact_friction import (
    ContactFriction,
    ContactPoints,
    ContactSolutions,
    has_contact_problem,
)
from slipmode.rom.slow.slow_flow import ForcedFlow, rates
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.steady_points import INSIDE
from slipmode.rom.slow.units import SI, Shown, Units
from slipmode.rom.table.model import Model
from slipmode.rom.validity import warn

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SMALLEST, _LARGEST = 1e-3, INSIDE  # amplitudes, relative to the table's range


@frozen
class Backbone(ModeCurve):
    """Hold a damped nonlinear mode: frequency and damping against the amplitude.

    Attributes
    ----------
    motion : SteadyMotion
        Motion of all DOFs, without forces.
    mode : int
        0 for A, 1 for B.
    amplitude : (n,) ndarray
        Amplitudes |a| of the mode [kg^1/2 m].
    other : float
        Amplitude |a| of the other mode, at its carrier [kg^1/2 m].
    frequency : (n,) ndarray
        Frequencies Omega [rad/s].
    frequency_error : (n,) ndarray
        Error of Omega due to the friction table and the distance from its carriers [rad/s].
    damping : (n,) ndarray
        Damping ratio zeta of steady vibration [-].
    damping_error : (n,) ndarray
        Error of zeta due to the friction table and the distance from its carriers [-].
    decay : (n,) ndarray
        Rate -d|a|/dt / |a| of free vibration [1/s]. It is zeta Omega for slow decay; in a faster
        decay friction lags behind the amplitude.
    method : (n,) ndarray of str
        Friction at each amplitude: "table", or "direct" for the contact problem itself.
    """

    amplitude: Floats
    other: float
    frequency: Floats
    frequency_error: Floats
    damping: Floats
    damping_error: Floats
    decay: Floats
    method: NDArray[np.str_]

    def _values(self, units: Units) -> dict[str, Floats]:
        rest = {name: getattr(self, name) for name in ("damping", "damping_error", "decay")}
        omega = units.frequencies(frequency=self.frequency, frequency_error=self.frequency_error)
        return {"amplitude": self.amplitude} | omega | rest

    def _dof_sizes(self, dof: int, units: Units) -> dict[str, Floats]:
        return {"amplitude": self.size(Shown(dof, units))}

    def plot(
        self, axes: tuple[Axes, Axes] | None = None, dof: int | None = None, units: Units = SI
    ) -> Any:
        """Plot frequency and damping ratio against the amplitude, with their errors.

        Parameters
        ----------
        axes : pair of Axes, optional
            Matplotlib axes. Default: a new figure.
        dof : int, optional
            DOF whose displacement amplitude is plotted. Default: |a| of the mode.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        pair of Axes
            Axes of the plots.
        """
        axes = axes_or_new(axes, 2, 1, sharex=True)
        shown, per = Shown(dof, units), units.per_frequency
        amplitude = self.size(shown)
        above = units.frequency_label, self.frequency / per, self.frequency_error / per
        below = "damping [-]", self.damping, self.damping_error
        for ax, (name, values, error) in zip(axes, (above, below), strict=True):
            ax.semilogx(amplitude, values)
            plot_band(ax, amplitude, values, error)
            ax.set_ylabel(name)
        axes[1].set_xlabel(shown.named("amplitude"))
        return axes


def backbone(
    model: Model, mode: int = 0, other: float = 0.0, amplitude: Floats | None = None
) -> Backbone:
    """Return frequency and damping of a mode against its amplitude.

    Friction is the table's, or of the contact problem at the frequencies of the mode where the
    table misses it.

    Parameters
    ----------
    model : Model
        Model whose carriers are near the frequencies of the backbone.
    mode : int, default 0
        0 for A, 1 for B.
    other : float, default 0.0
        Amplitude |a| of the other mode [kg^1/2 m].
    amplitude : (n,) array_like, optional
        Amplitudes |a| > 0 [kg^1/2 m]. Default: 200 logarithmically spaced values, from 1e-3 of the
        range of the table.

    Returns
    -------
    Backbone
        Frequency, damping ratio and decay rate with their errors.

    Raises
    ------
    SlipmodeError
        If there is no such mode, or an amplitude is outside the friction table. If the iteration
        for the frequency does not converge.

    Warns
    -----
    ValidityWarning
        If the frequency is so far from the carrier that the error exceeds the tolerance, or the
        contact problem does not converge at some amplitudes, which keep the friction of the table.

    Notes
    -----
    A negative damping -2 zeta Omega x' of the first harmonic of the mode keeps the amplitude
    constant and defines the damped nonlinear mode::

        omega^2 - Omega^2 + i gamma Omega - Q(|a|) = 2 i zeta Omega^2.

    See "Backbones" in docs/theory.md.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(4.0,))
    >>> curve = rom.backbone(model, amplitude=[1.0, 3.0])
    >>> curve.frequency.round(3), curve.damping.round(4)
    (array([1.   , 0.983]), array([0.005 , 0.0119]))
    """
    model.check_mode(mode)
    if not (np.ndim(other) == 0 and as_floats("other", other) >= 0.0):
        raise SlipmodeError(f"other: must be a number >= 0 [kg^1/2 m], got {other}")
    if model.modes == 1 and other != 0.0:
        raise SlipmodeError(f"other: must be 0 in a model of one mode, got {other}")
    if amplitude is None:
        largest = model.table.amplitude_range[mode]
        r = np.geomspace(_SMALLEST * largest, _LARGEST * largest, 200)
    else:
        r = np.atleast_1d(as_floats("amplitude", amplitude))
        if r.ndim > 1 or r.size == 0 or not np.all(np.isfinite(r) & (r > 0.0)):
            raise SlipmodeError("amplitude: must be finite numbers > 0 [kg^1/2 m]")
    found, worst = tabulated_backbone(model, mode, other, r)
    if worst > model.accuracy.tolerance and has_contact_problem(model):
        found, worst = _without_table(found, worst)
    apart = found.frequency / model.reduced.carrier[mode] - 1.0
    warn(off_carrier_findings(model.accuracy.tolerance, worst, apart, "the damping"))
    return found


def tabulated_backbone(
    model: Model, mode: int, other: float, amplitude: Floats
) -> tuple[Backbone, float]:
    """Return the backbone with the friction of the table, and its largest error.

    It is relative to the damping, where friction misses what the table states at its carriers.
    """
    a = np.full((amplitude.size, model.modes), abs(other), dtype=complex)
    a[:, mode] = amplitude
    model.table(np.abs(a))  # refuses what is outside
    start = np.tile(model.reduced.carrier, (amplitude.size, 1))
    start[:, mode] = model.reduced.frequency[mode]
    flow, force_ratio, found = phase_resonance(ForcedFlow.of(model, start), mode, a, 0.0)
    refuse_lost(
        found,
        a[:, mode],
        "it leaves the friction table, or friction depends strongly on the frequency; tabulate a "
        "larger range, or call rom.reduce with carrier = the frequency of the mode there",
    )
    return _backbone(flow, force_ratio, mode, a)


def _without_table(given: Backbone, worst: float) -> tuple[Backbone, float]:
    """Return a backbone with friction from the contact problem, and its largest error.

    Amplitudes at which the contact problem does not converge keep the friction of the table, with
    its stated error.
    """
    mode, a = given.mode, given.motion.amplitude
    start = ForcedFlow.of(given.motion.model, given.motion.frequency)
    friction = ContactFriction.of(start.model, None)
    flow, force_ratio, found = phase_resonance(
        start, mode, a, 0.0, lambda flow: friction(ContactPoints.of(flow, a))
    )
    if not found.any():
        return given, worst
    part = flow.with_inputs(flow.inputs[found])
    direct, error = _backbone(part, force_ratio[found], mode, a[found], friction)
    if found.all():
        return direct, error
    lost = given.amplitude[~found]
    _, worst = tabulated_backbone(start.model, mode, given.other, lost)
    where = f"at |a| = {lost.min():.3g} to {lost.max():.3g} kg^1/2 m"
    reason = "the contact problem does not converge there. Compare with rom.steady_state"
    warn([Finding("backbone", f"has the friction of the table {where}", reason, "warning")])

    def joined(table: Any, of_contacts: Any) -> Any:
        every = table.copy()
        every[found] = of_contacts
        return every

    names = ("frequency", "frequency_error", "damping", "damping_error", "decay", "method")
    values = {name: joined(getattr(given, name), getattr(direct, name)) for name in names}
    motion = replace(
        given.motion,
        frequency=joined(given.motion.frequency, direct.motion.frequency),
        contact=ContactSolutions(friction, np.zeros((len(a), 0), dtype=complex)),
        tabulated=~found,
    )
    return replace(given, motion=motion, **values), max(error, worst)


def _backbone(
    flow: ForcedFlow,
    force_ratio: Complexes,
    mode: int,
    a: Complexes,
    friction: ContactFriction | None = None,
) -> tuple[Backbone, float]:
    """Return the backbone with its largest error, see `tabulated_backbone`.

    `flow` and `force_ratio` are of `phase_resonance` at the amplitudes a (points, modes).
    `friction` is not given if it is the table's.
    """
    model, r, Omega = flow.model, np.abs(a[:, mode]), flow.frequency[:, mode]
    rate, contact = rates(flow.flow, flow.inputs, a)[:, mode], None
    if friction is not None:
        contact = ContactSolutions(friction, np.zeros((r.size, 0), dtype=complex))
        now = flow.balance(a)
        Q = now.stiffness[:, mode] - 0.5 * force_ratio
        rate = rate + (Q * a[:, mode] - now.friction[:, mode]) / now.mass[:, mode]
    loss = 0.5 * force_ratio.imag
    zeta = loss / (2.0 * Omega**2)
    table_error = TableError.of(flow, a, None, contact)
    at, size = table_error.at, table_error.scale[:, mode] / r
    measured = table_error.measured[:, mode] / r[at]
    share = np.abs(np.stack((measured.real, measured.imag), axis=-1)) / size[at, np.newaxis]
    stated = table_error.stated[:, mode] / r
    of_stiffness, of_loss = table_error.between(share).T * size + stated
    frequency_error = of_stiffness / (2.0 * Omega)
    damping_error = of_loss / (2.0 * Omega**2) + 2.0 * np.abs(zeta) * frequency_error / Omega
    # A loss below the rounding error of the stiffness is 0, as of an undamped mode that sticks.
    loss = np.maximum(np.abs(loss), np.finfo(float).eps * Omega**2) * r
    change = np.nan_to_num(np.abs(table_error.measured[:, mode]), nan=np.inf)
    change[change <= model.accuracy.total * table_error.scale[at, mode]] = 0.0
    worst = float((change / loss[at]).max(initial=0.0))
    other = float(np.abs(np.delete(a[0], mode)).sum())
    motion = replace(SteadyMotion.of(flow, a, None), contact=contact)
    errors = frequency_error, zeta, damping_error
    by = methods(np.full(r.shape, friction is not None))
    return Backbone(motion, mode, r, other, Omega, *errors, -rate.real / r, by), worst


def phase_resonance(
    start: ForcedFlow,
    mode: int,
    amplitude: Complexes,
    shift: complex,
    friction: Callable[[ForcedFlow], Complexes] | None = None,
) -> tuple[ForcedFlow, Complexes, Flags]:
    """Return the flow in which the force of a mode is a quarter of a cycle ahead of the mode.

    The contacts move with the amplitudes A = a + shift F (points, modes), so that

        (stiffness - Q) a = F / 2 + Q shift F.

    `start` is the flow without forces at the frequencies from which Newton's method starts. The
    other results (points,) are F / a [rad^2/s^2], and whether a frequency is found. `friction` is
    as in `flow_at_amplitudes`.
    """
    takes_energy = friction_takes_energy(start.model, amplitude, mode)

    def force_ratio(stiffness: Complexes, Q: Complexes) -> Complexes:
        if takes_energy:
            Q = Q.real + 1j * np.minimum(Q.imag, 0.0)
        with np.errstate(invalid="ignore"):  # NaN where the contact motion does not converge
            return np.asarray((stiffness - Q) / (0.5 + shift * Q))

    def in_phase(stiffness: Complexes, Q: Complexes) -> Floats:
        return force_ratio(stiffness, Q).real

    flow, terms, found = flow_at_amplitudes(start, mode, amplitude, in_phase, friction)
    return flow, force_ratio(*terms), found


def refuse_lost(found: Flags, amplitude: Complexes, refusal: str) -> None:
    """Refuse amplitudes (points,) without a frequency; `refusal` is why there may be none."""
    if not found.all():
        raise SlipmodeError(
            f"amplitude: the frequency of the mode does not converge at "
            f"{abs(amplitude[~found][0]):.3g} kg^0.5 m, because {refusal}"
        )


def friction_takes_energy(model: Model, amplitude: Complexes, mode: int) -> bool:
    """Return whether Im Q <= 0 is known, so that positive values in a table are errors.

    It is for elastic contacts, if damping does not couple the modes and no energy comes from
    another mode.
    """
    reduced = model.reduced
    alone = not np.delete(amplitude, mode, axis=1).any() and not model.combinations
    elastic = reduced.contacts is not None and reduced.n_contacts > 0
    return elastic and alone and not reduced.damping_coupling.any()


def resonance_peaks(model: Model, mode: int, force: Floats) -> tuple[Floats, Floats]:
    """Return the highest resonance peaks of a mode under modal forces |F_j| (n,), and frequencies.

    The other mode is at rest. Peaks |a| (n,) [kg^1/2 m] and their frequencies [rad/s] are NaN
    outside the friction table. A mode that is self-excited or undamped is refused.
    """
    curve, held = phase_resonances(model, mode)
    r, Omega = np.append(0.0, curve.amplitude), np.append(curve.frequency[0], curve.frequency)
    held = np.append(0.0, held)
    least = np.minimum.accumulate(held[::-1])[::-1]  # of the forces from there on
    below = np.searchsorted(least, force, side="right") - 1  # the last amplitude they exceed
    inside = below < held.size - 1
    k = np.where(inside, below, 0)
    part = (force - held[k]) / (held[k + 1] - held[k])
    peak, frequency = (each[k] + part * (each[k + 1] - each[k]) for each in (r, Omega))
    return np.where(inside, peak, np.nan), np.where(inside, frequency, np.nan)


def phase_resonances(model: Model, mode: int) -> tuple[Backbone, Floats]:
    """Return the backbone over the friction table, and the modal force at each amplitude."""
    largest = model.table.amplitude_range[mode]
    r = np.geomspace(_SMALLEST * largest, _LARGEST * largest, 2000)
    curve, _ = tabulated_backbone(model, mode, 0.0, r)
    if np.any(curve.damping <= 0.0):
        r = curve.amplitude[curve.damping <= 0.0][0]
        raise SlipmodeError(
            f"mode: {'AB'[mode]} has no damping at |a| = {r:.3g} kg^1/2 m, so it has no resonance "
            "peak; rom.limit_cycles finds the limit cycles of self-excited modes"
        )
    return curve, 4.0 * curve.damping * curve.frequency**2 * curve.amplitude
