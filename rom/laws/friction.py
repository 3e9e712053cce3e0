"""Friction laws g(v), gradients of a convex dissipation potential, and rules for all laws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from slipmode.rom.arrays import Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.elements import Elements, checked, per_contact
from slipmode.rom.representable import LARGEST, SMALLEST
from slipmode.rom.short_repr import short_repr


@dataclass(frozen=True)
class Tanh:
    """Describe regularised Coulomb friction g = mu N tanh(v / alpha), source Eq. (28).

    Parameters
    ----------
    limit : float or sequence of float
        Friction limit mu N [N], >= 0, one value or one per contact.
    alpha : float
        Regularisation velocity [m/s], > 0, small relative to the sliding velocities.

    Raises
    ------
    SlipmodeError
        If a limit is negative or not finite, or alpha is not positive.

    Notes
    -----
    The law has no stick: under a constant force K x below the limit, a contact creeps with a
    velocity of about alpha K x / (mu N). `Coulomb` has an exact stick state.
    """

    limit: float | Sequence[float]
    alpha: float
    code: ClassVar[int] = 0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "limit", checked("limit", self.limit, "[N]"))
        if not SMALLEST <= as_floats("alpha", self.alpha) <= LARGEST:
            raise SlipmodeError(
                f"alpha: must be {SMALLEST:g} to {LARGEST:g} [m/s], got {self.alpha}"
            )
        object.__setattr__(self, "alpha", float(self.alpha))


@dataclass(frozen=True)
class Coulomb:
    """Describe exact Coulomb friction: g = mu N sign(v) in slip, |g| <= mu N in stick.

    The force is set-valued at v = 0 and is computed without regularisation.

    Parameters
    ----------
    limit : float or sequence of float
        Friction limit mu N [N], >= 0, one value or one per contact.

    Raises
    ------
    SlipmodeError
        If a limit is negative or not finite.
    """

    limit: float | Sequence[float]
    code: ClassVar[int] = 1
    alpha: ClassVar[float] = 0.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "limit", checked("limit", self.limit, "[N]"))


RigidFriction = Tanh | Coulomb
Friction = Tanh | Coulomb | Elastic


def limits(law: Friction, contacts: int) -> Floats:
    """Return the friction limit of each contact DOF, (contacts,) [N]."""
    if not isinstance(law, Tanh | Coulomb):
        return law.elements(contacts).limit
    return per_contact("limit", law.limit, contacts)


def is_homogeneous(law: Friction, contacts: int) -> bool:
    """Return whether S(|a|; s) = s S(|a| / s; 1) for limits and preloads times s."""
    if isinstance(law, Tanh | Coulomb):
        return isinstance(law, Coulomb)
    return law.elements(contacts).homogeneous


def pulled_at_rest(law: Friction, contacts: int) -> bool:
    """Return whether a contact has a tangential force at rest."""
    if isinstance(law, Tanh | Coulomb):
        return False
    return bool(law.elements(contacts).element["tangential_preload"].any())


def check_law(contacts: int, elements: Elements | None, law: Friction) -> None:
    """Refuse a law that does not fit the reduction of a structure.

    `elements` are its contacts that were reduced as stuck; None if they are bonded.
    """
    if not isinstance(law, Friction):
        raise SlipmodeError(
            "law: must be a contact law (Tanh, Coulomb, Jenkins, Iwan, Sliders, FrictionalContact "
            f"or Contacts), got {in_one_line(law)}"
        )
    if contacts == 0:
        raise SlipmodeError(
            "law: a model from rom.model_of_rates has no contacts; use that model as it is"
        )
    if isinstance(law, Tanh | Coulomb):
        limits(law, contacts)
        if elements is not None:
            raise SlipmodeError(
                "law: this law is rigid, but the structure was reduced with elastic contacts; "
                "call rom.reduce without law"
            )
        return
    if elements is None or not np.array_equal(
        law.elements(contacts).reference, elements.reference
    ):
        raise SlipmodeError(
            "law: the structure was not reduced with the stiffness of these contacts; "
            "call rom.reduce(..., law=law)"
        )
