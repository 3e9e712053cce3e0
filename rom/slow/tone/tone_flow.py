"""Slow flow of one or two tones: amplitudes of all modes near the frequencies of the forces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
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


# Inputs of a step, and their names in the core.
_FIELDS = {"frequency": "frequency", "magnitude": "force", "phase": "phase"}


class ToneFlow:
    """Step a structure under a force on each of one or two tones in time, from rest.

    `rom.tone_flow` and `MistunedDisk.flow` make it. With the force deficits y of the contacts at
    the carrier of a tone, and the magnitude F and the phase of its force, the amplitudes a_m of
    the modes with stuck contacts obey::

        a_m' = (s_m - i Omega) a_m + b_m F exp(i phase) + l_m y.

    Parameters
    ----------
    modes : sequence of ToneModes
        Modes with stuck contacts, near the carrier of each tone.
    contacts : LocalContacts
        Force deficit of each contact against its displacement without the flexibility `own`.
    own : (tones, N_c) complex ndarray
        Flexibility of each contact to its own force deficit [m/N].
    frequency : (tones,) ndarray
        Reference frequencies, and forcing frequencies Omega at the start [rad/s].
    tolerance : float
        Error of a step relative to the amplitudes [-].

    Attributes
    ----------
    time : float
        Present time [s].
    angle : float or (2,) ndarray
        Present phase theta of the carrier from 0 to 2 pi [rad]; of two tones one each, here and
        below.
    frequency, magnitude, phase : float or (2,) ndarray
        Present forcing frequency Omega [rad/s], factor F of the force [-], and phase [rad].
    """

    def __init__(
        self,
        modes: Sequence[ToneModes],
        contacts: LocalContacts,
        own: Complexes,
        frequency: Floats,
        tolerance: float,
    ) -> None:
        self._modes, self._reference = modes, frequency
        tone = core_tone(modes, contacts, own, frequency)
        self._handle = Handle("tone", tone, tolerance=tolerance)
        self._amplitude: Floats = np.zeros(sum(2 * each.slow.pole.size for each in modes))
        self._deficit: Floats = np.zeros((frequency.size, 2, own.shape[1]))
        self._inputs = kernel.inputs(1)
        self.time = 0.0
        self._read()

    def step(
        self,
        duration: float,
        *,
        frequency: ArrayLike | None = None,
        magnitude: ArrayLike | None = None,
        phase: ArrayLike | None = None,
    ) -> None:
        """Advance the time.

        Parameters
        ----------
        duration : float
            Length of the step [s]; 0 changes the inputs at once.
        frequency : float or (2,) array_like, optional
            Forcing frequency at the end of the step [rad/s], linear in between, at most 10 % from
            the reference frequency. Default: constant.
        magnitude : float or (2,) array_like, optional
            Factor of the force at the end of the step [-], linear in between. Default: constant.
        phase : float or (2,) array_like, optional
            Phase of the force at the end of the step [rad], linear in between. Default: constant.

        Raises
        ------
        SlipmodeError
            If an input is not allowed, or the step cannot meet its tolerance. The state is
            unchanged.
        """
        if not (np.isfinite(duration) and duration >= 0.0):
            raise SlipmodeError(f"duration: must be a finite number >= 0, got {duration}")
        inputs, tones = self._inputs.copy(), self._reference.size
        given = {"frequency": frequency, "magnitude": magnitude, "phase": phase}
        for name, field in _FIELDS.items():
            now = inputs[field][0, :tones]
            wanted = now.copy() if given[name] is None else self._wanted(name, given[name])
            if duration > 0.0:
                inputs[f"{field}_rate"][0, :tones] = (wanted - now) / duration
            else:
                now[:] = wanted
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
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m], (2, n) of two tones;
            (N, n_s) of the free DOFs of the N sectors of a disk.
        """
        modal = self.modal_amplitude().reshape(len(self._modes), -1)
        each = zip(self._states(), modal, strict=True)
        return self._of_tones([m.expand(q, force, y) for (m, _, _, y, force), q in each])

    def modal_amplitude(self) -> Complexes:
        """Return the present amplitudes of the modes.

        Returns
        -------
        (R,) complex ndarray
            Amplitudes a_j [kg^1/2 m], q_j = 2 Re(a_j exp(i theta)): of the retained modes, in
            their order, then of the others; (2, R) of two tones. Of a disk, of the modes with open
            contacts.
        """
        return self._of_tones([m.modal(nu, a, force, y) for m, nu, a, y, force in self._states()])

    def contact_displacement(self) -> Complexes:
        """Return the present harmonics of all contact displacements.

        Returns
        -------
        (N_c,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m], without higher harmonics;
            (2, N_c) of two tones; of a disk sector by sector.
        """
        return self._of_tones(
            [
                m.slow.motion @ a + m.flexibility(nu) @ y + force * m.displacement(nu)
                for m, nu, a, y, force in self._states()
            ]
        )

    def amplitude(self, dof: int) -> Floats:
        """Return the present displacement amplitude of a DOF.

        Parameters
        ----------
        dof : int
            DOF; of a disk, free DOF of the sector.

        Returns
        -------
        () ndarray
            Amplitude [m]; (2,) of two tones; (N,) of the N blades of a disk.
        """
        return np.asarray(2.0 * np.abs(self.displacement()[..., dof]))

    @property
    def frequency(self) -> Any:
        """Present forcing frequency Omega [rad/s]."""
        return self._present("frequency")

    @property
    def magnitude(self) -> Any:
        """Present factor F of the force [-]."""
        return self._present("force")

    @property
    def phase(self) -> Any:
        """Present phase of the force [rad]."""
        return self._present("phase")

    @property
    def angle(self) -> Any:
        """Present phase theta of the carrier, from 0 to 2 pi [rad]."""
        return self._present("angle")

    def _wanted(self, name: str, value: Any) -> Floats:
        """Return an input at the end of a step (tones,); refuse what is none."""
        wanted, reference = as_floats(name, value), self._reference
        if wanted.shape != (() if reference.size == 1 else reference.shape):
            many = "one number" if reference.size == 1 else "two numbers, of tones A and B"
            raise SlipmodeError(f"{name}: must be {many}, got {in_one_line(value)}")
        for end, own in zip(wanted.ravel().tolist(), reference.tolist(), strict=True):
            if not np.isfinite(end):
                raise SlipmodeError(f"{name}: must be a finite number, got {end}")
            if name == "frequency" and abs(end - own) > SPAN * own:
                raise SlipmodeError(
                    f"frequency = {end:g} rad/s: must be within {percentage(SPAN)} of "
                    f"{own:g} rad/s; start another flow at this frequency"
                )
        return wanted.reshape(reference.shape)

    def _present(self, field: str) -> Any:
        values = self._inputs[field][0, : self._reference.size]
        return float(values[0]) if values.size == 1 else values.copy()

    def _of_tones(self, values: list[Complexes]) -> Complexes:
        """Return values of each tone; of one tone without the axis of tones."""
        return np.asarray(values[0] if len(values) == 1 else values)

    def _states(self) -> Iterator[tuple[ToneModes, float, Complexes, Complexes, complex]]:
        """Yield for each tone its modes, frequency, slow amplitudes, force deficits, and force."""
        first = 0
        for t, modes in enumerate(self._modes):
            end = first + 2 * modes.slow.pole.size
            parts = self._amplitude[first:end].reshape(2, -1), self._deficit[t]
            a, y = (each[0] + 1j * each[1] for each in parts)
            given = self._inputs[0]
            force = complex(phasor(given["force"][t], given["phase"][t]))
            yield modes, float(given["frequency"][t]), a, y, force
            first = end

    def _read(self) -> None:
        """Read the state of the core; inputs do not move until the next step."""
        status = self._handle.present(self._inputs, self._amplitude, self._deficit)
        kernel.check(status, "slow flow of the tone")
        for name in kernel.INPUT_QUANTITIES:
            self._inputs[f"{name}_rate"] = 0.0
