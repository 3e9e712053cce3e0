"""Travelling waves of a cyclic structure with friction: steady states, and models."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, as_floats, in_one_line
from slipmode.rom.cyclic.diameter_modes import AllDiameters, DiameterModes
from slipmode.rom.cyclic.structure import CyclicStructure
from slipmode.rom.cyclic.wave.wave_balance import Balance, Balanced, on_steps_that_suffice
from slipmode.rom.cyclic.wave.wave_cycles import wave_cycles
from slipmode.rom.cyclic.wave.wave_problem import Carrier, Wave
from slipmode.rom.cyclic.wave.wave_state import WaveState
from slipmode.rom.cyclic.wave.wave_table import wave_model
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.reduction.nonresonant import STATIC_FROM
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.model import Model
from slipmode.rom.table.tabulation import check_request


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
        A wave may be unstable against waves of other nodal diameters, with contacts that lift off
        or aerodynamic forces: see `WaveState.stable`. A self-excited wave follows its force where
        its state is stable.
        """
        carrier = self.carrier(self.structure.force_on_sector(force), frequency)

        def balanced(steps: int) -> list[Balanced]:
            balance = Balance.of(carrier, self.law, steps)
            sizes = balance.steady_sizes()
            return [Balanced(balance, balance.steady_amplitude(size)) for size in sizes]

        return [WaveState.of(each) for each in on_steps_that_suffice(balanced, tolerance)]

    def limit_cycles(self, tolerance: float = 1e-3) -> list[WaveState]:
        """Return the limit cycles of a self-excited wave, without a force, by amplitude.

        Friction that slips freely no longer grows with the amplitude: past a stable limit cycle
        there is an unstable one, beyond which the wave grows without bound.

        Parameters
        ----------
        tolerance : float
            Relative error of the amplitude.

        Returns
        -------
        list of WaveState
            Each with its own frequency. Amplitudes are real, for the phase is arbitrary. Empty if
            friction dissipates too little at any amplitude.

        Raises
        ------
        SlipmodeError
            If the wave is not self-excited; see `CyclicStructure.with_aerodynamics`.
        UnsettledError
            If the contacts do not come to a periodic motion.
        """

        def balanced(steps: int) -> list[Balanced]:
            return wave_cycles(self.wave, self.law, steps)

        return [WaveState.of(each) for each in on_steps_that_suffice(balanced, tolerance)]

    def tabulate(
        self,
        amplitude: float,
        force: Mapping[int, complex] | ArrayLike | None,
        tolerance: float = 1e-3,
        frequency: float | None = None,
    ) -> Model:
        """Return the model of the wave, for steady states, curves, components, FMUs and scenes.

        Parameters
        ----------
        amplitude : float
            Largest |a| [kg^1/2 m].
        force : {DOF: amplitude} or (n_s,) array_like
            Pattern of the excitation, as in `modal_force`, in any scale. The table includes its
            quasi-static effect on the contacts. None: the wave moves without a force, as in a
            limit cycle.
        tolerance : float
            Relative error of the amplitude equation, as in `rom.tabulate`.
        frequency : float, optional
            Frequency of the force, or of the limit cycle, about which the table is exact [rad/s].
            Default: the natural frequency with stuck contacts.

        Returns
        -------
        Model
            Of one mode, without contacts. DOF i is free DOF i of each sector, and a force at it
            has the modal force |phi_i| f. Its displacement is 2 |phi_i| |a| and, at the frequency
            of the wave, the response of the other modes to the contacts and to `force`, as in a
            steady state; higher harmonics are left out. Phases are relative to those of phi. Where
            dampers or aerodynamic forces couple modes of the nodal diameter, phi is the shape on
            which forces do work. Stability of its steady states is that of this wave alone: see
            `WaveState.stable`.

        Raises
        ------
        SlipmodeError
            If the tolerance cannot be reached; if the force does no work on the mode.
        """
        ends = np.array([as_floats("amplitude", amplitude)], dtype=float)
        check_request(ends, 1, tolerance, [amplitude])
        carrier = self.carrier(force, frequency)
        return wave_model([carrier], self.law, ends, tolerance)

    def carrier(
        self, force: Mapping[int, complex] | ArrayLike | None, frequency: float | None
    ) -> Carrier:
        """Return the wave under a force, which must do work on the mode, or None.

        The frequency is the natural one by default.
        """
        omega = self.frequency if frequency is None else float(as_floats("frequency", frequency))
        if not (omega > 0.0 and np.isfinite(omega)):
            raise SlipmodeError(f"frequency: must be > 0 rad/s, got {in_one_line(frequency)}")
        return Carrier(self.wave, omega, self._driving(force))

    def _driving(self, force: Mapping[int, complex] | ArrayLike | None) -> Complexes:
        """Return forces on the free DOFs of sector 0, (n_s,); 0 without any."""
        if force is None:
            return np.zeros(self.shape.size, dtype=complex)
        vector = self.structure.force_on_sector(force)
        size = np.abs(vector).max() * np.abs(self.shape).max()
        if not abs(self.modal_force(vector)) > 1e-9 * size:
            raise SlipmodeError(
                f"force: does no work on mode {self.wave.mode} of nodal diameter "
                f"{self.nodal_diameter}"
            )
        return vector


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
        If there is no such nodal diameter or mode; if the contacts are rigid; if aerodynamics take
        away all stiffness of the mode.
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
    wave = Wave(modes_of, int(nodal_diameter), int(mode), structure.sectors)
    wave.check_stiffness()
    return TravellingWave(structure, law, wave)
