"""Steady states of the slow flow: resonance curves and surfaces, Eqs. (22)-(25)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Complexes, Flags, Floats, as_floats, in_one_line
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.reduction.force_response import AppliedForces, Forces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.curve_result import CurveResult, axes_or_new, methods
from slipmode.rom.slow.branches.solve_points import flow_at_amplitudes
from slipmode.rom.slow.direct.contact_friction import has_contact_problem
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.steady_points import SteadyPoints, steady_points
from slipmode.rom.slow.tone.tone_states import ForcedTone
from slipmode.rom.slow.units import SI, Shown, Units
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.table.model import Model
from slipmode.rom.validity import (
    can_carry,
    forcing_findings,
    friction_findings,
    warn,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@frozen
class ResonanceCurve:
    """Hold the forcing frequencies at which a mode vibrates with given amplitudes.

    See source Eqs. (23) for mode A and (25) for mode B.

    Attributes
    ----------
    amplitude : (n,) ndarray
        Amplitudes |a_j| [kg^1/2 m].
    below, above : (n,) ndarray
        Frequency on the branch below and above the peak [rad/s]. NaN where the force does not
        reach the amplitude, the slow flow cannot follow the frequency, the amplitude is outside
        the friction table, or the frequency is not found.
    """

    amplitude: Floats
    below: Floats
    above: Floats


@frozen
class ResonanceSurface(CurveResult):
    """Hold steady amplitudes over a grid of both forcing frequencies.

    Attributes
    ----------
    motion : SteadyMotion
        Motion of all DOFs at the points of the grid, in the order of the flattened grid.
    frequency_A : (n_A,) ndarray
        Forcing frequencies of mode A [rad/s].
    frequency_B : (n_B,) ndarray
        Forcing frequencies of mode B [rad/s].
    amplitude : (n_A, n_B, 2) complex ndarray
        Amplitudes a_A and a_B [kg^1/2 m].
    method : (n_A, n_B) ndarray of str
        Friction at each point: "table", or "direct" for the contact problem itself.
    """

    frequency_A: Floats
    frequency_B: Floats
    amplitude: Complexes
    method: NDArray[np.str_]

    @property
    def euclidean(self) -> Floats:
        """Euclidean norm sqrt(|a_A|^2 + |a_B|^2) of the amplitudes, (n_A, n_B) [kg^1/2 m]."""
        return np.asarray(np.linalg.norm(self.amplitude, axis=-1))

    def _in_shape(self, sizes: Floats) -> Floats:
        return sizes.reshape(self.amplitude.shape)

    def plot(
        self,
        axes: tuple[Axes, Axes] | None = None,
        dof: int | None = None,
        units: Units = SI,
    ) -> Any:
        """Plot the amplitudes as colours over both frequencies.

        Parameters
        ----------
        axes : pair of Axes, optional
            Matplotlib axes for A and B. Default: a new figure.
        dof : int, optional
            DOF whose displacement amplitudes are plotted. Default: |a_A| and |a_B|.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        pair of Axes
            Axes of the plots.
        """
        axes = axes_or_new(axes, 1, 2, sharex=True, sharey=True, layout="constrained")
        shown = Shown(dof, units)
        size = self.size(shown)
        along, up = units.of_frequency(self.frequency_A), units.of_frequency(self.frequency_B)
        for j, ax in enumerate(axes):
            colours = ax.pcolormesh(along, up, size[..., j].T, shading="nearest")
            ax.figure.colorbar(colours, ax=ax, label=shown.named(f"|{'AB'[j]}|"))
            ax.set_xlabel(f"frequency A [{units.frequency}]")
        axes[0].set_ylabel(f"frequency B [{units.frequency}]")
        return axes

    def _values(self, units: Units) -> dict[str, Floats]:
        found: dict[str, Floats] = {}
        for j, mode in enumerate("AB"):
            a = self.amplitude[..., j].ravel()
            found |= units.frequencies(**{f"frequency_{mode}": self.motion.frequency[:, j]})
            found |= {f"{mode}_re": a.real, f"{mode}_im": a.imag}
        return found

    def _dof_sizes(self, dof: int, units: Units) -> dict[str, Floats]:
        return dict(zip("AB", self.size(Shown(dof, units)).reshape(-1, 2).T, strict=True))


def steady(
    model: Model | ToneModel,
    frequency: ArrayLike,
    force: Forces,
    phase: ArrayLike = 0.0,
) -> Complexes:
    """Return steady complex amplitudes under constant forces, on the branch reached from rest.

    Parameters
    ----------
    model : Model or ToneModel
        Model with one or two modes, or with modes that share a tone.
    frequency : (..., modes) array_like
        Forcing frequencies Omega_j [rad/s]; (..., tones) if modes share a tone.
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N]; one per tone if modes share a tone, complex where DOFs have phases of
        their own.
    phase : float or (modes,) array_like, default 0.0
        Phases of the forces psi_j [rad]; (tones,) if modes share a tone.

    Returns
    -------
    (..., modes) complex ndarray
        Amplitudes a_j [kg^1/2 m]. Modes and contacts move as
        x = 2 Re(sum_j mode_shape_j a_j exp(i Omega_j t)) + contact_shapes x_c.

    Raises
    ------
    SlipmodeError
        If the slow flow cannot follow the frequency of a forced mode, or an amplitude leaves the
        friction table. If the amplitudes do not become constant, for instance because the force
        does not hold a self-excited mode.

    Warns
    -----
    ValidityWarning
        If friction, a force or its frequency violates an assumption of the method.

    Notes
    -----
    Where the error of the friction table changes an amplitude by more than the tolerance of the
    model, the contact problem is solved at the forcing frequencies instead.

    The amplitudes solve (omega_j^2 - Omega_j^2 + i gamma_j Omega_j - Q_j) a_j = F_j exp(i psi_j) /
    2, see "Steady states" in docs/theory.md.

    Examples
    --------
    The peak displacement of DOF 0 is about 2 |a| [m], because its modal mass is 1 kg:

    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(4.0,))
    >>> abs(rom.steady(model, [[0.97], [0.98]], [{0: 0.15}])).round(2)
    array([[1.46],
           [3.32]])
    """
    Omega = np.atleast_1d(as_floats("frequency", frequency))
    tones = model.reduced.tones
    _check_frequencies(Omega, tones)
    if isinstance(model, ToneModel):
        points = Omega.reshape(-1, tones)
        states = ForcedTone.of(model, force, phase, points).steady(points)
        of_modes = [state.amplitude for state in states]
        return np.reshape(of_modes, (*Omega.shape[:-1], model.modes))
    carriers = model.reduced.carriers(Omega.reshape(-1, tones))
    found, findings = _steady(model, carriers, force, phase)
    warn(findings)
    return found.amplitude.reshape(*Omega.shape[:-1], model.modes)


def _check_frequencies(Omega: Floats, tones: int) -> None:
    """Refuse frequencies (..., tones) of another shape, not finite or <= 0."""
    if Omega.shape[-1] != tones or not np.all(np.isfinite(Omega) & (Omega > 0)):
        raise SlipmodeError(
            f"frequency: must be finite and > 0 with a last axis of length {tones} [rad/s]"
        )


def _steady(
    model: Model, points: Floats, force: Forces, phase: ArrayLike
) -> tuple[SteadyPoints, list[Finding]]:
    """Return the steady states of `steady` at frequencies (points, modes), with its findings."""
    applied = AppliedForces.of(model.reduced, force)
    excitation = applied.excitation(phase)
    every = np.tile(excitation, (len(points), 1))
    found = steady_points(model, points, applied, every)
    if found.refusals:
        raise found.refusals[min(found.refusals)]
    findings = forcing_findings(model.reduced, points, excitation != 0.0)
    findings += friction_findings(model.reduced, model.law, np.abs(found.amplitude).max(axis=0))
    if not has_contact_problem(model):
        findings += model.detuning_findings(points, excitation != 0.0)
    return found, findings


def resonance(
    model: Model, force: Forces, frequency_A: ArrayLike, frequency_B: ArrayLike
) -> ResonanceSurface:
    """Return steady amplitudes over a grid of both forcing frequencies, reached from rest.

    Parameters
    ----------
    model : Model
        Model with two modes.
    force : one {DOF: amplitude} or (n,) array_like per mode
        Force amplitudes [N].
    frequency_A : (n_A,) array_like
        Forcing frequencies of mode A [rad/s].
    frequency_B : (n_B,) array_like
        Forcing frequencies of mode B [rad/s].

    Returns
    -------
    ResonanceSurface
        Amplitudes at all n_A n_B pairs of frequencies.

    Raises
    ------
    SlipmodeError
        If the model has one mode, a frequency axis is not one-dimensional, or `rom.steady` refuses
        a pair of frequencies.
    """
    model.check_mode(0)
    axes = {"frequency_A": frequency_A, "frequency_B": frequency_B}
    if model.modes != 2:
        raise SlipmodeError("model: must be of two modes for a grid of two forcing frequencies")
    axis_A, axis_B = (as_floats(key, axis) for key, axis in axes.items())
    for key, axis in zip(axes, (axis_A, axis_B), strict=True):
        if axis.ndim != 1:
            raise SlipmodeError(f"{key}: must be a sequence of numbers [rad/s], got {axis}")
    grid = np.stack(np.meshgrid(axis_A, axis_B, indexing="ij"), axis=-1)
    _check_frequencies(grid, model.modes)
    points, applied = grid.reshape(-1, model.modes), AppliedForces.of(model.reduced, force)
    found, findings = _steady(model, points, force, 0.0)
    warn(findings)
    flow = ForcedFlow.of(model, points, applied.modal.astype(complex))
    motion = SteadyMotion.of(flow, found.amplitude, applied)
    method = methods(found.is_direct.reshape(grid.shape[:-1]))
    return ResonanceSurface(motion, axis_A, axis_B, found.amplitude.reshape(grid.shape), method)


def resonance_curve(
    model: Model, mode: int, force: Mapping[int, float] | ArrayLike, amplitudes: ArrayLike
) -> ResonanceCurve:
    """Return the forcing frequencies at which a mode vibrates with given amplitudes.

    The amplitude equation is solved for the frequency, below and above the peak, source Eqs. (23)
    and (25). See "Steady states" in docs/theory.md.

    Parameters
    ----------
    model : Model
        Model with one or two modes.
    mode : int
        0 for A, 1 for B.
    force : {DOF: amplitude} or (n,) array_like
        Force amplitudes on this mode [N]. Their direct effect on the contacts is neglected.
    amplitudes : (n, modes) array_like
        Amplitudes |a_j| of all modes [kg^1/2 m]: > 0 for this mode, >= 0 for the other mode. For a
        model with one mode, (n,) is allowed.

    Returns
    -------
    ResonanceCurve
        Two frequencies for each amplitude.

    Raises
    ------
    SlipmodeError
        If the mode does not exist, or an amplitude is not allowed.

    Warns
    -----
    ValidityWarning
        If the frequency is not found at some amplitudes.
    """
    model.check_mode(mode)
    points = as_floats("amplitudes", amplitudes)
    if points.ndim == 1 and model.modes == 1:
        points = points[:, np.newaxis]
    if points.ndim != 2 or points.shape[1] != model.modes:
        raise SlipmodeError(
            f"amplitudes: must have shape (n, {model.modes}), one column per mode, got shape "
            f"{points.shape}"
        )
    r = points[:, mode]
    if not (np.isfinite(points).all() and (points >= 0.0).all() and (r > 0.0).all()):
        raise SlipmodeError(
            f"amplitudes: must be finite and >= 0, and > 0 for mode {'AB'[mode]} [kg^1/2 m], got "
            f"{in_one_line(amplitudes)}"
        )
    half_force = 0.5 * abs(model.reduced.modal_force(mode, force)) / r
    omega, at = model.reduced.frequency[mode], points.astype(complex)
    frequency = np.tile(model.reduced.carrier, (r.size, 1))
    frequency[:, mode] = omega
    start = ForcedFlow.of(model, frequency)

    def branch(sign: float) -> tuple[Floats, Flags]:
        def balance(stiffness: Complexes, Q: Complexes) -> Floats:
            net = stiffness - Q
            return net.real + sign * np.sqrt(np.maximum(half_force**2 - net.imag**2, 0.0))

        flow, (stiffness, Q), found = flow_at_amplitudes(start, mode, at, balance)
        Omega = flow.frequency[:, mode]
        reached = np.abs((stiffness - Q).imag) <= half_force  # not outside the table
        known = can_carry(omega, Omega) & reached
        return np.where(known & found, Omega, np.nan), known & ~found

    (below, lost), (above, missing) = branch(-1.0), branch(1.0)
    if (unsolved := lost | missing).any():
        where = f"|a| = {in_one_line(r[unsolved].tolist())} kg^1/2 m"
        reason = f"the iteration does not converge at {where}; call rom.response_curve near peaks"
        warn([Finding("resonance curve", "has no frequency", reason, "warning")])
    return ResonanceCurve(r, below, above)
