"""Slow flow of one tone: amplitudes of all modes near the frequency of one force."""

from __future__ import annotations

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.kernel.handle import Handle
from slipmode.rom.reduction.force_response import phasor
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.tone.core_tone import core_tone
from slipmode.rom.slow.tone.tone_modes import ToneModes
from slipmode.rom.table.local.local_contacts import LocalContacts

# Part of the reference frequency by which the frequency may differ from it: the contacts respond
# to the harmonics of the reference (tests/rom/cyclic/test_mistuned_transients.py).
SPAN = 0.1
NOT_CONVERGED = (
    "contacts: the slow flow does not converge, because contacts act too strongly on each other; "
    "integrate the structure in time (rom.full), of a disk CyclicStructure.annulus()"
)


class ToneFlow:
    """Step a structure under one force in time, from rest.

    `rom.tone_flow` and `MistunedDisk.flow` make it. With the force deficits y of the contacts, and
    the magnitude F and the phase of the force, the amplitudes a_m of the modes with stuck contacts
    obey::

        a_m' = (s_m - i Omega) a_m + b_m F exp(i phase) + l_m y.

    Parameters
    ----------
    modes : ToneModes
        Modes with stuck contacts.
    contacts : LocalContacts
        Force deficit of each contact against its displacement without the flexibility `own`.
    own : (N_c,) complex ndarray
        Flexibility of each contact to its own force deficit [m/N].
    frequency : float
        Reference frequency, and forcing frequency Omega at the start [rad/s].
    tolerance : float
        Error of a step relative to the amplitudes [-].

    Attributes
    ----------
    time, angle : float
        Present time [s], and phase theta of the carrier from 0 to 2 pi [rad].
    frequency, magnitude, phase : float
        Present forcing frequency Omega [rad/s], factor F of the force [-], and phase [rad].
    """

    def __init__(
        self,
        modes: ToneModes,
        contacts: LocalContacts,
        own: Complexes,
        frequency: float,
        tolerance: float,
    ) -> None:
        self._modes, self._reference = modes, frequency
        tone = core_tone(modes, contacts, own, frequency)
        self._handle = Handle("tone", tone, tolerance=tolerance)
        self._amplitude: Floats = np.zeros((2, modes.slow.pole.size))
        self._deficit: Floats = np.zeros((2, own.size))
        self._inputs = kernel.inputs(1)
        self.time = 0.0
        self._read()

    def step(
        self,
        duration: float,
        *,
        frequency: float | None = None,
        magnitude: float | None = None,
        phase: float | None = None,
    ) -> None:
        """Advance the time.

        Parameters
        ----------
        duration : float
            Length of the step [s]; 0 changes the inputs at once.
        frequency : float, optional
            Forcing frequency at the end of the step [rad/s], linear in between, at most 10 % from
            the reference frequency. Default: constant.
        magnitude : float, optional
            Factor of the force at the end of the step [-], linear in between. Default: constant.
        phase : float, optional
            Phase of the force at the end of the step [rad], linear in between. Default: constant.

        Raises
        ------
        SlipmodeError
            If an input is not allowed, or the step cannot meet its tolerance. The state is
            unchanged.
        """
        if not (np.isfinite(duration) and duration >= 0.0):
            raise SlipmodeError(f"duration: must be a finite number >= 0, got {duration}")
        inputs, names = self._inputs.copy(), ("frequency", "force", "phase")
        for name, end in zip(names, (frequency, magnitude, phase), strict=True):
            now = inputs[name][0, 0]
            wanted = now if end is None else float(end)
            if not np.isfinite(wanted):
                said = "magnitude" if name == "force" else name
                raise SlipmodeError(f"{said}: must be a finite number, got {wanted}")
            if name == "frequency" and abs(wanted - self._reference) > SPAN * self._reference:
                raise SlipmodeError(
                    f"frequency = {wanted:g} rad/s: must be within {percentage(SPAN)} of "
                    f"{self._reference:g} rad/s; start another flow at this frequency"
                )
            if duration > 0.0:
                inputs[f"{name}_rate"][0, 0] = (wanted - now) / duration
            else:
                inputs[name][0, 0] = wanted
        status = self._handle.set_inputs(inputs)
        if status == kernel.OK and duration > 0.0:
            status = self._handle.step(duration)
        if status == kernel.NOT_CONVERGED:
            raise SlipmodeError(NOT_CONVERGED)
        kernel.check(status, "slow flow of the tone")
        self.time += duration
        self._read()

    def displacement(self) -> Complexes:
        """Return the present harmonics of all DOFs.

        Returns
        -------
        (n,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m]; (N, n_s) of the free DOFs of
            the N sectors of a disk.
        """
        _, y, force = self._state()
        return self._modes.expand(self.modal_amplitude(), force, y)

    def modal_amplitude(self) -> Complexes:
        """Return the present amplitudes of the modes.

        Returns
        -------
        (R,) complex ndarray
            Amplitudes a_j [kg^1/2 m], q_j = 2 Re(a_j exp(i theta)): of the retained modes, in
            their order, then of the others. Of a disk, of the modes with open contacts.
        """
        a, y, force = self._state()
        return self._modes.modal(self.frequency, a, force, y)

    def contact_displacement(self) -> Complexes:
        """Return the present harmonics of all contact displacements.

        Returns
        -------
        (N_c,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m], without higher harmonics;
            of a disk sector by sector.
        """
        a, y, force = self._state()
        moved = self._modes.slow.motion @ a + self._modes.flexibility(self.frequency) @ y
        return np.asarray(moved + force * self._modes.displacement(self.frequency))

    def amplitude(self, dof: int) -> Floats:
        """Return the present displacement amplitude of a DOF.

        Parameters
        ----------
        dof : int
            DOF; of a disk, free DOF of the sector.

        Returns
        -------
        () ndarray
            Amplitude [m]; (N,) of the N blades of a disk.
        """
        return np.asarray(2.0 * np.abs(self.displacement()[..., dof]))

    @property
    def frequency(self) -> float:
        """Present forcing frequency Omega [rad/s]."""
        return float(self._inputs["frequency"][0, 0])

    @property
    def magnitude(self) -> float:
        """Present factor F of the force [-]."""
        return float(self._inputs["force"][0, 0])

    @property
    def phase(self) -> float:
        """Present phase of the force [rad]."""
        return float(self._inputs["phase"][0, 0])

    @property
    def angle(self) -> float:
        """Present phase theta of the carrier, from 0 to 2 pi [rad]."""
        return float(self._inputs["angle"][0, 0])

    def _state(self) -> tuple[Complexes, Complexes, complex]:
        """Return amplitudes of the slow modes, force deficits, and the magnitude of the force."""
        a, y = (each[0] + 1j * each[1] for each in (self._amplitude, self._deficit))
        return a, y, complex(phasor(self.magnitude, self.phase))

    def _read(self) -> None:
        """Read the state of the core; inputs do not move until the next step."""
        status = self._handle.present(self._inputs, self._amplitude, self._deficit)
        kernel.check(status, "slow flow of the tone")
        for name in kernel.INPUT_QUANTITIES:
            self._inputs[f"{name}_rate"] = 0.0
