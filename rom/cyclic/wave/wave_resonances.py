"""Harmonics of the contacts near modes of the nodal diameters that they act on.

Harmonic (n, m) acts on nodal diameter n k_A + m k_B. A mode there moves the contacts with the gain
g of `DiameterModes.harmonic_gain`, of the order |n| + |m| at n Omega_A + m Omega_B.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.cyclic.wave.wave_problem import Carrier
from slipmode.rom.errors import Finding, UnsettledError
from slipmode.rom.reduction.combination import CARRIERS, Order
from slipmode.rom.short_repr import frozen

# Gain from which on a resonance is named. Waves converge at 0.35 and do not at 1
# (tests/rom/cyclic/test_internal_resonance.py).
_NAMED = 0.1


@frozen
class WaveResonance:
    """A harmonic of the contacts, and the mode that responds to it most.

    Attributes
    ----------
    gain : float
        g.
    order : (int, int)
        n, m.
    frequency : float
        |n Omega_A + m Omega_B| [rad/s].
    nodal_diameter, mode : int
        Of the mode that responds.
    natural_frequency : float
        [rad/s]
    """

    gain: float
    order: Order
    frequency: float
    nodal_diameter: int
    mode: int
    natural_frequency: float

    def __str__(self) -> str:
        n, m = self.order
        return (
            f"harmonic ({n}, {m}) at {self.frequency:.5g} rad/s excites mode {self.mode} of nodal "
            f"diameter {self.nodal_diameter} at {self.natural_frequency:.5g} rad/s"
        )


def strongest_resonance(carriers: Sequence[Carrier], problem: ContactProblem) -> WaveResonance:
    """Return the resonance with the largest gain, besides the modes at their carriers."""
    waves, modes = [each.wave for each in carriers], len(carriers)
    contacts = problem.reduced.contacts
    assert contacts is not None  # contacts of waves are elastic
    found = []
    for order in problem.orders:
        if order in CARRIERS[:modes] or order == (0, 0):
            continue
        diameter = int(np.dot(order[:modes], [wave.nodal_diameter for wave in waves]))
        nu = float(np.dot(order[:modes], [each.frequency for each in carriers]))
        family = waves[0].modes_of(diameter)
        gain = family.harmonic_gain(contacts.reference, nu, abs(order[0]) + abs(order[1]))
        mode = int(gain.argmax())
        k = waves[0].centred(diameter if nu >= 0.0 else -diameter)
        natural = float(family.frequency[mode])
        found.append(WaveResonance(float(gain[mode]), order, abs(nu), k, mode, natural))
    return max(found, key=lambda each: each.gain)


def resonance_findings(carriers: Sequence[Carrier], problem: ContactProblem) -> list[Finding]:
    """Report a mode of another nodal diameter whose transients a model of the waves leaves out."""
    met = strongest_resonance(carriers, problem)
    if met.gain < _NAMED:
        return []
    reason = f"{met}. The model includes its steady response, but not its transients"
    return [Finding("contacts", "excite another mode", reason, "warning")]


@contextmanager
def naming_resonance(carriers: Sequence[Carrier], problem: ContactProblem) -> Iterator[None]:
    """Name the strongest resonance where the contacts do not come to a periodic motion."""
    try:
        yield
    except UnsettledError as error:
        met = strongest_resonance(carriers, problem)
        raise UnsettledError(
            "contacts: the contact motion does not become periodic. The largest response is where "
            f"{met}; move the forcing, give this mode damping, or lower the amplitudes"
        ) from error
