"""Travelling waves of a cyclic structure with friction: steady states, and models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.contact.problem import ContactProblem, TorusProblem
from slipmode.rom.contact.torus.grid import Discretisation
from slipmode.rom.cyclic.diameter_modes import AllDiameters, DiameterModes
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.cyclic.wave.wave_problem import Carrier, Wave, wave_contact_problem
from slipmode.rom.cyclic.wave.wave_table import wave_model
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.nonresonant import STATIC_FROM
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.model import Model
from slipmode.rom.table.tabulation import check_request

_STEPS = (128, 256, 512, 1024, 2048, 4096)  # per period, until the steady states stay
_AMPLITUDES = 60  # tried for steady states


@frozen
class WaveState:
    """A steady travelling wave: sector j moves by 2 Re(c exp(i (Omega t + k 2 pi j / N))).

    Attributes
    ----------
    amplitude : complex
        a of the mode [kg^1/2 m].
    error : float
        Estimate of the error of |a| by time steps [kg^1/2 m].
    displacement : (n_s,) complex ndarray
        c of the free DOFs of sector 0 at the forcing frequency [m].
    """

    amplitude: complex
    error: float
    displacement: Complexes


@frozen
class TravellingWave:
    """A travelling wave of a cyclic structure, from the matrices of one sector.

    Attributes
    ----------
    structure : CyclicStructure
    law : Elastic
    wave : Wave
    """

    structure: CyclicStructure
    law: Elastic
    wave: Wave

    @property
    def nodal_diameter(self) -> int:
        """K: sector j moves like exp(i k 2 pi j / N) times sector 0."""
        return self.wave.nodal_diameter

    @property
    def frequency(self) -> float:
        """Natural frequency with stuck contacts [rad/s]."""
        return self.wave.frequency

    @property
    def shape(self) -> Complexes:
        """Mode phi of sector 0 at its free DOFs, phi^H M phi = 1, (n_s,) [kg^-1/2]."""
        return self.wave.shape

    def modal_force(self, force: Mapping[int, complex] | ArrayLike) -> complex:
        """Return the force phi^H f on the mode [N kg^-1/2].

        Parameters
        ----------
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes on sector 0: sector j is loaded by
            Re(f exp(i (Omega t + k 2 pi j / N))), an excitation of engine order k [N].
        """
        return complex(self.shape.conj() @ self.structure.force_on_sector(force))

    def steady_states(
        self,
        frequency: float,
        force: Mapping[int, complex] | ArrayLike,
        tolerance: float = 1e-3,
    ) -> list[WaveState]:
        """Return the steady waves under an engine-order excitation, by amplitude.

        Parameters
        ----------
        frequency : float
            Omega [rad/s]: k times the rotor speed.
        force : {DOF: amplitude} or (n_s,) array_like
            As in `modal_force`.
        tolerance : float
            Relative error of the amplitude.

        Returns
        -------
        list of WaveState
            Usually one. Where several are returned, the wave comes to that of the smallest
            amplitude from rest.

        Raises
        ------
        SlipmodeError
            If the force does no work on the mode.
        UnsettledError
            If the contacts do not come to a periodic motion.

        Notes
        -----
        A wave may be unstable against waves of other nodal diameters, mostly with contacts that
        lift off; this is not tested.
        """
        carrier = Carrier(self.wave, frequency, self.driving(force))
        problem = wave_contact_problem([carrier], self.law)
        coarse = _Balance(carrier, problem, _STEPS[0]).amplitudes()
        for steps in _STEPS[1:]:
            balance = _Balance(carrier, problem, steps)
            found = balance.amplitudes()
            if len(found) == len(coarse):
                change = np.abs(found - coarse)
                if np.all(change <= tolerance * found):
                    return [balance.state(*each) for each in zip(found, change, strict=True)]
            coarse = found
        raise SlipmodeError(
            f"tolerance: the steady wave changes by more than {tolerance:g} with {_STEPS[-1]} "
            "steps a period; allow more"
        )

    def tabulate(
        self,
        amplitude: float,
        force: Mapping[int, complex] | ArrayLike,
        tolerance: float = 1e-3,
    ) -> Model:
        """Return the model of the wave, for steady states, curves, components, FMUs and scenes.

        Parameters
        ----------
        amplitude : float
            Largest |a| [kg^1/2 m].
        force : {DOF: amplitude} or (n_s,) array_like
            Pattern of the excitation, as in `modal_force`, in any scale. The table includes its
            quasi-static effect on the contacts.
        tolerance : float
            Relative error of the amplitude equation, as in `rom.tabulate`.

        Returns
        -------
        Model
            Of one mode, without contacts. DOF i is free DOF i of each sector; its displacement
            amplitude is 2 |phi_i| |a|, and a force at one DOF has the modal force |phi_i| f. Its
            phases are relative to those of phi.

        Raises
        ------
        SlipmodeError
            If the tolerance cannot be reached; if the force does no work on the mode.
        """
        ends = np.array([as_floats("amplitude", amplitude)], dtype=float)
        check_request(ends, 1, tolerance, [amplitude])
        carrier = Carrier(self.wave, self.frequency, self.driving(force))
        return wave_model([carrier], self.law, ends, tolerance)

    def driving(self, force: Mapping[int, complex] | ArrayLike) -> Complexes:
        """Return forces on the free DOFs of sector 0, (n_s,), which must do work on the mode."""
        vector = self.structure.force_on_sector(force)
        size = np.abs(vector).max() * np.abs(self.shape).max()
        if not abs(self.modal_force(vector)) > 1e-9 * size:
            raise SlipmodeError(
                f"force: does no work on mode {self.wave.mode} of nodal diameter "
                f"{self.nodal_diameter}"
            )
        return vector


@frozen
class _Balance:
    """Amplitudes |a| at which the force that holds the wave steady is the given one."""

    carrier: Carrier
    problem: ContactProblem
    steps: int

    @cached_property
    def _torus(self) -> TorusProblem:
        return self.problem.on(Discretisation(self.steps, 1), 1e-8)

    def required(self, sizes: Floats) -> tuple[Complexes, Complexes]:
        """Return F per phase of a, 2 (D a - psi_r^H y_1), and y_1, at |a| (points,)."""
        terms = self._torus.solve(sizes[:, np.newaxis])
        terms.check_periodic()
        return 2.0 * (self.carrier.stiffness * sizes - terms.S[:, 0]), terms.P[:, 0]

    def amplitudes(self) -> Floats:
        """Return all |a| that are found, ascending [kg^1/2 m]."""
        import scipy.optimize  # takes long to import

        force = abs(self.carrier.modal_force)

        def lack(size: float) -> float:
            return float(np.abs(self.required(np.array([size]))[0][0])) - force

        stuck = 0.5 * force / abs(self.carrier.stiffness)
        sizes = np.geomspace(1e-3 * stuck, 2.0 * stuck, _AMPLITUDES)
        while np.abs(self.required(sizes[-1:])[0][0]) <= force:
            sizes = np.geomspace(sizes[0], 4.0 * sizes[-1], _AMPLITUDES)
        lacks = np.abs(self.required(sizes)[0]) - force
        (first,) = np.nonzero((lacks[:-1] < 0.0) != (lacks[1:] < 0.0))
        return np.array(
            [
                scipy.optimize.brentq(lack, sizes[k], sizes[k + 1], rtol=1e-10)
                for k in first.tolist()
            ]
        )

    def state(self, size: float, error: float) -> WaveState:
        """Return the steady wave of an amplitude."""
        required, y = (each[0] for each in self.required(np.array([size])))
        carrier, own = self.carrier, self.carrier.wave.own
        # required exp(i arg a) is the force
        turn = carrier.modal_force / required
        turn /= abs(turn)
        a = size * turn
        on_dofs = own.contacts.conj().T @ (y * turn) + 0.5 * carrier.force
        others = own.response(on_dofs[:, np.newaxis], carrier.frequency, carrier.wave.mode)
        return WaveState(complex(a), float(error), carrier.mode.shape * a + others[:, 0])


def travelling_wave(
    structure: CyclicStructure,
    law: Elastic,
    nodal_diameter: int,
    mode: int = 0,
) -> TravellingWave:
    """Return a travelling wave: one mode of a nodal diameter, with the contacts of one sector.

    Parameters
    ----------
    structure : CyclicStructure
    law : Jenkins, Iwan, Sliders, FrictionalContact or Contacts
        Of the contacts of a sector.
    nodal_diameter : int
        k from -(N // 2) to N // 2; the wave travels forward for k > 0: sector j moves like
        exp(i k 2 pi j / N) times sector 0.
    mode : int
        Mode of that nodal diameter with stuck contacts, from 0.

    Raises
    ------
    SlipmodeError
        If there is no such nodal diameter or mode; if the contacts are rigid.
    """
    if not isinstance(law, Elastic):
        raise SlipmodeError(
            "law: cyclic structures need elastic contacts (rom.Jenkins, Iwan, Sliders, "
            f"FrictionalContact or Contacts), got {in_one_line(law)}"
        )
    most = structure.highest_diameter
    if (
        isinstance(nodal_diameter, bool)
        or not isinstance(nodal_diameter, int | np.integer)
        or (abs(nodal_diameter) > most)
    ):
        raise SlipmodeError(
            f"nodal_diameter: must be an integer from {-most} to {most} of {structure.sectors} "
            f"sectors, got {in_one_line(nodal_diameter)}"
        )
    reference = law.elements(structure.n_contacts).reference
    if isinstance(mode, bool) or not isinstance(mode, int | np.integer) or mode < 0:
        raise SlipmodeError(f"mode: must be an integer >= 0, got {in_one_line(mode)}")
    own = DiameterModes.of(
        structure,
        int(nodal_diameter),
        reference,
        int(mode) + 1,
        lambda squares: STATIC_FROM**2 * float(squares[min(mode, squares.size - 1)]),
    )
    if mode >= own.frequency.size:
        raise SlipmodeError(f"mode: must be 0 to {own.frequency.size - 1}, got {mode}")
    highest = STATIC_FROM * float(own.frequency[mode])
    modes_of = AllDiameters(
        structure, reference, highest, {int(nodal_diameter) % structure.sectors: own}
    )
    return TravellingWave(structure, law, Wave(modes_of, int(nodal_diameter), int(mode)))


def tabulate_waves(
    waves: Sequence[TravellingWave],
    amplitude: Sequence[float],
    force: Sequence[Mapping[int, complex] | ArrayLike],
    tolerance: float = 1e-3,
) -> Model:
    """Return the model of two travelling waves of one structure, at two frequencies.

    Two engine orders drive them, each near the frequency of its wave.

    Parameters
    ----------
    waves : sequence of TravellingWave
        Two, of the same structure and law. Their frequencies differ.
    amplitude : sequence of float
        Largest |a_j| [kg^1/2 m].
    force : sequence of {DOF: amplitude} or (n_s,) array_like
        Pattern of the excitation of each wave, see `TravellingWave.modal_force`.
    tolerance : float
        As in `rom.tabulate`.

    Returns
    -------
    Model
        As of `TravellingWave.tabulate`, with two modes.

    Raises
    ------
    SlipmodeError
        If the waves do not belong together; if the tolerance cannot be reached.
    """
    if len(waves) != 2 or len(force) != 2:
        raise SlipmodeError(f"waves, force: must be two each, got {len(waves)} and {len(force)}")
    first, second = waves
    if first.structure is not second.structure or first.law != second.law:
        raise SlipmodeError("waves: must be of the same structure and law")
    ends = as_floats("amplitude", amplitude)
    check_request(ends, 2, tolerance, amplitude)
    carriers = [
        Carrier(each.wave, each.frequency, each.driving(f))
        for each, f in zip(waves, force, strict=True)
    ]
    if first.frequency == second.frequency:
        raise SlipmodeError("waves: must have different frequencies")
    return wave_model(carriers, first.law, ends, tolerance)
