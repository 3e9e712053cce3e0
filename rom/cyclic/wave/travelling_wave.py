"""Travelling waves of a cyclic structure with friction: steady states, and models."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import Model, SlipmodeError
from slipmode.rom.common import Complexes, as_floats, frozen, in_one_line
from slipmode.rom.cyclic.diameter_modes import AllDiameters, DiameterModes
from slipmode.rom.cyclic.structure import CyclicStructure, checked_integer
from slipmode.rom.cyclic.wave.wave_problem import Carrier
from slipmode.rom.cyclic.wave.wave_state import WaveState, steady_waves, wave_cycles
from slipmode.rom.cyclic.wave.wave_table import wave_model
from slipmode.rom.laws import Elastic
from slipmode.rom.reduction import STATIC_FROM

_NO_WORK = 1e-9  # work of a force on the mode that is rounding, relative to its largest one


@frozen
class TravellingWave:
    """Hold a travelling wave of a cyclic structure, from the matrices of one sector.

    Attributes
    ----------
    structure : CyclicStructure
        Disk.
    law : elastic law
        Law of the contacts of one sector.
    modes_of : AllDiameters
        Modes of each nodal diameter with stuck contacts.
    nodal_diameter : int
        Nodal diameter k: sector j moves as exp(i k 2 pi j / N) times sector 0.
    mode : int
        Mode of this nodal diameter, from 0.
    """

    structure: CyclicStructure
    law: Elastic
    modes_of: AllDiameters
    nodal_diameter: int
    mode: int

    @property
    def own(self) -> DiameterModes:
        """Modes of the nodal diameter of this wave."""
        return self.modes_of(self.nodal_diameter)

    @property
    def frequency(self) -> float:
        """Natural frequency with stuck contacts [rad/s]."""
        alone = float(self.own.frequency[self.mode])
        # aerodynamic forces add stiffness
        added = self.own.dynamic_stiffness(alone)[self.mode, self.mode].real
        return float(np.sqrt(max(alone**2 + added, 0.0)))

    @property
    def shape(self) -> Complexes:
        """Mode shape phi of the free DOFs of sector 0, phi^H M phi = 1, (n_s,) [kg^-1/2]."""
        return np.asarray(self.own.shapes[:, self.mode])

    def modal_force(self, force: Mapping[int, complex] | ArrayLike) -> complex:
        """Return the modal force phi^H f of an engine-order excitation.

        Parameters
        ----------
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes f on the free DOFs of sector 0 [N]. The force on sector j is
            Re(f exp(i (Omega t + k 2 pi j / N))), an excitation of engine order k.

        Returns
        -------
        complex
            Modal force [N kg^-1/2].
        """
        return complex(self.shape.conj() @ self.structure.force_on_sector(force))

    def steady_states(
        self,
        frequency: float,
        force: Mapping[int, complex] | ArrayLike,
        tolerance: float = 1e-3,
    ) -> list[WaveState]:
        """Return the steady waves under an engine-order excitation, by ascending amplitude.

        Parameters
        ----------
        frequency : float
            Forcing frequency Omega [rad/s], k times the rotor speed.
        force : {DOF: amplitude} or (n_s,) array_like
            Complex amplitudes f on the free DOFs of sector 0 [N]. The force on sector j is
            Re(f exp(i (Omega t + k 2 pi j / N))), an excitation of engine order k.
        tolerance : float, default 0.001
            Relative error of the amplitude [-].

        Returns
        -------
        list of WaveState
            Usually one state. From rest, the wave reaches the state with the smallest amplitude.

        Raises
        ------
        SlipmodeError
            If the force does no work on the mode.
        UnsettledError
            If no periodic contact motion is found.

        Notes
        -----
        With lift-off or aerodynamic forces, a wave may be unstable against waves of other nodal
        diameters, see `WaveState.stable`. A self-excited wave follows its force where its state is
        stable.
        """
        return steady_waves(
            self.carrier(self.structure.force_on_sector(force), frequency), tolerance
        )

    def limit_cycles(self, tolerance: float = 1e-3) -> list[WaveState]:
        """Return the limit cycles of a self-excited wave without force, by ascending amplitude.

        Parameters
        ----------
        tolerance : float, default 0.001
            Relative error of the amplitude [-].

        Returns
        -------
        list of WaveState
            States with their own frequencies and real amplitudes, because the phase is arbitrary.
            Empty if friction dissipates too little at every amplitude.

        Raises
        ------
        SlipmodeError
            If the wave is not self-excited, see `CyclicStructure.with_aerodynamics`.
        UnsettledError
            If no periodic contact motion is found.

        Notes
        -----
        The damping of sliding friction decreases with the amplitude. Above a stable limit cycle
        there is therefore an unstable one, beyond which the wave grows without bound.
        """
        return wave_cycles(self.carrier(None, None), tolerance)

    def tabulate(
        self,
        amplitude: float,
        force: Mapping[int, complex] | ArrayLike | None,
        tolerance: float = 1e-3,
        frequency: float | None = None,
    ) -> Model:
        """Return a model of the wave, for steady states, curves, components, FMUs and scenes.

        Parameters
        ----------
        amplitude : float
            Largest amplitude |a| [kg^1/2 m].
        force : {DOF: amplitude} or (n_s,) array_like
            Force pattern, in any scale, see `modal_force`. The table includes its quasi-static
            response at the contacts. None: a wave without force, as in a limit cycle.
        tolerance : float, default 0.001
            Relative error of the amplitude equation [-], as in `rom.tabulate`.
        frequency : float, optional
            Reference frequency of the table [rad/s], near the forcing frequency or the frequency
            of the limit cycle. Default: the natural frequency with stuck contacts.

        Returns
        -------
        Model
            Model of one mode, without contacts, see Notes.

        Raises
        ------
        SlipmodeError
            If the tolerance cannot be reached, or the force does no work on the mode.

        Notes
        -----
        DOF i of the model is free DOF i of each sector. A force f on it has the modal force
        |phi_i| f. Its displacement is 2 |phi_i| |a| plus the response of the other modes to the
        contacts and to `force`, as in a steady state at the frequency of the wave. Higher
        harmonics are neglected. Phases are relative to the phases of phi. If dampers or
        aerodynamic forces couple modes of the nodal diameter, phi is the shape on which forces do
        work. The stability of steady states includes this wave only, see `WaveState.stable`.
        """
        return wave_model([self.carrier(force, frequency)], [amplitude], tolerance)

    def carrier(
        self, force: Mapping[int, complex] | ArrayLike | None, frequency: float | None
    ) -> Carrier:
        """Return the wave at a reference frequency, under a force or without force.

        Parameters
        ----------
        force : {DOF: amplitude} or (n_s,) array_like, or None
            Force pattern, which must do work on the mode.
        frequency : float or None
            Reference frequency [rad/s]. None: the natural frequency.

        Returns
        -------
        Carrier
            Wave with its contact problem at this frequency.

        Raises
        ------
        SlipmodeError
            If the force does no work on the mode, or the frequency is not allowed.
        """
        omega = self.frequency if frequency is None else float(as_floats("frequency", frequency))
        if not (omega > 0.0 and np.isfinite(omega)):
            raise SlipmodeError(f"frequency: must be > 0 rad/s, got {in_one_line(frequency)}")
        if force is None:
            return Carrier(self, omega, np.zeros(self.shape.size, dtype=complex))
        vector = self.structure.force_on_sector(force)
        size = np.abs(vector).max() * np.abs(self.shape).max()
        if not abs(self.modal_force(vector)) > _NO_WORK * size:
            raise SlipmodeError(
                f"force: does no work on mode {self.mode} of nodal diameter {self.nodal_diameter}"
            )
        return Carrier(self, omega, vector)


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
        Disk, with or without aerodynamic forces.
    law : Jenkins, Iwan, Sliders, FrictionalContact or Contacts
        Elastic law of the contacts of one sector.
    nodal_diameter : int
        Nodal diameter k, -(N // 2) to N // 2. Sector j moves as exp(i k 2 pi j / N) times sector
        0; k > 0 is a forward wave.
    mode : int, default 0
        Mode of this nodal diameter with stuck contacts, from 0.

    Returns
    -------
    TravellingWave
        Wave for steady states, limit cycles and models.

    Raises
    ------
    SlipmodeError
        If there is no such nodal diameter or mode, or the law is rigid. If the mode has no
        positive stiffness with the aerodynamic forces.
    """
    if not isinstance(law, Elastic):
        raise SlipmodeError(
            "law: cyclic structures need elastic contacts (rom.Jenkins, Iwan, Sliders, "
            f"FrictionalContact or Contacts), got {in_one_line(law)}"
        )
    most, last = structure.highest_diameter, structure.free_dofs.size - 1
    allowed = f"from {-most} to {most} of {structure.sectors} sectors"
    k = checked_integer("nodal_diameter", nodal_diameter, allowed, -most, most)
    mode = checked_integer("mode", mode, f"from 0 to {last}", 0, last)
    reference = law.elements(structure.n_contacts).reference
    own = DiameterModes.of(
        structure, k, reference, mode + 1, lambda squares: STATIC_FROM**2 * float(squares[mode])
    )
    highest = STATIC_FROM * float(own.frequency[mode])
    modes_of = AllDiameters(structure, reference, highest, {k % structure.sectors: own})
    wave = TravellingWave(structure, law, modes_of, k, mode)
    if wave.frequency <= 0.0:
        raise SlipmodeError(
            f"influence: the stiffness of mode {mode} of nodal diameter {k} must remain > 0"
        )
    return wave
