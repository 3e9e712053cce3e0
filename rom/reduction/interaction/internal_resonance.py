"""How far a mode moves the contacts at a harmonic of their forces: internal resonances.

A mode with the contact displacement psi has the modal stiffness kappa = k psi^2 due to a contact
of stiffness k. Harmonics of the order h of its force are at most about k |x| / h^2 at contact
displacements x. The mode, of dynamic stiffness D(nu), responds with displacements of

    kappa / (h^2 |D(nu)|)

relative to x: its gain. Of several contacts, the largest counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.combination import CombinationResonance, Order, resonant_modes
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import frozen

_TINY = np.finfo(float).tiny


def harmonic_decay(orders: ArrayLike) -> Floats:
    """Return (|n| + |m|)^2 of harmonics (..., 2); 1 for the mean."""
    return np.asarray(np.maximum(np.abs(orders).sum(axis=-1), 1.0) ** 2)


def harmonic_gain(stiffness: Floats, dynamic: Complexes | Floats, decay: Floats | float) -> Floats:
    """Return gains kappa / (decay |D|) of modes at harmonics, broadcast.

    Harmonics of the force deficit of a contact that sticks and slides are at most
    0.7 to 0.95 k_ref |x| / h^2 (tests/rom/cyclic/test_internal_resonance.py).

    Parameters
    ----------
    stiffness : ndarray
        Modal stiffness kappa due to contacts [rad^2/s^2].
    dynamic : ndarray
        Dynamic stiffness D [rad^2/s^2].
    decay : float or ndarray
        h^2, see `harmonic_decay`.
    """
    return np.asarray(stiffness / (decay * np.maximum(np.abs(dynamic), _TINY)))


def own_stiffness(reduced: Reduced) -> Floats:
    """Return force per displacement (N_c,) of rigid contacts, displacement per force of others."""
    if reduced.contacts is None:
        return np.array(np.diag(reduced.stiffness))
    return np.asarray(1.0 / np.maximum(reduced.contacts.reference, _TINY))


def mode_gains(reduced: Reduced, nu: Floats, decay: Floats) -> tuple[Floats, Complexes]:
    """Return gains and dynamic stiffness of all modes at frequencies nu (..., orders) [rad/s].

    Both are (..., orders, modes + nonresonant); `decay` is (orders,).
    """
    D = np.einsum("...kk->...k", reduced.modal_stiffness(nu))
    B = reduced.modal_coupling(nu)
    stiffness = (np.abs(B) ** 2 / own_stiffness(reduced)).max(axis=-1)
    return harmonic_gain(stiffness, D, decay[:, np.newaxis]), D


@frozen
class InternalResonance:
    """A mode that responds to a harmonic of the contact forces.

    Attributes
    ----------
    gain : float
        Contact displacement by the mode, relative to the carrier's [-].
    order : (int, int)
        Harmonic (n, m).
    harmonic, frequency : float
        Frequencies of the harmonic, n Omega_A + m Omega_B, and of the mode [rad/s].
    mode : str
        The mode, in words.
    stuck : bool
        Whether the contacts stick in the mode.
    """

    gain: float
    order: Order
    harmonic: float
    frequency: float
    mode: str
    stuck: bool = True

    def __str__(self) -> str:
        return (
            f"harmonic {self.order} at {self.harmonic:.5g} rad/s excites {self.mode} at "
            f"{self.frequency:.5g} rad/s"
        )


def strongest_resonance(
    reduced: Reduced, orders: Sequence[Order], combinations: Sequence[CombinationResonance] = ()
) -> InternalResonance:
    """Return the harmonic and the mode with the largest gain, besides the modes at carriers."""
    modes = len(reduced.modes)
    nu = np.abs(np.array(orders)[:, :modes] @ reduced.carrier)
    gain, _ = mode_gains(reduced, nu, harmonic_decay(orders))
    gain[nu == 0.0] = 0.0
    gain[:, :modes][resonant_modes(modes, orders, combinations)] = 0.0
    k, mode = (int(at) for at in np.unravel_index(gain.argmax(), gain.shape))
    omega = float(np.append(reduced.frequency, reduced.nonresonant_frequency)[mode])
    name = f"mode at {omega:.4g} rad/s"
    return InternalResonance(float(gain[k, mode]), orders[k], float(nu[k]), omega, name)
