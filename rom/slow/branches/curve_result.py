"""What all curves and surfaces of steady states have: columns, displacements, error bands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.extras import dataframe, extra
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.steady_motion import SteadyMotion
from slipmode.rom.slow.units import MODAL_AMPLITUDES, SI, Shown, Units

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BAND = 0.2  # opacity of the error in pictures

Method = Literal["table", "direct"]  # friction of the table, or of the contact problem itself


def methods(is_direct: Flags) -> NDArray[np.str_]:
    """Return "direct" where friction is of the contact problem, "table" elsewhere."""
    return np.asarray(np.where(is_direct, "direct", "table"))


class Tabulated:
    """Have named columns, one row for each steady state."""

    def _values(self, units: Units) -> dict[str, Any]:
        """Return the columns (n,) except the columns of a DOF."""
        raise NotImplementedError

    def _dof_sizes(self, dof: int, units: Units) -> dict[str, Floats]:
        """Return columns (n,) of amplitudes of a DOF, by the names without DOF and unit."""
        raise NotImplementedError

    def columns(self, dof: int | None = None, units: Units = SI) -> dict[str, Any]:
        """Return the result as named columns, one row for each steady state.

        Parameters
        ----------
        dof : int, optional
            DOF whose displacement amplitude is added, with its error if known.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        dict of str to (n,) ndarray
            Values and their errors. Modal amplitudes are in kg^1/2 m, rates in 1/s.
        """
        found = self._values(units)
        if dof is not None:
            sizes = self._dof_sizes(dof, units)
            found |= {units.of_dof(name, dof): size for name, size in sizes.items()}
        return found

    def to_dataframe(self, dof: int | None = None, units: Units = SI) -> Any:
        """Return the result as a pandas DataFrame, one row for each steady state.

        Parameters
        ----------
        dof : int, optional
            DOF whose displacement amplitude is added, with its error if known.
        units : Units
            Units of frequencies and displacements. Default: rad/s and m.

        Returns
        -------
        DataFrame
            Table with the columns of `columns`.
        """
        return dataframe(self.columns(dof, units))


@frozen
class CurveResult(Tabulated):
    """Hold steady states of a model, one after the other.

    Attributes
    ----------
    motion : SteadyMotion
        Motion of all DOFs.
    """

    motion: SteadyMotion

    @property
    def mode_shapes(self) -> Floats:
        """Mass-normalised mode shapes, (n_dofs, modes) [kg^-1/2]."""
        return self.motion.model.reduced.mode_shapes

    def size(self, shown: Shown = MODAL_AMPLITUDES) -> Floats:
        """Return the amplitudes as plots and tables show them.

        Parameters
        ----------
        shown : Shown
            Modal amplitudes, or displacement amplitudes of a DOF in given units. Default: modal
            amplitudes [kg^1/2 m].

        Returns
        -------
        ndarray
            Amplitudes, in the units of `shown` and in the shape of the amplitudes of the result.
        """
        return self._in_shape(shown.size(self.motion))

    def _in_shape(self, sizes: Floats) -> Floats:
        """Return amplitudes (points, modes) of `motion` in the shape of the result."""
        raise NotImplementedError

    def displacement(self, dof: int) -> Floats:
        """Return the displacement amplitude of a DOF at the carrier of each mode of the result.

        Parameters
        ----------
        dof : int
            Index of the DOF.

        Returns
        -------
        ndarray
            Displacement amplitudes [m], in the shape of the amplitudes of the result.

        Raises
        ------
        SlipmodeError
            If there is no such DOF.
        """
        return self.size(Shown(dof))


@frozen
class ModeCurve(CurveResult):
    """Hold steady states of one mode.

    Attributes
    ----------
    motion : SteadyMotion
        Motion of all DOFs.
    mode : int
        0 for A, 1 for B.
    """

    mode: int

    @property
    def mode_shape(self) -> Floats:
        """Mass-normalised mode shape, (n_dofs,) [kg^-1/2]."""
        return self.mode_shapes[:, self.mode]

    def _in_shape(self, sizes: Floats) -> Floats:
        return sizes[:, self.mode]


def axes_or_current(ax: Axes | None) -> Axes:
    """Return the given axes of a plot, or the current axes."""
    current: Axes = extra("matplotlib.pyplot", "pictures").gca() if ax is None else ax
    return current


def axes_or_new(axes: Any, rows: int, columns: int, **options: Any) -> Any:
    """Return the given axes of a plot, or new axes in rows and columns."""
    if axes is None:
        axes = extra("matplotlib.pyplot", "pictures").subplots(rows, columns, **options)[1]
    return axes


def plot_band(
    ax: Axes, x: Floats, y: Floats, error: Floats, lowest: ArrayLike = -np.inf, **options: Any
) -> None:
    """Plot the error of a curve as a band around it, above `lowest`."""
    ax.fill_between(x, np.maximum(y - error, lowest), y + error, alpha=_BAND, lw=0, **options)


def label_point(
    ax: Axes,
    text: str,
    at: tuple[float, float],
    color: Any,
    above: float,
    ha: Literal["center", "right"] = "center",
) -> None:
    """Write a text at a distance [points] `above` a point, or below it if negative."""
    va: Literal["top", "baseline"] = "top" if above < 0.0 else "baseline"
    ax.annotate(text, at, (0.0, above), textcoords="offset points", color=color, ha=ha, va=va)
