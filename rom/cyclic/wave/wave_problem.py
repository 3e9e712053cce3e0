"""The contact problem of one or two travelling waves: the contacts of one sector.

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

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from slipmode.rom import ContactProblem
from slipmode.rom.common import Complexes, Finding, Floats, UnsettledError, frozen
from slipmode.rom.contact import ContactForces
from slipmode.rom.cyclic.diameter_modes import DiameterModes, SlowMode
from slipmode.rom.cyclic.structure import excited_diameter
from slipmode.rom.reduction import (
    CARRIERS,
    HIGHEST_HARMONIC,
    InternalResonance,
    Order,
    harmonic_orders,
    modes_alone,
)

if TYPE_CHECKING:
    from slipmode.rom.cyclic.wave.travelling_wave import TravellingWave


# Gain from which on a resonance is named. Waves converge at 0.35 and do not at 1
# (tests/rom/cyclic/test_internal_resonance.py).
_NAMED = 0.1


@frozen
class Carrier:
    """A wave at the frequency of its carrier, and the force that holds it steady, if any.

    Attributes
    ----------
    wave : TravellingWave
    frequency : float
        Omega [rad/s].
    force : (n_s,) complex ndarray
        Pattern on sector 0, in any scale; 0 of a limit cycle.
    """

    wave: TravellingWave
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
    def by_force(self) -> Complexes:
        """g, twice the displacement of sector 0 besides the mode per modal force, (n_s,)."""
        if not self.force.any():
            return np.zeros(self.force.size, dtype=complex)
        wave, force = self.wave, self.force[:, np.newaxis]
        moved = wave.own.response(force, self.frequency, wave.mode)[:, 0]
        return np.asarray(moved / self.modal_force)

    @property
    def steady_shape(self) -> Complexes:
        """Displacement of sector 0 per a_j in a steady state, (n_s,) [kg^-1/2].

        As F / 2 = D a - psi^H y, the displacement g F / 2 adds g D a to phi a, and -g psi^H y.
        """
        return np.asarray(self.mode.shape + self.stiffness * self.by_force)


@frozen
class WaveHarmonic:
    """A harmonic of the contact forces, and the nodal diameter that it acts on.

    Attributes
    ----------
    order : (n, m)
    nodal_diameter : int
        n k_A + m k_B.
    frequency : float
        n Omega_A + m Omega_B [rad/s].
    modes : DiameterModes
        Of this nodal diameter.
    carrier : Carrier, optional
        The wave whose carrier this harmonic is.
    """

    order: Order
    nodal_diameter: int
    frequency: float
    modes: DiameterModes
    carrier: Carrier | None

    @classmethod
    def of(cls, carriers: Sequence[Carrier], order: Order) -> Self:
        """Return a harmonic of one or two waves."""
        own, n = CARRIERS[: len(carriers)], order[: len(carriers)]
        diameter = int(np.dot(n, [each.wave.nodal_diameter for each in carriers]))
        nu = float(np.dot(n, [each.frequency for each in carriers]))
        carrier = carriers[own.index(order)] if order in own else None
        return cls(order, diameter, nu, carriers[0].wave.modes_of(diameter), carrier)

    def flexibility(self, dofs: Sequence[int] | None = None) -> Complexes:
        """Return displacements of contacts, or of free DOFs, per force deficit, (.., N_c) [m/N].

        At a carrier they are besides the mode, and include the effect of the force that balances
        the deficit on the mode.
        """
        modes, carrier = self.modes, self.carrier
        without = None if carrier is None else carrier.wave.mode
        if dofs is None:
            moved = modes.flexibility(self.frequency, without)
        else:
            on_contacts = modes.contacts.conj().T.toarray()
            moved = modes.response(on_contacts, self.frequency, without)[dofs]
        if carrier is None:
            return moved
        g = carrier.by_force
        by_force = modes.contacts @ g if dofs is None else g[dofs]
        return np.asarray(moved - np.outer(by_force, carrier.receiving.conj()))


@frozen
class WaveProblem(ContactProblem):
    """The contact problem of one or two waves in a steady state or limit cycle.

    Attributes
    ----------
    carriers : tuple of Carrier
        Waves of one structure with one law.
    highest : int
        Largest |n| + |m| of the harmonics.
    """

    carriers: tuple[Carrier, ...] = ()
    highest: int = 0

    @classmethod
    def of_waves(cls, carriers: Sequence[Carrier], highest: int = 0) -> Self:
        """Return the contact problem of waves; by default with the harmonics of a table."""
        waves, modes = [each.wave for each in carriers], len(carriers)
        own = [(wave.own, wave.mode) for wave in waves]
        highest = highest or HIGHEST_HARMONIC[modes]
        law = waves[0].law
        elements = law.elements(waves[0].structure.n_contacts)
        orders = tuple(harmonic_orders(highest, modes, not elements.odd))
        # real flexibility of the march, to which every harmonic adds what its own differs by
        static = np.mean([k.flexibility(0.0, mode).real for k, mode in own], axis=0)
        static = 0.5 * (static + static.T)
        flexibility = [WaveHarmonic.of(carriers, order).flexibility() for order in orders]
        receiving = np.array([each.receiving for each in carriers])
        forces = ContactForces(
            coupling=-np.array([each.wave.own.contacts @ each.steady_shape for each in carriers]),
            reaction=np.array(flexibility) - static,
            projection=-receiving.conj(),
            indirect=np.array([each.mode.indirect for each in carriers]),
        )
        reduced = modes_alone(
            np.array([wave.frequency for wave in waves]),
            np.array([k.structural_damping[mode] for k, mode in own]),
            np.zeros((1, modes)),
            elements,
            carrier=np.array([each.frequency for each in carriers]),
            stiffness=-static,
            spring=-np.abs([k.contact_motion[:, mode] for k, mode in own]),
        )
        given = tuple(carriers)
        return cls(reduced, law, orders, given_forces=forces, carriers=given, highest=highest)

    @property
    def harmonics(self) -> list[WaveHarmonic]:
        """Harmonics of the contact forces, as `orders`."""
        return [WaveHarmonic.of(self.carriers, order) for order in self.orders]

    def at_carriers(self, frequency: Floats) -> Self:
        """Return the problem with other carriers (modes,) [rad/s]."""
        both = zip(self.carriers, frequency.tolist(), strict=True)
        return self.of_waves([replace(each, frequency=nu) for each, nu in both], self.highest)


def strongest_resonance(problem: WaveProblem) -> InternalResonance:
    """Return the largest gain besides the modes at their carriers.

    A mode of nodal diameter n k_A + m k_B responds to harmonic (n, m) at n Omega_A + m Omega_B.
    """
    wave = problem.carriers[0].wave
    reference = wave.law.elements(wave.structure.n_contacts).reference
    found = []
    for harmonic in problem.harmonics:
        if harmonic.carrier is None and any(harmonic.order):
            nu, diameter = harmonic.frequency, harmonic.nodal_diameter
            k = excited_diameter(diameter if nu >= 0.0 else -diameter, wave.structure.sectors)
            name = f"mode {{}} of nodal diameter {k}"
            met = harmonic.modes.internal_resonance(reference, nu, harmonic.order, name)
            found.append(met)
    return max(found, key=lambda each: each.gain)


def resonance_findings(problem: WaveProblem) -> list[Finding]:
    """Report a mode of another nodal diameter whose transients a model of the waves leaves out."""
    met = strongest_resonance(problem)
    if met.gain < _NAMED:
        return []
    reason = f"{met}. The model includes its steady response, but not its transients"
    return [Finding("contacts", "excite another mode", reason, "warning")]


@contextmanager
def naming_resonance(problem: WaveProblem) -> Iterator[None]:
    """Name the strongest resonance where the contacts do not come to a periodic motion."""
    try:
        yield
    except UnsettledError as error:
        raise UnsettledError(
            "contacts: the contact motion does not become periodic. The largest response is where "
            f"{strongest_resonance(problem)}; move the forcing, give this mode damping, or lower "
            "the amplitudes"
        ) from error
