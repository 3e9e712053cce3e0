"""Several modes of a structure on one or two tones, with the friction of each contact."""

from __future__ import annotations

from typing import Any, NoReturn, Self
from weakref import WeakKeyDictionary

import numpy as np

from slipmode.rom.arrays import Complexes, Floats, as_floats
from slipmode.rom.errors import SlipmodeError, UnsettledError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction, check_law
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.reduction.tones import sliding_law
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.local_contacts import LocalContacts

_NO_TABLE = (
    "model: its modes share a tone, and it has no friction table over their amplitudes; use "
    "rom.steady, rom.response_curve, rom.tone_flow, fmu.Component or fmu.export"
)


@frozen
class ToneModel:
    """Represent modes that share one or two tones. They act on each other through all contacts.

    `rom.tabulate` makes it, if `rom.reduce` received modes that share a tone. `rom.steady`,
    `rom.steady`, `rom.response_curve`, `rom.tone_flow`, `fmu.Component` and `fmu.export` take it.

    Attributes
    ----------
    reduced : Reduced
        Reduced structure.
    law : Jenkins, Iwan, Sliders or Contacts
        Contact law.
    tolerance : float
        Largest error of steady amplitudes relative to the largest of them, and of a step in time
        [-].
    local : LocalContacts
        Force deficit of each contact against its displacement.
    """

    reduced: Reduced
    law: Elastic
    tolerance: float
    local: LocalContacts

    @classmethod
    def of(cls, reduced: Reduced, law: Friction, tolerance: float) -> Self:
        """Return the model of modes that share a tone.

        Raises
        ------
        SlipmodeError
            If the law does not fit `reduced`, or the tolerance is outside its range.
        """
        if not 1e-4 <= as_floats("tolerance", tolerance) <= 0.1:
            raise SlipmodeError(
                f"tolerance: must be 1e-4 to 0.1 for modes that share a tone, got {tolerance}"
            )
        check_law(reduced.n_contacts, reduced.contacts, law)
        sliding = sliding_law(law, reduced.n_contacts)
        middle = np.array([reduced.frequency[own].mean() for own in reduced.on_tones])
        alone = np.zeros((middle.size, reduced.n_contacts), dtype=complex)
        return cls(reduced, sliding, tolerance, local_contacts(reduced, sliding, middle, alone))

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.reduced.modes)

    @property
    def middle(self) -> Any:
        """Middle of the range of the natural frequencies of a tone [rad/s], (2,) of two tones."""
        return float(self.carrier[0]) if self.carrier.size == 1 else self.carrier

    @property
    def carrier(self) -> Floats:
        """Middle of the range of the natural frequencies of each tone, (tones,) [rad/s]."""
        each = [self.reduced.frequency[own] for own in self.reduced.on_tones]
        return np.array([0.5 * (own.min() + own.max()) for own in each])

    @property
    def table(self) -> NoReturn:
        """Refuse what needs a friction table over the amplitudes of one or two modes."""
        raise SlipmodeError(_NO_TABLE)

    def check_mode(self, mode: int) -> NoReturn:
        """Refuse a function that needs a table of one mode."""
        raise SlipmodeError(_NO_TABLE)


_kept: WeakKeyDictionary[ToneModel, tuple[bytes, LocalContacts]] = WeakKeyDictionary()


def contacts_near(model: ToneModel, frequency: Floats, at_carrier: Complexes) -> LocalContacts:
    """Return the `local_contacts` of a model; it keeps the last ones, which take seconds."""
    key = frequency.tobytes() + at_carrier.tobytes()
    if model not in _kept or _kept[model][0] != key:
        found = local_contacts(model.reduced, model.law, frequency, at_carrier)
        _kept[model] = key, found
    return _kept[model][1]


def local_contacts(
    reduced: Reduced, law: Elastic, frequency: Floats, at_carrier: Complexes
) -> LocalContacts:
    """Return the contacts at frequencies (tones,) [rad/s].

    `at_carrier` (tones, N_c) is their flexibility at the carriers [m/N], see `LocalContacts.of`.
    On one tone each has its own flexibility at harmonics, and the static one on two tones.
    """
    static = np.diag(-reduced.stiffness).astype(complex)

    def own(nu: float) -> Complexes:
        return np.diag(reduced.reaction(nu) - reduced.stiffness)

    try:
        of_harmonics = own if frequency.size == 1 else lambda _: static
        return LocalContacts.of(law, at_carrier, of_harmonics, frequency)
    except UnsettledError:
        # Close to a mode a harmonic of one contact alone may not converge, while all contacts
        # together do. Steady states include the mode, and transients state what they neglect.
        return LocalContacts.of(law, at_carrier, lambda _: static, frequency)
