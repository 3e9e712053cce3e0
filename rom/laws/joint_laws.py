"""Elastic friction in one direction: Jenkins elements and distributions of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements, checked, per_contact, sliders_on
from slipmode.rom.short_repr import short_repr

LARGEST_CHI = 1.0


@dataclass(frozen=True)
class Jenkins:
    """A spring and a slider s in series: f = k_t (x - s), |f| <= mu N.

    Parameters
    ----------
    limit : float or sequence of float
        Friction limit mu N [N], one value or one per contact, >= 0.
    stiffness : float or sequence of float
        k_t [N/m], > 0: the stiffness in stick.
    """

    limit: float | Sequence[float]
    stiffness: float | Sequence[float]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "limit", checked("limit", self.limit, "[N]"))
        stiffness = checked("stiffness", self.stiffness, "[N/m]", positive=True)
        object.__setattr__(self, "stiffness", stiffness)

    def elements(self, contacts: int) -> Elements:
        """Return one element on each of `contacts` contact DOFs."""
        limit = per_contact("limit", self.limit, contacts)
        stiffness = per_contact("stiffness", self.stiffness, contacts)
        return sliders_on(limit[:, np.newaxis], stiffness[:, np.newaxis])


@dataclass(frozen=True)
class Iwan:
    """Jenkins elements in parallel, with the distribution of Segalman's four parameters.

    Sliders slip from zero force on, with a density ~ phi^chi of the displacement phi at which they
    slip, up to macro-slip, at which the rest slips at once. At small amplitudes the dissipation
    per cycle is ~ |x|^(chi + 3).

    Parameters
    ----------
    force : float
        F_S, force of macro-slip [N], > 0.
    stiffness : float
        K_T, tangential stiffness in stick [N/m], > 0.
    chi : float
        -1 < chi <= 1. Segalman has chi <= 0; 0.6 was measured on a beam with a bolted joint.
    beta : float
        Stiffness of the sliders that slip at macro-slip, relative to the others, >= 0.
    sliders : int
        Number of sliders that represent the distribution, evenly spaced in log phi.

    References
    ----------
    D. J. Segalman, A four-parameter Iwan model for lap-type joints, J. Appl. Mech. 72 (2005).
    """

    force: float
    stiffness: float
    chi: float
    beta: float
    # 18 per decade of displacement: from 3e-3 of macro-slip on, the dissipation is within 1 % of
    # the continuous distribution's, for chi up to LARGEST_CHI within 2.1 %
    # (tests/rom/table/test_tolerance.py)
    sliders: int = 72

    __repr__ = short_repr

    def __post_init__(self) -> None:
        checked("force", self.force, "[N]", positive=True)
        checked("stiffness", self.stiffness, "[N/m]", positive=True)
        checked("beta", self.beta, "[-]")
        if not -1.0 < self.chi <= LARGEST_CHI:
            raise SlipmodeError(
                f"chi: must be above -1 and at most {LARGEST_CHI:g}, got {self.chi}"
            )
        if not 2 <= self.sliders <= 1000:
            raise SlipmodeError(f"sliders: must be 2 to 1000, got {self.sliders}")

    def distribution(self) -> tuple[Floats, Floats]:
        """Return limit [N] and stiffness [N/m] of each slider, in the order in which they slip.

        Each has the stiffness and the limit of its part of the density, so K_T and F_S are exact.
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
        """Return the distribution on each of `contacts` contact DOFs."""
        limit, stiffness = self.distribution()
        return sliders_on(np.tile(limit, (contacts, 1)), np.tile(stiffness, (contacts, 1)))


@dataclass(frozen=True)
class Sliders:
    """A list of Jenkins elements in parallel, the same on each contact.

    Parameters
    ----------
    limit : sequence of float
        Friction limit of each [N], >= 0.
    stiffness : sequence of float
        Stiffness of each [N/m], > 0. With a large limit it is a spring.
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
        """Return the sliders on each of `contacts` contact DOFs."""
        limit, stiffness = np.array(self.limit), np.array(self.stiffness)
        return sliders_on(np.tile(limit, (contacts, 1)), np.tile(stiffness, (contacts, 1)))
