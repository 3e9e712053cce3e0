"""Elastic friction in one direction: Jenkins elements and distributions of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements, checked, per_contact, sliders_on
from slipmode.rom.short_repr import short_repr


@dataclass(frozen=True)
class Jenkins:
    """Describe a Jenkins element: a spring and a slider s in series.

    The force is f = k_t (x - s) with |f| <= mu N.

    Parameters
    ----------
    limit : float or sequence of float
        Friction limit mu N [N], >= 0, one value or one per contact DOF.
    stiffness : float or sequence of float
        Stiffness in stick k_t [N/m], > 0, one value or one per contact DOF.

    Raises
    ------
    SlipmodeError
        If a value is not allowed.
    """

    limit: float | Sequence[float]
    stiffness: float | Sequence[float]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "limit", checked("limit", self.limit, "[N]"))
        stiffness = checked("stiffness", self.stiffness, "[N/m]", positive=True)
        object.__setattr__(self, "stiffness", stiffness)

    def elements(self, contacts: int) -> Elements:
        """Return the law as the compiled core reads it.

        Parameters
        ----------
        contacts : int
            Number of contact DOFs N_c.

        Returns
        -------
        Elements
            One Jenkins element for each contact DOF.

        Raises
        ------
        SlipmodeError
            If the number of limits or stiffnesses is neither 1 nor N_c.
        """
        limit = per_contact("limit", self.limit, contacts)
        stiffness = per_contact("stiffness", self.stiffness, contacts)
        return sliders_on(limit[:, np.newaxis], stiffness[:, np.newaxis])


@dataclass(frozen=True)
class Iwan:
    """Describe Segalman's four-parameter Iwan model: Jenkins elements in parallel.

    A slider slips at its displacement phi. The density of the sliders is proportional to phi^chi
    up to macro-slip, where the remaining sliders slip together. At small amplitudes the
    dissipation per cycle is proportional to |x|^(chi + 3).

    Parameters
    ----------
    force : float
        Force of macro-slip F_S [N], > 0.
    stiffness : float
        Tangential stiffness in stick K_T [N/m], > 0.
    chi : float
        Exponent of the density [-], -1 < chi <= 1. Segalman has chi <= 0; 0.6 was measured on a
        beam with a bolted joint.
    beta : float
        Stiffness of the sliders that slip at macro-slip, relative to the stiffness of all other
        sliders [-], >= 0.
    sliders : int, default 72
        Number of sliders that represent the distribution, evenly spaced in log phi, 2 to 1000.

    Raises
    ------
    SlipmodeError
        If a parameter is outside its range.

    References
    ----------
    Segalman, D. J., A four-parameter Iwan model for lap-type joints, J. Appl. Mech. 72 (2005).
    """

    LARGEST_CHI: ClassVar[float] = 1.0

    force: float
    stiffness: float
    chi: float
    beta: float
    # 18 per decade of displacement: from 3e-3 of macro-slip on, the dissipation is within 1 % of
    # the continuous distribution's, for chi up to 1 within 2.1 %
    # (tests/rom/contact/test_one_contact.py)
    sliders: int = 72

    __repr__ = short_repr

    def __post_init__(self) -> None:
        checked("force", self.force, "[N]", positive=True)
        checked("stiffness", self.stiffness, "[N/m]", positive=True)
        checked("beta", self.beta, "[-]")
        if not -1.0 < self.chi <= self.LARGEST_CHI:
            raise SlipmodeError(
                f"chi: must be above -1 and at most {self.LARGEST_CHI:g}, got {self.chi}"
            )
        if not 2 <= self.sliders <= 1000:
            raise SlipmodeError(f"sliders: must be 2 to 1000, got {self.sliders}")

    def distribution(self) -> tuple[Floats, Floats]:
        """Return the friction limit and the stiffness of each slider, in the order of slip.

        Each slider has the stiffness and the limit of its interval of the density. The sums K_T
        and F_S are therefore exact.

        Returns
        -------
        limit : (sliders,) ndarray
            Friction limits [N].
        stiffness : (sliders,) ndarray
            Stiffnesses [N/m].
        """
        chi, beta = self.chi, self.beta
        share = beta + (chi + 1.0) / (chi + 2.0)
        largest = self.force * (1.0 + beta) / (self.stiffness * share)
        density = self.force * (chi + 1.0) / (largest ** (chi + 2.0) * share)
        # the first slides at a displacement of 1e-4 of macro-slip
        ends = largest * np.append(0.0, np.geomspace(1e-4, 1.0, self.sliders))
        stiffness = density * np.diff(ends ** (chi + 1.0)) / (chi + 1.0)
        limit = density * np.diff(ends ** (chi + 2.0)) / (chi + 2.0)
        if beta > 0.0:
            last = self.force * beta / (largest * share)
            stiffness, limit = np.append(stiffness, last), np.append(limit, last * largest)
        return limit, stiffness

    def elements(self, contacts: int) -> Elements:
        """Return the law as the compiled core reads it.

        Parameters
        ----------
        contacts : int
            Number of contact DOFs N_c.

        Returns
        -------
        Elements
            All sliders of the distribution on each contact DOF.
        """
        limit, stiffness = self.distribution()
        return sliders_on(np.tile(limit, (contacts, 1)), np.tile(stiffness, (contacts, 1)))


@dataclass(frozen=True)
class Sliders:
    """Describe several Jenkins elements in parallel, with equal parameters at all contacts.

    Parameters
    ----------
    limit : sequence of float
        Friction limit of each element [N], >= 0.
    stiffness : sequence of float
        Stiffness of each element [N/m], > 0. An element with a large limit is a spring.

    Raises
    ------
    SlipmodeError
        If the sequences differ in length, or a value is not allowed.
    """

    limit: Sequence[float]
    stiffness: Sequence[float]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        limit = np.atleast_1d(checked("limit", self.limit, "[N]"))
        stiffness = np.atleast_1d(checked("stiffness", self.stiffness, "[N/m]", positive=True))
        if limit.size != stiffness.size:
            raise SlipmodeError(
                f"stiffness: must be {limit.size} numbers, one per slider, got {stiffness.size}"
            )
        object.__setattr__(self, "limit", tuple(limit.tolist()))
        object.__setattr__(self, "stiffness", tuple(stiffness.tolist()))

    def elements(self, contacts: int) -> Elements:
        """Return the law as the compiled core reads it.

        Parameters
        ----------
        contacts : int
            Number of contact DOFs N_c.

        Returns
        -------
        Elements
            All Jenkins elements on each contact DOF.
        """
        limit, stiffness = np.array(self.limit), np.array(self.stiffness)
        return sliders_on(np.tile(limit, (contacts, 1)), np.tile(stiffness, (contacts, 1)))
