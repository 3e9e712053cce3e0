"""Backbones: frequency and damping of a nonlinear mode against its amplitude.

A negative damping -2 zeta Omega x' that holds a mode at a constant amplitude makes it move like a
damped nonlinear mode. In the extended periodic motion concept (Krack 2015) it acts on all modes
and harmonics, here only on the first harmonic of the mode. In the slow flow that is

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
# Largest relative change of a frequency in the last pass of a fixed-point iteration.
CONVERGED = 1e-9
BAND = 0.2  # opacity of the error in pictures


@frozen
class Backbone:
    """Hold a damped nonlinear mode: frequency and damping against the amplitude.

    Attributes
    ----------
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
    mode_shape : (n_dofs,) ndarray
        Mass-normalised mode shape [kg^-1/2].
    motion : SteadyMotion
        Motion of all DOFs, without forces.
    mode : int
        0 for A, 1 for B.
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
        """Return the displacement amplitude of a DOF at the carrier of the mode.

        Parameters
        ----------
        dof : int
            Index of the DOF.

        Returns
        -------
        (n,) ndarray
            Displacement amplitudes [m].

        Raises
        ------
        SlipmodeError
            If there is no such DOF.
        """
        return self.motion.displacement(dof)[:, self.mode]

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
        """Return the backbone as named columns, one row for each amplitude.

        Parameters
        ----------
        dof : int, optional
            DOF whose displacement amplitude is added, with its error if known.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        dict of str to (n,) ndarray
            Amplitude [kg^1/2 m], frequency and damping with errors, decay rate [1/s].
        """
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
        """Return the backbone as a pandas DataFrame, one row for each amplitude.

        Parameters
        ----------
        dof : int, optional
            DOF whose displacement amplitude is added.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        DataFrame
            Table with the columns of `columns`.
        """
        return dataframe(self.columns(dof, units))


def backbone(
    model: Model, mode: int = 0, other: float = 0.0, amplitude: Floats | None = None
) -> Backbone:
    """Return frequency and damping of a mode against its amplitude, from the friction table.

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
        If the frequency is so far from the carrier that the error exceeds the tolerance.

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
        change, Omega = np.abs(np.sqrt(square) / Omega - 1.0), np.sqrt(square)
        if change.max() <= 1e-13:  # rounding
            break
    check_converged(
        change,
        r,
        "friction depends strongly on the frequency; call rom.reduce with carrier = the frequency "
        "of the mode there",
    )
    zeta = off.imag / (2.0 * Omega**2)
    # A loss below the rounding error of the stiffness is 0, as of an undamped mode that sticks.
    loss = np.maximum(np.abs(off.imag), np.finfo(float).eps * Omega**2) * r
    table_error = TableError.of(flow, a)
    at, size = table_error.at, table_error.scale[:, mode] / r
    measured = table_error.measured[:, mode] / r[at]
    share = np.abs(np.stack((measured.real, measured.imag), axis=-1)) / size[at, np.newaxis]
    stated = table_error.stated[:, mode] / r
    of_stiffness, of_loss = (
        table_error.between(share).T * size + stated if at.size else np.stack((stated, stated))
    )
    frequency_error = of_stiffness / (2.0 * Omega)
    damping_error = of_loss / (2.0 * Omega**2) + 2.0 * np.abs(zeta) * frequency_error / Omega
    if friction_takes_energy(model, other):
        zeta = np.maximum(zeta, model.reduced.modal_damping[mode] / (2.0 * Omega))
    change = np.nan_to_num(np.abs(table_error.measured[:, mode]), nan=np.inf)
    change[change <= model.accuracy.total * table_error.scale[at, mode]] = 0.0
    worst = float((change / loss[at]).max(initial=0.0))
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


def check_converged(change: Floats, amplitude: Floats, reason: str) -> None:
    """Refuse amplitudes (n,) at which the frequency of a mode still has a relative change (n,)."""
    moves = ~(change <= CONVERGED)
    if moves.any():
        raise SlipmodeError(
            f"amplitude: the frequency of the mode does not converge at {amplitude[moves][0]:.3g} "
            f"kg^0.5 m, because {reason}"
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
