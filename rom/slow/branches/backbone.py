"""Backbones: frequency and damping of a nonlinear mode against its amplitude.

A negative damping -2 zeta Omega x' that holds a mode at a constant amplitude makes it move like a
damped nonlinear mode (extended periodic motion concept, Krack 2015). In the slow flow that is

    omega^2 - Omega^2 + i gamma Omega - Q(|a|) = 2 i zeta Omega^2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from slipmode.rom.arrays import Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import dataframe, extra
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.answer_error import TableError, off_carrier_findings
from slipmode.rom.slow.slow_flow import ForcedFlow, rates
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.steady_points import INSIDE
from slipmode.rom.slow.units import SI, Shown, Units
from slipmode.rom.table.model import Model
from slipmode.rom.validity import warn

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SMALLEST, LARGEST = 1e-3, INSIDE  # amplitudes, relative to the table's range
BAND = 0.2  # opacity of the error in pictures


@frozen
class Backbone:
    """A damped nonlinear mode.

    Attributes
    ----------
    amplitude : (n,) ndarray
        |a| of the mode [kg^1/2 m].
    other : float
        |a| of the other mode, at its carrier [kg^1/2 m].
    frequency : (n,) ndarray
        Omega [rad/s].
    frequency_error : (n,) ndarray
        Error of Omega by the errors of the friction table and of its carriers [rad/s].
    damping : (n,) ndarray
        Damping ratio zeta [-], of steady motion.
    damping_error : (n,) ndarray
        Error of zeta by the same errors [-].
    decay : (n,) ndarray
        -d|a|/dt / |a| [1/s] of free vibration: zeta Omega where that is slow; friction lags
        behind a faster one.
    mode_shape : (n_dofs,) ndarray
        [kg^-1/2]
    motion : SteadyMotion
        Of all modes, without forces.
    mode : int
        Which of them it is.
    """

    amplitude: Floats
    other: float
    frequency: Floats
    frequency_error: Floats
    damping: Floats
    damping_error: Floats
    decay: Floats
    mode_shape: Floats
    motion: SteadyMotion
    mode: int

    def displacement(self, dof: int) -> Floats:
        """Return the amplitude of a DOF at the carrier of the mode, (n,) [m]."""
        return self.motion.displacement(dof)[:, self.mode]

    def plot(
        self, axes: tuple[Axes, Axes] | None = None, dof: int | None = None, units: Units = SI
    ) -> Any:
        """Draw frequency and damping ratio, with their errors, against the amplitude."""
        if axes is None:
            axes = extra("matplotlib.pyplot", "pictures").subplots(2, sharex=True)[1]
        amplitude = Shown(dof, units)
        against = amplitude.size(self.motion)[:, self.mode]
        shown = {
            f"frequency [{units.frequency}]": (
                units.of_frequency(self.frequency),
                units.of_frequency(self.frequency_error),
            ),
            "damping [-]": (self.damping, self.damping_error),
        }
        for ax, (name, (values, error)) in zip(axes, shown.items(), strict=True):
            ax.semilogx(against, values)
            ax.fill_between(against, values - error, values + error, alpha=BAND, lw=0)
            ax.set_ylabel(name)
        axes[1].set_xlabel(amplitude.named("amplitude"))
        return axes

    def columns(self, dof: int | None = None, units: Units = SI) -> dict[str, Floats]:
        """Return columns by name, with the amplitude of a DOF if one is given."""
        found = {
            "amplitude": self.amplitude,
            units.named("frequency"): units.of_frequency(self.frequency),
            units.named("frequency_error"): units.of_frequency(self.frequency_error),
            "damping": self.damping,
            "damping_error": self.damping_error,
            "decay": self.decay,
        }
        if dof is not None:
            name = units.of_dof("amplitude", dof)
            found[name] = units.of_displacement(self.displacement(dof))
        return found

    def to_dataframe(self, dof: int | None = None, units: Units = SI) -> Any:
        """Return a table with a row per amplitude; see `columns`."""
        return dataframe(self.columns(dof, units))


def backbone(
    model: Model, mode: int = 0, other: float = 0.0, amplitude: Floats | None = None
) -> Backbone:
    """Return frequency and damping of a mode against its amplitude, from the friction table.

    Parameters
    ----------
    model : Model
        Its carriers should be near the frequencies of the backbone.
    mode : int
        0 for A, 1 for B.
    other : float
        |a| of the other mode [kg^1/2 m].
    amplitude : (n,) array_like, optional
        |a| > 0 [kg^1/2 m]. Default: 200 values in even ratios, from 1e-3 of the table's range on.

    Raises
    ------
    SlipmodeError
        If there is no such mode, or an amplitude is outside the friction table.
    """
    model.check_mode(mode)
    if not (np.ndim(other) == 0 and as_floats("other", other) >= 0.0):
        raise SlipmodeError(f"other: must be a number >= 0 [kg^1/2 m], got {other}")
    if model.modes == 1 and other != 0.0:
        raise SlipmodeError(f"other: must be 0 in a model of one mode, got {other}")
    if amplitude is None:
        largest = model.table.amplitude_range[mode]
        r = np.geomspace(SMALLEST * largest, LARGEST * largest, 200)
    else:
        r = np.atleast_1d(as_floats("amplitude", amplitude))
        if r.ndim > 1 or r.size == 0 or not np.all(np.isfinite(r) & (r > 0.0)):
            raise SlipmodeError("amplitude: must be finite numbers > 0 [kg^1/2 m]")
    a = np.full((r.size, model.modes), abs(other), dtype=complex)
    a[:, mode] = r
    model.table(np.abs(a))  # refuses what is outside
    frequency = np.tile(model.reduced.carrier, (r.size, 1))
    flow = ForcedFlow.of(model, frequency)
    Omega = np.full(r.size, model.reduced.frequency[mode])
    for _ in range(100):
        frequency[:, mode] = Omega
        flow = flow.with_frequency(frequency)
        now = flow.balance(a)
        off = now.stiffness[:, mode] - now.friction[:, mode] / r
        square = Omega**2 + off.real
        if np.isnan(square).any():
            raise SlipmodeError(
                f"amplitude: at {r[np.isnan(square)][0]:.3g} kg^0.5 m the effective amplitude is "
                "outside the friction table; tabulate a larger range"
            )
        if not (square > 0.0).all():
            raise SlipmodeError(
                f"amplitude: the stiffness of mode {'AB'[mode]} is not positive at "
                f"{r[square <= 0][0]:.3g} kg^0.5 m; give smaller amplitudes"
            )
        change, Omega = np.abs(np.sqrt(square) / Omega - 1.0).max(), np.sqrt(square)
        if change <= 1e-13:  # rounding
            break
    zeta = off.imag / (2.0 * Omega**2)
    loss, effective = np.abs(off.imag) * r, np.abs(flow.effective(a))
    weight = np.abs(now.friction[:, mode]) / loss
    table_error = TableError.of(model, effective, frequency, np.ones(r.size), weight)
    share = effective[:, mode] / r * table_error.size[:, mode] / r
    frequency_error, damping_error = share / (2.0 * Omega), share / (2.0 * Omega**2)
    if friction_takes_energy(model, other):
        zeta = np.maximum(zeta, model.reduced.modal_damping[mode] / (2.0 * Omega))
    change = np.nan_to_num(np.abs(table_error.off_carriers[:, mode]), nan=np.inf)
    worst = float((change / loss[table_error.measured]).max(initial=0.0))
    apart = frequency[:, mode] / model.reduced.carrier[mode] - 1.0
    warn(off_carrier_findings(model.accuracy.tolerance, worst, apart, "the damping"))
    decay = -rates(flow.flow, flow.inputs, a)[:, mode].real / r
    shape = model.reduced.mode_shapes[:, mode].copy()
    motion = SteadyMotion(model, a, frequency, np.zeros_like(a), None, np.ones(r.size))
    return Backbone(
        r,
        float(other),
        Omega,
        frequency_error,
        zeta,
        damping_error,
        decay,
        shape,
        motion,
        mode,
    )


def friction_takes_energy(model: Model, other: float) -> bool:
    """Return whether Im S <= 0 is known, so that positive values in a table are errors.

    It is for elastic contacts, if damping does not couple the modes and no energy comes from
    another mode.
    """
    reduced = model.reduced
    alone = other == 0.0 and not model.combinations
    elastic = reduced.contacts is not None and reduced.n_contacts > 0
    return elastic and alone and not reduced.damping_coupling.any()
