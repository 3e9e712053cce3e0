"""Friction under a varying normal load: elastic, sliding, and open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import FRICTIONAL, Elements, checked, per_contact
from slipmode.rom.short_repr import short_repr


@dataclass(frozen=True)
class FrictionalContact:
    """An elastic surface under a normal load N = N0 + k_n (x_n - gap) that slides and opens.

    The tangential force is k_t (x_t - s), at most mu N. The contact is open if N would be
    negative, and its slider restarts at touch-down. Contact DOFs of each contact are its
    tangential directions, then its normal, positive as it closes.

    Parameters
    ----------
    mu : float or sequence of float
        Coefficient of friction, one value or one per contact, >= 0.
    preload : float or sequence of float
        N0, normal force at rest [N], >= 0, in balance with loads that are not modelled.
    tangential_stiffness, normal_stiffness : float or sequence of float
        k_t, k_n [N/m], > 0.
    gap : float or sequence of float
        Normal displacement at which the contact touches [m], >= 0; with a gap, preload is 0.
    tangents : {1, 2}
        Number of tangential directions of each contact; with two the limit is a disk.
    """

    mu: float | Sequence[float]
    preload: float | Sequence[float]
    tangential_stiffness: float | Sequence[float]
    normal_stiffness: float | Sequence[float]
    gap: float | Sequence[float] = 0.0
    tangents: int = 1

    __repr__ = short_repr

    def __post_init__(self) -> None:
        units = {"mu": "[-]", "preload": "[N]", "gap": "[m]"}
        units |= {"tangential_stiffness": "[N/m]", "normal_stiffness": "[N/m]"}
        for name, unit in units.items():
            value = checked(name, getattr(self, name), unit, positive=unit == "[N/m]")
            object.__setattr__(self, name, value)
        if self.tangents not in (1, 2):
            raise SlipmodeError(f"tangents: must be 1 or 2, got {self.tangents}")
        loads, gaps = np.atleast_1d(self.preload), np.atleast_1d(self.gap)
        fits = 1 in (loads.size, gaps.size) or loads.size == gaps.size
        if fits and np.any((gaps > 0.0) & (loads > 0.0)):
            raise SlipmodeError("gap: must be 0 where preload > 0, because the contact is closed")

    @classmethod
    def on_areas(
        cls,
        area: ArrayLike,
        *,
        mu: float | Sequence[float],
        tangential_stiffness: ArrayLike,
        normal_stiffness: ArrayLike,
        pressure: ArrayLike = 0.0,
        gap: ArrayLike = 0.0,
        tangents: int = 2,
    ) -> Self:
        """Return the law of contacts with areas, from stiffness per area and pressure.

        Parameters
        ----------
        area : (contacts,) array_like
            [m^2], as in `ContactPairs`.
        mu, gap, tangents
            As in the law itself.
        tangential_stiffness, normal_stiffness : float or (contacts,) array_like
            Per area [N/m^3], > 0.
        pressure : float or (contacts,) array_like
            Normal pressure at rest [Pa], >= 0.
        """
        A = np.asarray(checked("area", np.asarray(area).tolist(), "[m^2]", positive=True))
        given = {
            "preload": ("pressure", pressure, "[Pa]"),
            "tangential_stiffness": ("tangential_stiffness", tangential_stiffness, "[N/m^3]"),
            "normal_stiffness": ("normal_stiffness", normal_stiffness, "[N/m^3]"),
        }
        forces: dict[str, Any] = {}
        for name, (said, value, unit) in given.items():
            positive = name != "preload"
            per_area = checked(said, np.asarray(value).tolist(), unit, positive=positive)
            forces[name] = tuple((per_contact(said, per_area, A.size) * A).tolist())
        gaps = tuple(per_contact("gap", gap, A.size).tolist())
        return cls(mu=mu, gap=gaps, tangents=tangents, **forces)

    def elements(self, contacts: int) -> Elements:
        """Return the elements on `contacts` contact DOFs, `tangents` + 1 for each contact."""
        columns = self.tangents + 1
        count, left = divmod(contacts, columns)
        if left:
            raise SlipmodeError(
                f"contact: a frictional contact has {columns} DOFs ({self.tangents} tangential, 1 "
                f"normal), so the number of DOFs must be a multiple of {columns}; got {contacts}"
            )
        element = np.zeros(count, dtype=kernel.ELEMENT)
        element["law"] = FRICTIONAL
        element["tangents"] = self.tangents
        element["column"][:, :columns] = np.arange(contacts).reshape(count, columns)
        element["friction"] = per_contact("mu", self.mu, count)
        for name in ("preload", "tangential_stiffness", "normal_stiffness", "gap"):
            element[name] = per_contact(name, getattr(self, name), count)
        closed = element["gap"] == 0.0
        reference = np.zeros((count, columns))
        reference[closed, :-1] = element["tangential_stiffness"][closed, np.newaxis]
        reference[closed, -1] = element["normal_stiffness"][closed]
        return Elements(element, np.zeros((0, 2)), reference.ravel())
