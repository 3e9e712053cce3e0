"""Groups of contacts with a common law, and the parameters of their laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from slipmode.rom import Contacts, FrictionalContact, Iwan, Jenkins, SlipmodeError
from slipmode.rom.common import Floats, frozen, in_one_line

GroupLaw: TypeAlias = Jenkins | Iwan

_PARAMETERS: dict[type, tuple[str, ...]] = {
    Jenkins: ("limit", "stiffness"),
    Iwan: ("force", "stiffness", "chi", "beta"),
}


@frozen
class SliderGroup:
    """Jenkins elements in parallel on each contact of a group, for several laws."""

    columns: tuple[int, ...]
    limit: Floats  # (laws, sliders) [N]
    stiffness: Floats  # (laws, sliders) [N/m]


@frozen
class ContactGroups:
    """Groups of contacts and their free parameters.

    Parameters have names GROUP.PARAMETER. The fit uses the logarithms of their values, for chi of
    1 + chi.

    Attributes
    ----------
    groups : dict
        Initial law and contact DOFs by name.
    names : tuple of str
        Free parameters.
    """

    groups: dict[str, tuple[GroupLaw, tuple[int, ...]]]
    names: tuple[str, ...]

    @classmethod
    def of(
        cls,
        groups: Mapping[str, tuple[GroupLaw, Sequence[int]]],
        fixed: Sequence[str],
    ) -> ContactGroups:
        """Return the groups, checked."""
        if not isinstance(groups, Mapping) or not groups:
            raise SlipmodeError(
                f"groups: must be {{name: (law, contact DOFs)}}, got {in_one_line(groups)}"
            )
        names = []
        for name, group in groups.items():
            law = _checked_group(name, group)
            names += [f"{name}.{key}" for key in _PARAMETERS[type(law)]]
        if unknown := [name for name in fixed if name not in names]:
            raise SlipmodeError(
                f"fixed: {in_one_line(unknown[0])} is not a parameter, allowed: {', '.join(names)}"
            )
        free = tuple(name for name in names if name not in fixed)
        made = cls({k: (law, tuple(columns)) for k, (law, columns) in groups.items()}, free)
        for name, value in zip(free, np.exp(made.initial()), strict=True):
            if not value > 0.0:
                raise SlipmodeError(f"{name} = 0: must be > 0, or be listed in fixed")
        return made

    def initial(self) -> Floats:
        """Return the initial logarithms of the free parameters, (names,)."""
        values = []
        for name in self.names:
            group, _, key = name.rpartition(".")
            value = getattr(self.groups[group][0], key) + (key == "chi")
            values.append(np.log(value) if value > 0.0 else -np.inf)
        return np.array(values)

    def laws(self, logarithms: Floats) -> dict[str, GroupLaw]:
        """Return the law of each group with other parameters (names,)."""
        changed: dict[str, dict[str, Any]] = {name: {} for name in self.groups}
        for name, value in zip(self.names, logarithms, strict=True):
            group, _, key = name.rpartition(".")
            changed[group][key] = parameter_value(name, value)
        return {name: replace(law, **changed[name]) for name, (law, _) in self.groups.items()}

    def contacts(self, logarithms: Floats) -> Contacts:
        """Return the laws at their contacts."""
        laws = self.laws(logarithms)
        return Contacts([(laws[name], columns) for name, (_, columns) in self.groups.items()])

    def sliders(self, logarithms: Floats) -> list[SliderGroup]:
        """Return the sliders of each group for parameters (laws, names)."""
        found = [self.laws(each) for each in logarithms]
        made = []
        for name, (_, columns) in self.groups.items():
            elements = [laws[name].elements(1).slider for laws in found]
            limit, stiffness = np.moveaxis(np.array(elements), -1, 0)
            made.append(SliderGroup(columns, limit, stiffness))
        return made


def parameter_value(name: str, logarithm: Any) -> Any:
    """Return the value of a parameter from its logarithm, for chi from the one of 1 + chi."""
    value = np.exp(logarithm)
    if name.endswith(".chi"):
        return np.minimum(value - 1.0, Iwan.LARGEST_CHI)
    return value


def _checked_group(name: Any, group: Any) -> GroupLaw:
    pair = isinstance(group, Sequence) and len(group) == 2
    if pair and isinstance(group[0], FrictionalContact):
        raise SlipmodeError(
            f"groups: {in_one_line(name)} has a FrictionalContact, which cannot be fitted; for "
            "contacts that stay closed use rom.Jenkins with limit mu * preload in the tangential "
            "directions, and put the normal springs into the structure"
        )
    if not (isinstance(name, str) and pair and isinstance(group[0], GroupLaw)):
        raise SlipmodeError(
            f"groups: {in_one_line(name)} must be (rom.Jenkins or rom.Iwan, contact DOFs), "
            f"got {in_one_line(group)}"
        )
    law: GroupLaw = group[0]
    for key in _PARAMETERS[type(law)]:
        if np.ndim(getattr(law, key)):
            raise SlipmodeError(
                f"groups: {name}.{key} must be one number; put contacts with other values into "
                "another group"
            )
    return law
