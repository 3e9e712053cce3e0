"""Nodal-diameter and Campbell diagrams of bladed disks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from typing import TYPE_CHECKING, Any

import numpy as np

from slipmode.rom import SlipmodeError, Units
from slipmode.rom.common import RPM, Floats, frozen
from slipmode.rom.cyclic.diameter_modes import DiameterModes
from slipmode.rom.cyclic.structure import CyclicStructure, checked_integer, excited_diameter
from slipmode.rom.laws import Elastic
from slipmode.rom.slow import SI, axes_or_current, label_point

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@frozen
class NodalDiameterDiagram:
    """Hold the natural frequencies of the mode families of a disk against the nodal diameter.

    Attributes
    ----------
    sectors : int
        Number of sectors N.
    frequency : (N // 2 + 1, families) ndarray
        Natural frequencies with stuck contacts for nodal diameters 0 to N // 2 [rad/s].
    """

    sectors: int
    frequency: Floats

    def plot(self, ax: Axes | None = None, units: Units = SI) -> Any:
        """Plot the frequency of each family against the nodal diameter.

        Parameters
        ----------
        ax : Axes, optional
            Matplotlib axes. Default: the current axes.
        units : Units
            Unit of frequencies. Default: rad/s.

        Returns
        -------
        Axes
            Axes of the plot.
        """
        ax = axes_or_current(ax)
        for family, values in enumerate(self.frequency.T):
            shown = units.of_frequency(values)
            (line,) = ax.plot(shown, "o-", ms=4, label=f"mode {family}")
            at, color = (len(values) - 1, shown[-1]), line.get_color()
            label_point(ax, f"mode {family}", at, color, 6.0, ha="right")
        ax.set(xlabel="nodal diameter", ylabel=units.frequency_label)
        return ax

    def columns(self, units: Units = SI) -> dict[str, Floats]:
        """Return the diagram as named columns, one row for each nodal diameter.

        Parameters
        ----------
        units : Units
            Unit of frequencies. Default: rad/s.

        Returns
        -------
        dict of str to ndarray
            Nodal diameter, and frequency of each family.
        """
        found = {"nodal_diameter": np.arange(len(self.frequency), dtype=float)}
        for family, values in enumerate(self.frequency.T):
            found[units.named(f"frequency_{family}")] = units.of_frequency(values)
        return found

    def campbell(
        self, rotor_speed: tuple[float, float], engine_orders: Sequence[int]
    ) -> CampbellDiagram:
        """Return the Campbell diagram: crossings of engine orders with the modes that they excite.

        Parameters
        ----------
        rotor_speed : (float, float)
            Lowest and highest rotor speed [rpm], >= 0.
        engine_orders : sequence of int
            Engine orders, >= 1.

        Returns
        -------
        CampbellDiagram
            Frequencies and crossings in this range of speeds.

        Raises
        ------
        SlipmodeError
            If the speeds are not ascending, or an engine order is below 1.
        """
        low, high = rotor_speed
        if not (np.isfinite(high) and 0.0 <= low < high):
            raise SlipmodeError(
                f"rotor_speed: must be two numbers >= 0, ascending [rpm], got {low:g} and {high:g}"
            )
        orders = [int(order) for order in engine_orders]
        if not orders or min(orders) < 1:
            raise SlipmodeError(f"engine_orders: must be integers from 1, got {orders}")
        crossings = []
        for order in orders:
            k = excited_diameter(order, self.sectors)
            for family, omega in enumerate(self.frequency[abs(k)].tolist()):
                speed = omega / (order * RPM)
                if low <= speed <= high:
                    crossings.append(Crossing(order, k, family, speed, omega))
        return CampbellDiagram(self, (low, high), tuple(orders), tuple(crossings))


@frozen
class Crossing:
    """Hold a rotor speed at which an engine order excites a mode in resonance.

    Attributes
    ----------
    engine_order : int
        Engine order.
    nodal_diameter : int
        Nodal diameter; negative for a backward wave.
    mode : int
        Mode of this nodal diameter, from 0.
    rotor_speed : float
        Rotor speed [rpm].
    frequency : float
        Natural frequency [rad/s].
    """

    engine_order: int
    nodal_diameter: int
    mode: int
    rotor_speed: float
    frequency: float


@frozen
class CampbellDiagram:
    """Hold frequencies against rotor speed: modes, engine orders, and their crossings.

    Natural frequencies do not depend on the rotor speed.

    Attributes
    ----------
    diameters : NodalDiameterDiagram
        Natural frequencies.
    rotor_speed : (float, float)
        Lowest and highest rotor speed [rpm].
    engine_orders : tuple of int
        Engine orders.
    crossings : tuple of Crossing
        Crossings of each engine order with the modes of the nodal diameter that it excites.
    """

    diameters: NodalDiameterDiagram
    rotor_speed: tuple[float, float]
    engine_orders: tuple[int, ...]
    crossings: tuple[Crossing, ...]

    def plot(self, ax: Axes | None = None, units: Units = SI) -> Any:
        """Plot mode families, engine orders and crossings against the rotor speed.

        Parameters
        ----------
        ax : Axes, optional
            Matplotlib axes. Default: the current axes.
        units : Units
            Unit of frequencies. Default: rad/s.

        Returns
        -------
        Axes
            Axes of the plot.
        """
        ax = axes_or_current(ax)
        frequency, speed = units.of_frequency(self.diameters.frequency), np.array(self.rotor_speed)
        for family, values in enumerate(frequency.T):
            ax.axhspan(values.min(), values.max(), color=f"C{family}", alpha=0.2, lw=0)
            ax.hlines(values, *speed, color=f"C{family}", lw=0.5)
        excited = max(self.engine_orders) * RPM * speed[1]
        top = min(1.1 * float(self.diameters.frequency.max()), 1.5 * float(excited))
        for order in self.engine_orders:
            ax.plot(speed, units.of_frequency(order * RPM * speed), "0.5", lw=0.8)
            end = min(speed[1], top / (order * RPM))
            exit_at = end, float(units.of_frequency(order * RPM * end))
            ax.annotate(f"EO {order}", exit_at, xytext=(3, 2), textcoords="offset points")
        at = [(c.rotor_speed, float(units.of_frequency(c.frequency))) for c in self.crossings]
        ax.plot(*np.array(at).reshape(-1, 2).T, "ko", ms=4)
        ax.set(xlabel="rotor speed [rpm]", ylabel=units.frequency_label)
        ax.set(xlim=self.rotor_speed, ylim=(0.0, units.of_frequency(top)))
        return ax

    def columns(self, units: Units = SI) -> dict[str, Floats]:
        """Return the diagram as named columns, one row for each crossing.

        Parameters
        ----------
        units : Units
            Unit of frequencies. Default: rad/s.

        Returns
        -------
        dict of str to ndarray
            Engine order, nodal diameter, mode, rotor speed [rpm] and frequency.
        """
        names = ("engine_order", "nodal_diameter", "mode", "rotor_speed")
        *columns, omega = np.array([astuple(each) for each in self.crossings]).reshape(-1, 5).T
        found = dict(zip(names, columns, strict=True))
        return found | {units.named("frequency"): units.of_frequency(omega)}


def nodal_diameter_diagram(
    structure: CyclicStructure, law: Elastic, families: int = 3
) -> NodalDiameterDiagram:
    """Return the natural frequencies of a disk with stuck contacts against the nodal diameter.

    Parameters
    ----------
    structure : CyclicStructure
        Disk without aerodynamic forces.
    law : Jenkins, Iwan, Sliders, FrictionalContact or Contacts
        Elastic law of the contacts of one sector.
        Its springs are the stuck contacts.
    families : int, default 3
        Number of modes of each nodal diameter, at most the number of free DOFs of a sector.

    Returns
    -------
    NodalDiameterDiagram
        Frequencies for nodal diameters 0 to N // 2.

    Raises
    ------
    SlipmodeError
        If the law is not elastic, or the number of families is not allowed.
    """
    most = structure.free_dofs.size
    families = checked_integer("families", families, f"from 1 to {most}", 1, most)
    reference = law.elements(structure.n_contacts).reference
    every = (
        DiameterModes.of(structure, k, reference, families, lambda squares: 0.0)
        for k in range(structure.highest_diameter + 1)
    )
    frequency = np.array([modes.frequency[:families] for modes in every])
    return NodalDiameterDiagram(structure.sectors, frequency)
