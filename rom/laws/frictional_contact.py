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

_ROUNDING = 1e-9  # of a tangential force at the friction limit, relative to it


@dataclass(frozen=True)
class FrictionalContact:
    """Describe an elastic contact with normal force, friction and lift-off.

    The normal force is N = max(0, N0 + k_n (x_n - gap)). The tangential force is
    T = T0 + k_t (x_t - s), at most mu N in magnitude. The contact is open where N = 0, and the
    slider s starts again at touch-down. Displacements start from rest, where s = 0.

    Parameters
    ----------
    mu : float or sequence of float
        Coefficient of friction [-], >= 0, one value or one per contact.
    preload : float or sequence of float
        Normal force at rest N0 [N], >= 0. It is in equilibrium with loads that the model does
        not contain.
    tangential_stiffness, normal_stiffness : float or sequence of float
        Contact stiffnesses k_t and k_n [N/m], > 0.
    gap : float or sequence of float, default 0.0
        Normal displacement at which the contact touches [m], >= 0. A contact with a gap has no
        preload.
    tangents : {1, 2}, default 1
        Number of tangential directions of each contact. With two, the friction limit is a circle.
    tangential_preload : float or sequence of float, default 0.0
        Tangential force at rest T0 [N], at most mu N0 in magnitude, one value or one per
        tangential direction of each contact. `rom.preload` computes it.

    Raises
    ------
    SlipmodeError
        If a value is outside its range, or a contact has a gap and a preload.

    Notes
    -----
    The contact DOFs of each contact are its tangential directions and then its normal direction,
    which is positive as the contact closes.
    """

    mu: float | Sequence[float]
    preload: float | Sequence[float]
    tangential_stiffness: float | Sequence[float]
    normal_stiffness: float | Sequence[float]
    gap: float | Sequence[float] = 0.0
    tangents: int = 1
    tangential_preload: float | Sequence[float] = 0.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        units = {"mu": "[-]", "preload": "[N]", "gap": "[m]"}
        units |= {"tangential_stiffness": "[N/m]", "normal_stiffness": "[N/m]"}
        for name, unit in units.items():
            value = checked(name, getattr(self, name), unit, positive=unit == "[N/m]")
            object.__setattr__(self, name, value)
        size = checked("tangential_preload", np.abs(self.tangential_preload).tolist(), "[N]")
        given = np.where(size, self.tangential_preload, 0.0).tolist()
        value = tuple(given) if isinstance(given, list) else given
        object.__setattr__(self, "tangential_preload", value)
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
        """Return the law of contacts with given areas, from stiffnesses per area and a pressure.

        Parameters
        ----------
        area : (contacts,) array_like
            Contact areas [m^2], > 0, for instance `ContactPairs.area`.
        mu : float or sequence of float
            Coefficient of friction [-], >= 0, one value or one per contact.
        tangential_stiffness, normal_stiffness : float or (contacts,) array_like
            Contact stiffnesses per area [N/m^3], > 0.
        pressure : float or (contacts,) array_like, default 0.0
            Normal pressure at rest [Pa], >= 0.
        gap : float or (contacts,) array_like, default 0.0
            Normal displacement at which a contact touches [m], >= 0.
        tangents : {1, 2}, default 2
            Number of tangential directions of each contact.

        Returns
        -------
        FrictionalContact
            Law with the stiffnesses [N/m] and preloads [N] of these areas.

        Raises
        ------
        SlipmodeError
            If a value is outside its range, or a contact has a gap and a pressure.

        Examples
        --------
        >>> stiffness = {"tangential_stiffness": 1e12, "normal_stiffness": 2e12}
        >>> law = rom.FrictionalContact.on_areas([1e-4, 2e-4], mu=0.3, pressure=1e6, **stiffness)
        >>> law.preload
        (100.0, 200.0)
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
        """Return the law as the compiled core reads it.

        Parameters
        ----------
        contacts : int
            Number of contact DOFs N_c, a multiple of `tangents` + 1.

        Returns
        -------
        Elements
            One element for each contact.

        Raises
        ------
        SlipmodeError
            If N_c is no multiple of `tangents` + 1, or a parameter has another number of values.
        """
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
        tangential = per_contact(
            "tangential_preload", self.tangential_preload, count * self.tangents
        )
        element["tangential_preload"][:, : self.tangents] = tangential.reshape(count, -1)
        held = element["friction"] * element["preload"]
        pulled = np.linalg.norm(element["tangential_preload"], axis=1)
        if np.any(wrong := pulled > held * (1.0 + _ROUNDING)):
            k = int(np.argmax(wrong))
            raise SlipmodeError(
                f"tangential_preload: must be at most mu times the preload, {held[k]:g} N at "
                f"contact {k}; got {pulled[k]:g} N"
            )
        closed = element["gap"] == 0.0
        reference = np.zeros((count, columns))
        reference[closed, :-1] = element["tangential_stiffness"][closed, np.newaxis]
        reference[closed, -1] = element["normal_stiffness"][closed]
        return Elements(element, np.zeros((0, 2)), reference.ravel())
