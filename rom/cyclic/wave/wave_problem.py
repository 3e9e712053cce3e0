"""The contact problem of one or two travelling waves, which is that of one sector.

In a wave of nodal diameter k sector j does what sector 0 does, later by the phase k 2 pi j / N.
Harmonic (n, m) of the contact forces therefore acts on nodal diameter d = n k_A + m k_B modulo N,
and the contacts of sector 0 respond to it with the flexibility of that nodal diameter. The dual
problem of elastic contacts has the force deficit y = k_ref x_c - f, with the contact forces f, see
`slipmode.rom.reduction.stuck`:

    x_c = sum_j psi_j a_j e^(i theta_j) + c.c. + sum_nm G_nm y_nm e^(i (n theta_A + m theta_B)),
    psi_j = W_k phi_j,    G_nm = flexibility of nodal diameter d at n Omega_A + m Omega_B,

at the carriers without the mode, which is driven by psi_j^H y_j. Coupling and projection are
conjugates, not equal, as the phases of the contacts differ. Dampers between the modes change both
a little, see `SlowMode`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.problem import ContactProblem
from slipmode.rom.cyclic.diameter_modes import DiameterModes, SlowMode
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.combination import CARRIERS, harmonic_orders
from slipmode.rom.reduction.nonresonant import HIGHEST_HARMONIC
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.local.dual_contacts import DualContacts


@frozen
class Wave:
    """A mode of a nodal diameter that has a slow flow.

    Attributes
    ----------
    modes_of : callable
        `DiameterModes` of a nodal diameter.
    nodal_diameter : int
        k.
    mode : int
        From 0.
    sectors : int
        N.
    """

    modes_of: Callable[[int], DiameterModes]
    nodal_diameter: int
    mode: int
    sectors: int

    def centred(self, nodal_diameter: int) -> int:
        """Return the equal nodal diameter from -((N - 1) // 2) to N // 2."""
        lowest = (self.sectors - 1) // 2
        return (nodal_diameter + lowest) % self.sectors - lowest

    @property
    def own(self) -> DiameterModes:
        """Modes of the wave's nodal diameter."""
        return self.modes_of(self.nodal_diameter)

    @property
    def shape(self) -> Complexes:
        """Mode phi of sector 0 at its free DOFs, (n_s,) [kg^-1/2]."""
        return np.asarray(self.own.shapes[:, self.mode])

    @property
    def contact_motion(self) -> Complexes:
        """Psi, contact displacements per amplitude of the mode, (N_c,) [kg^-1/2]."""
        return np.asarray(self.own.contact_motion[:, self.mode])

    @property
    def structural_frequency(self) -> float:
        """Natural frequency with stuck contacts, without aerodynamics [rad/s]."""
        return float(self.own.frequency[self.mode])

    @property
    def frequency(self) -> float:
        """Natural frequency with stuck contacts [rad/s]."""
        return float(np.sqrt(self._square))

    @property
    def _square(self) -> float:
        alone = self.structural_frequency
        dynamic = self.own.dynamic_stiffness(alone)[self.mode, self.mode]
        return alone**2 + float(dynamic.real)

    def check_stiffness(self) -> None:
        """Refuse a mode whose stiffness aerodynamic forces take away."""
        if self._square <= 0.0:
            raise SlipmodeError(
                f"influence: the stiffness of mode {self.mode} of nodal diameter "
                f"{self.nodal_diameter} must remain > 0"
            )

    @property
    def structural_damping(self) -> float:
        """Modal damping without aerodynamics [1/s]."""
        return float(self.own.damping[self.mode, self.mode].real)

    def static(self) -> Floats:
        """Real static flexibility of the contacts without the mode, (N_c, N_c) [m/N]."""
        own = self.own
        psi, omega = (
            np.delete(each, self.mode, axis=-1) for each in (own.contact_motion, own.frequency)
        )
        static = own.past_flexibility + (psi / omega**2) @ psi.conj().T
        return np.asarray(0.5 * (static.real + static.real.T))


@frozen
class Carrier:
    """A wave at the frequency of its carrier, and the force that holds it steady, if any.

    Attributes
    ----------
    wave : Wave
    frequency : float
        Omega [rad/s].
    force : (n_s,) complex ndarray
        Pattern on sector 0, in any scale; 0 of a limit cycle.
    """

    wave: Wave
    frequency: float
    force: Complexes

    @cached_property
    def mode(self) -> SlowMode:
        """The mode, and what others do with it by dampers."""
        return self.wave.own.slow_mode(self.wave.mode, self.frequency)

    @property
    def stiffness(self) -> complex:
        """Dynamic stiffness D of the mode with what returns by dampers [rad^2/s^2]."""
        return self.mode.stiffness + self.mode.indirect

    @property
    def natural_frequency(self) -> float:
        """Natural frequency omega of the mode, D = omega^2 - Omega^2 + i gamma Omega [rad/s]."""
        return float(np.sqrt(self.mode.stiffness.real + self.frequency**2))

    @property
    def damping(self) -> float:
        """Modal damping gamma [1/s]; negative if the wave is self-excited."""
        return self.mode.stiffness.imag / self.frequency

    @property
    def aerodynamics(self) -> complex:
        """Coefficient c of the aerodynamic forces on the mode [rad^2/s^2], see `rom.reduce`."""
        alone = self.wave.structural_frequency
        damping = self.damping - self.wave.structural_damping
        return complex(self.natural_frequency**2 - alone**2, alone * damping)

    @property
    def mode_shape(self) -> Complexes:
        """Phi of a model, (n_s,) [kg^-1/2]: of the forces on the mode or, without any, of motion.

        The two differ by the response of the other modes through dampers and aerodynamic forces.
        """
        return self.mode.receiving if self.force.any() else self.mode.shape

    @property
    def modal_force(self) -> complex:
        """Force on the mode by the pattern."""
        return complex(self.mode.receiving.conj() @ self.force)

    @property
    def receiving(self) -> Complexes:
        """Displacements of the contacts whose work drives the mode, (N_c,) [kg^-1/2]."""
        return np.asarray(self.wave.own.contacts @ self.mode.receiving)

    @cached_property
    def moved_by_force(self) -> Complexes:
        """g, twice the quasi-static displacement of the contacts per modal force, (N_c,)."""
        own = self.wave.own
        if not self.force.any():
            return np.zeros(own.contacts.shape[0], dtype=complex)
        moved = own.response(self.force[:, np.newaxis], self.frequency, self.wave.mode)[:, 0]
        return np.asarray(own.contacts @ moved / self.modal_force)

    @property
    def coupling(self) -> Complexes:
        """Displacements of the contacts per a_j in a steady state, (N_c,) [kg^-1/2].

        As F / 2 = D a - psi^H y, the displacement g F / 2 adds g D a to psi a, and -g psi^H y.
        """
        own = self.wave.own.contacts @ self.mode.shape
        return np.asarray(own + self.stiffness * self.moved_by_force)


def wave_contact_problem(carriers: Sequence[Carrier], law: Elastic) -> ContactProblem:
    """Return the contact problem of one or two waves in a steady state or limit cycle."""
    waves, modes = [each.wave for each in carriers], len(carriers)
    frequency = np.array([each.frequency for each in carriers])
    diameters = [wave.nodal_diameter for wave in waves]
    even = not law.elements(waves[0].contact_motion.size).odd
    flexibility = {}
    for order in harmonic_orders(HIGHEST_HARMONIC[modes], modes, even):
        own = CARRIERS.index(order) if order in CARRIERS[:modes] else None
        of_diameter = waves[0].modes_of(int(np.dot(order[:modes], diameters)))
        nu = float(np.dot(order[:modes], frequency))
        G = of_diameter.flexibility(nu, None if own is None else waves[own].mode)
        if own is not None:
            carrier = carriers[own]
            G = G - np.outer(carrier.moved_by_force, carrier.receiving.conj())
        flexibility[order] = G
    contacts = DualContacts(
        law,
        np.mean([wave.static() for wave in waves], axis=0),
        np.array([wave.frequency for wave in waves]),
        np.array([wave.structural_damping for wave in waves]),
        np.abs([wave.contact_motion for wave in waves]),
    )
    coupling, receiving = (
        np.array([getattr(each, name) for each in carriers]) for name in ("coupling", "receiving")
    )
    return contacts.problem(frequency, coupling, flexibility, receiving)
