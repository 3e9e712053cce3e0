"""Steady states of several modes on one or two tones against a forcing frequency."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
    """Hold steady states of several modes on one or two tones, one for each frequency.

    Attributes
    ----------
    frequency : (n,) ndarray
        Values of the varied forcing frequency [rad/s].
    carrier : (n, tones) ndarray
        Forcing frequencies of all tones [rad/s].
    amplitude : (n, modes) complex ndarray
        Amplitudes a_j [kg^1/2 m].
    error : (n, modes) ndarray
        Estimated error of `amplitude` by time steps and harmonics [kg^1/2 m].
    modes : tuple of str
        Names of the modes.
    responses : sequence of ToneResponse
        Structure and force of each tone.
    states : sequence of ToneState
        Steady states.
    """

    frequency: Floats
    carrier: Floats
    amplitude: Complexes
    error: Floats
    modes: tuple[str, ...]
    responses: Sequence[ToneResponse]
    states: Sequence[ToneState]

    @property
    def response(self) -> ToneResponse:
        """Structure and force of tone A."""
        return self.responses[0]

    def displacement(self, dof: int) -> Complexes:
        """Return the harmonic of the displacement of a DOF at each forcing frequency.

        Parameters
        ----------
        dof : int
            Index of the DOF.

        Returns
        -------
        (n,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i Omega t)) [m]; (n, 2) of two tones.

        Raises
        ------
        SlipmodeError
            If there is no such DOF.
        """
        check_dof(dof, self.response.reduced.n_dofs)
        modal, deficit = (
            np.array([getattr(state, name) for state in self.states])
            for name in ("modal", "deficit")
        )
        each = [
            response.displacement(modal[:, t].T, deficit[:, t].T, dof)
            for t, response in enumerate(self.responses)
        ]
        return each[0] if len(each) == 1 else np.stack(each, axis=-1)

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
            Amplitudes by the name of the mode; of a DOF by the name of the tone, "A" or "B".
        """
        if shown.dof is None:
            return dict(zip(self.modes, np.abs(self.amplitude).T, strict=True))
        return self._dof_sizes(shown.dof, shown.units)

    def _values(self, units: Units) -> dict[str, Any]:
        tones = self.carrier.shape[1]
        names = ["frequency"] if tones == 1 else ["frequency_A", "frequency_B"]
        columns = zip(names, units.of_frequency(self.carrier).T, strict=True)
        found: dict[str, Any] = {units.named(name): column for name, column in columns}
        for mode, a, error in zip(self.modes, self.amplitude.T, self.error.T, strict=True):
            found |= {f"{mode}_re": a.real, f"{mode}_im": a.imag, f"{mode}_error": error}
        return found

    def _dof_sizes(self, dof: int, units: Units) -> dict[str, Floats]:
        moved = self.displacement(dof).reshape(self.carrier.shape)
        sizes = units.of_displacement(2.0 * np.abs(moved))
        return dict(zip("AB", sizes.T, strict=False))


def tone_curve(
    model: ToneModel,
    force: ToneForce,
    span: Sequence[float],
    phase: float = 0.0,
) -> ToneCurve:
    """Return steady states of modes that share a tone, against the forcing frequency.

    It is `rom.response_curve` of such a model, which also takes two tones.

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
    return curve_of_tone(model, (), [force], "frequency_A", span, phase)


def curve_of_tone(
    model: ToneModel,
    frequency: ArrayLike,
    force: Sequence[ToneForce],
    vary: str,
    span: Sequence[ArrayLike],
    phase: ArrayLike,
) -> ToneCurve:
    """Return steady states against "frequency_A" or "frequency_B"; `force` is of each tone.

    `frequency` (tones,) has the other one; of one tone it is ignored.
    """
    allowed = ("frequency_A", "frequency_B")[: model.reduced.tones]
    if vary not in allowed:
        raise SlipmodeError(
            f"vary = {vary!r}: must be {' or '.join(map(repr, allowed))} for modes that share a "
            "tone; use rom.steady for other parameters"
        )
    ends, given = as_floats("span", span), as_floats("frequency", frequency)
    if ends.shape != (2,) or not 0.0 < ends[0] < ends[1] < np.inf:
        raise SlipmodeError(
            f"span: must be two increasing frequencies > 0 [rad/s], got {in_one_line(span)}"
        )
    if len(allowed) == 2 and given.shape != (2,):
        raise SlipmodeError(
            f"frequency: must be two numbers, of tones A and B, got {in_one_line(frequency)}"
        )

    def carriers(varied: Floats) -> Floats:
        points = np.tile(given if len(allowed) == 2 else ends[:1], (varied.size, 1))
        points[:, allowed.index(vary)] = varied
        return points

    forced = ForcedTone.of(model, force, phase, carriers(ends))
    Omega = _frequencies(forced, ends, carriers)
    states = forced.steady(carriers(Omega))
    amplitude = np.array([state.amplitude for state in states])
    error = np.array([state.error for state in states])
    names = tuple(model.reduced.mode_names)
    return ToneCurve(Omega, carriers(Omega), amplitude, error, names, forced.responses, states)


def _frequencies(forced: ForcedTone, ends: Floats, carriers: Callable[[Floats], Floats]) -> Floats:
    """Return frequencies between two ends that are closer where amplitudes bend."""
    Omega = np.linspace(ends[0], ends[1], _FIRST)
    while True:
        a = forced.with_local_contacts(carriers(Omega))
        part = ((Omega[1:-1] - Omega[:-2]) / (Omega[2:] - Omega[:-2]))[:, np.newaxis]
        bend = np.abs(a[1:-1] - a[:-2] - part * (a[2:] - a[:-2])).max(axis=1)
        bent = np.flatnonzero(bend > _BENDS * np.abs(a).max()) + 1
        gaps = np.unique(np.concatenate((bent - 1, bent)))
        if not bent.size or Omega.size + gaps.size > _MOST:
            return np.asarray(Omega)
        Omega = np.sort(np.append(Omega, 0.5 * (Omega[gaps] + Omega[gaps + 1])))
