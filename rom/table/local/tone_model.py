"""Several modes of a structure on one or two tones, with the friction of each contact."""

from __future__ import annotations

from typing import NoReturn, Self

import numpy as np

from slipmode.rom.arrays import Complexes, as_floats
from slipmode.rom.errors import SlipmodeError, UnsettledError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction, check_law
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.reduction.tones import sliding_law
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.local_contacts import LocalContacts
from slipmode.rom.table.local.local_torus import LocalTorus

_NO_TABLE = (
    "model: its modes share a tone, and it has no friction table over their amplitudes; use "
    "rom.steady, rom.response_curve, rom.tone_flow, fmu.Component or fmu.export"
)
_TWO_TONES = (
    "model: its modes are on two tones, which have steady states alone; use rom.steady, or retain "
    "the modes of one tone"
)


@frozen
class ToneModel:
    """Represent modes that share one or two tones. They act on each other through all contacts.

    `rom.tabulate` makes it, if `rom.reduce` received modes that share a tone. `rom.steady`,
    `rom.response_curve`, `rom.tone_flow`, `fmu.Component` and `fmu.export` take it on one tone,
    `rom.steady` on two tones.

    Attributes
    ----------
    reduced : Reduced
        Reduced structure.
    law : Jenkins, Iwan, Sliders or Contacts
        Contact law.
    tolerance : float
        Largest error of steady amplitudes relative to the largest of them, and of a step in time
        [-].
    local : LocalContacts or LocalTorus
        Force deficit of each contact against its displacement, on one tone or two.
    """

    reduced: Reduced
    law: Elastic
    tolerance: float
    local: LocalContacts | LocalTorus

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
        if middle.size == 2:
            local = LocalTorus.of(sliding, -np.diag(reduced.stiffness), middle)
            return cls(reduced, sliding, tolerance, local)
        alone = np.zeros(reduced.n_contacts, dtype=complex)
        table = local_contacts(reduced, sliding, float(middle[0]), alone)
        return cls(reduced, sliding, tolerance, table)

    @property
    def modes(self) -> int:
        """Number of modes."""
        return len(self.reduced.modes)

    @property
    def middle(self) -> float:
        """Middle of the range of the natural frequencies of one tone [rad/s]."""
        self.check_one_tone()
        return 0.5 * float(self.reduced.frequency.min() + self.reduced.frequency.max())

    def check_one_tone(self) -> None:
        """Refuse modes on two tones, for all but their steady states."""
        if self.reduced.tones > 1:
            raise SlipmodeError(_TWO_TONES)

    @property
    def table(self) -> NoReturn:
        """Refuse what needs a friction table over the amplitudes of one or two modes."""
        raise SlipmodeError(_NO_TABLE)

    def check_mode(self, mode: int) -> NoReturn:
        """Refuse a function that needs a table of one mode."""
        raise SlipmodeError(_NO_TABLE)


def local_contacts(
    reduced: Reduced, law: Elastic, frequency: float, at_carrier: Complexes
) -> LocalContacts:
    """Return the contacts at a frequency [rad/s], each with its own flexibility at harmonics.

    `at_carrier` (N_c,) is their flexibility at the carrier [m/N], see `LocalContacts.of`.
    """

    def own(nu: float) -> Complexes:
        return np.diag(reduced.reaction(nu) - reduced.stiffness)

    try:
        return LocalContacts.of(law, at_carrier, own, frequency)
    except UnsettledError:
        # Close to a mode a harmonic of one contact alone may not converge, while all contacts
        # together do. Steady states include the mode, and transients state what they neglect.
        static = np.diag(-reduced.stiffness).astype(complex)
        return LocalContacts.of(law, at_carrier, lambda _: static, frequency)
