"""Different laws at different contacts of one structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.elements import Elements, joined
from slipmode.rom.laws.frictional_contact import FrictionalContact
from slipmode.rom.laws.joint_laws import Iwan, Jenkins, Sliders
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.short_repr import short_repr

ElasticLaw = Jenkins | Iwan | Sliders | FrictionalContact


@dataclass(frozen=True)
class Contacts:
    """Assign laws to groups of contacts.

    Parameters
    ----------
    groups : sequence of (law, contact DOFs)
        Elastic law and contact DOFs (columns of W) of each group. Each contact DOF is in exactly
        one group.

    Raises
    ------
    SlipmodeError
        If there is no group, or a law is not elastic.
    """

    groups: Sequence[tuple[ElasticLaw, Sequence[int]]]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        groups = tuple((law, tuple(int(c) for c in columns)) for law, columns in self.groups)
        if not groups:
            raise SlipmodeError("contacts: must have at least one group")
        if not all(isinstance(law, ElasticLaw) for law, _ in groups):
            raise SlipmodeError(
                "contacts: groups must have elastic laws; a rigid law applies to all contacts"
            )
        object.__setattr__(self, "groups", groups)

    def elements(self, contacts: int) -> Elements:
        """Return the laws of all groups as the compiled core reads them.

        Parameters
        ----------
        contacts : int
            Number of contact DOFs N_c.

        Returns
        -------
        Elements
            Elements of all groups.

        Raises
        ------
        SlipmodeError
            If a contact DOF is in no group or in several groups.
        """
        columns = [column for _, group in self.groups for column in group]
        if sorted(columns) != list(range(contacts)):
            wrong = {
                "missing": sorted(set(range(contacts)) - set(columns)),
                "in two groups": sorted({c for c in columns if columns.count(c) > 1}),
                "unknown": sorted(set(columns) - set(range(contacts))),
            }
            said = "; ".join(f"{word}: {which}" for word, which in wrong.items() if which)
            raise SlipmodeError(
                f"contacts: every contact DOF, 0 to {contacts - 1}, must be in one group; {said}"
            )
        parts = [(law.elements(len(group)), group) for law, group in self.groups]
        return joined(parts, contacts)


Elastic = ElasticLaw | Contacts | NoContacts
