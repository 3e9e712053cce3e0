"""Steady states of several modes on one tone against the forcing frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, check_dof, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.curve_result import Tabulated, axes_or_current, plot_band
from slipmode.rom.slow.tone.tone_response import ToneResponse
from slipmode.rom.slow.tone.tone_states import ForcedTone, ToneForce, ToneState
from slipmode.rom.slow.units import SI, Shown, Units
from slipmode.rom.table.local.tone_model import ToneModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Points of a curve: at first, at most, and the distance of a point from the straight line between
# its neighbours beyond which there are more, relative to the largest amplitude.
_FIRST, _MOST, _BENDS = 33, 400, 0.01


@frozen
class ToneCurve(Tabulated):
    """Hold steady states of several modes on one tone, one for each frequency.

    Attributes
    ----------
    frequency : (n,) ndarray
        Forcing frequencies [rad/s].
    amplitude : (n, modes) complex ndarray
        Amplitudes a_j [kg^1/2 m].
    error : (n, modes) ndarray
        Estimated error of `amplitude` by time steps and harmonics [kg^1/2 m].
    modes : tuple of str
        Names of the modes.
    response : ToneResponse
        Structure and force.
    states : sequence of ToneState
        Steady states.
    """

    frequency: Floats
    amplitude: Complexes
    error: Floats
    modes: tuple[str, ...]
    response: ToneResponse
    states: Sequence[ToneState]

    def displacement(self, dof: int) -> Complexes:
        """Return the harmonic of the displacement of a DOF at the forcing frequency.

        Parameters
        ----------
        dof : int
            Index of the DOF.

        Returns
        -------
        (n,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i Omega t)) [m].

        Raises
        ------
        SlipmodeError
            If there is no such DOF.
        """
        check_dof(dof, self.response.reduced.n_dofs)
        modal, deficit = (
            np.transpose([getattr(state, name)[0] for state in self.states])
            for name in ("modal", "deficit")
        )
        return self.response.displacement(modal, deficit, dof)

    def plot(self, ax: Axes | None = None, dof: int | None = None, units: Units = SI) -> Axes:
        """Plot amplitudes against the frequency, with their errors.

        Parameters
        ----------
        ax : Axes, optional
            Matplotlib axes. Default: the current axes.
        dof : int, optional
            DOF whose displacement amplitude is plotted. Default: |a_j|.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        Axes
            Axes of the plot.
        """
        ax, shown = axes_or_current(ax), Shown(dof, units)
        along = units.of_frequency(self.frequency)
        for mode, size in self.sizes(shown).items():
            (line,) = ax.plot(along, size, label=f"|{mode}|")
            if dof is None:
                error = self.error[:, self.modes.index(mode)]
                plot_band(ax, along, size, error, color=line.get_color())
        if dof is None:
            ax.legend()
        ax.set(xlabel=units.frequency_label, ylabel=shown.named("amplitude"), ylim=(0.0, None))
        return ax

    def sizes(self, shown: Shown) -> dict[str, Floats]:
        """Return the amplitudes that a plot of the curve shows.

        Parameters
        ----------
        shown : Shown
            |a_j|, or the displacement amplitude of a DOF in given units.

        Returns
        -------
        dict of str to (n,) ndarray
            Amplitudes by the name of the mode; of a DOF by the name of the tone, "A".
        """
        if shown.dof is None:
            return dict(zip(self.modes, np.abs(self.amplitude).T, strict=True))
        return self._dof_sizes(shown.dof, shown.units)

    def _values(self, units: Units) -> dict[str, Any]:
        found = {units.named("frequency"): units.of_frequency(self.frequency)}
        for mode, a, error in zip(self.modes, self.amplitude.T, self.error.T, strict=True):
            found |= {f"{mode}_re": a.real, f"{mode}_im": a.imag, f"{mode}_error": error}
        return found

    def _dof_sizes(self, dof: int, units: Units) -> dict[str, Floats]:
        return {"A": units.of_displacement(2.0 * np.abs(self.displacement(dof)))}


def tone_curve(
    model: ToneModel,
    force: ToneForce,
    span: Sequence[float],
    phase: float = 0.0,
) -> ToneCurve:
    """Return steady states of modes that share a tone, against the forcing frequency.

    It is `rom.response_curve` of such a model.

    There is one steady state at each frequency, and it is stable: contacts that do not lift off
    take energy from the difference of two motions.

    Parameters
    ----------
    model : ToneModel
        Model of modes that share a tone.
    force : {DOF: amplitude} or (n,) array_like
        Force amplitudes f [N] of Re(f exp(i Omega t)), complex where DOFs have phases of their
        own.
    span : pair of float
        First and last frequency [rad/s].
    phase : float, default 0.0
        Phase of the force [rad].

    Returns
    -------
    ToneCurve
        Amplitudes with errors, at up to 400 frequencies that are closer where the curve bends.

    Raises
    ------
    SlipmodeError
        If an argument is outside its range, or a steady state is not found to the tolerance.
    """
    return curve_of_tone(model, [force], span, phase)


def curve_of_tone(
    model: ToneModel, force: Sequence[ToneForce], span: Sequence[ArrayLike], phase: ArrayLike
) -> ToneCurve:
    """Return the curve of `tone_curve`, of a sequence of one force."""
    ends = as_floats("span", span)
    if ends.shape != (2,) or not 0.0 < ends[0] < ends[1] < np.inf:
        raise SlipmodeError(
            f"span: must be two increasing frequencies > 0 [rad/s], got {in_one_line(span)}"
        )
    forced = ForcedTone.of(model, force, phase, ends)
    Omega = _frequencies(forced, ends)
    states = forced.steady(Omega)
    amplitude = np.array([state.amplitude for state in states])
    error = np.array([state.error for state in states])
    names = tuple(model.reduced.mode_names)
    return ToneCurve(Omega, amplitude, error, names, forced.response, states)


def _frequencies(forced: ForcedTone, ends: Floats) -> Floats:
    """Return frequencies between two ends that are closer where amplitudes bend."""
    Omega = np.linspace(ends[0], ends[1], _FIRST)
    while True:
        a = forced.with_local_contacts(Omega)
        part = ((Omega[1:-1] - Omega[:-2]) / (Omega[2:] - Omega[:-2]))[:, np.newaxis]
        bend = np.abs(a[1:-1] - a[:-2] - part * (a[2:] - a[:-2])).max(axis=1)
        bent = np.flatnonzero(bend > _BENDS * np.abs(a).max()) + 1
        gaps = np.unique(np.concatenate((bent - 1, bent)))
        if not bent.size or Omega.size + gaps.size > _MOST:
            return np.asarray(Omega)
        Omega = np.sort(np.append(Omega, 0.5 * (Omega[gaps] + Omega[gaps + 1])))
