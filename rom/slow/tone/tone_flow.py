"""Slow flow of one tone: amplitudes of all modes near the frequency of one force."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.tone.tone_modes import ToneModes
from slipmode.rom.table.local.local_contacts import LocalContacts

# Width of the bands of frequency within which the fast modes respond as in the middle, relative to
# the reference frequency: their response changes by less than 1e-3.
_BAND = 2e-3
# Part of the reference frequency by which the frequency may differ from it: the contacts respond
# to the harmonics of the reference (tests/rom/cyclic/test_mistuned_transients.py).
SPAN = 0.1


class ToneFlow:
    """Step a structure under one force in time, from rest.

    `rom.tone_flow` and `MistunedDisk.flow` make it. With the force deficits y of the contacts and
    the magnitude F of the force, the amplitudes a_m of the modes with stuck contacts obey::

        a_m' = (s_m - i Omega) a_m + b_m F + l_m y.

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
    time : float
        Present time [s].
    frequency : float
        Present forcing frequency Omega [rad/s].
    magnitude : float
        Present magnitude F, the factor of the force [-].
    """

    def __init__(
        self,
        modes: ToneModes,
        contacts: LocalContacts,
        own: Complexes,
        frequency: float,
        tolerance: float,
    ) -> None:
        self.time, self.frequency, self.magnitude = 0.0, frequency, 0.0
        self._angle = 0.0  # of the carrier [rad]
        self._modes, self._reference, self._own = modes, frequency, np.diag(own)
        self._amplitude: Floats = np.zeros((2, modes.slow.pole.size))
        self._deficit: Floats = np.zeros((2, own.size))
        self._next_step: Floats = np.zeros(1)
        self._band = 0
        self._others = self._in_band(0)
        nodes = contacts.secant.x
        spacing = (nodes[-1] - nodes[0]) / (nodes.size - 1)
        parts = [contacts.secant(nodes), spacing * contacts.secant(nodes, 1)]
        # (nodes, kinds, value or slope, real or imaginary)
        secant = np.array(parts).reshape(2, nodes.size, 2, contacts.kinds)
        stiffness = np.abs(parts[0]).max()
        self._tone = kernel.Tone(
            modes=modes.slow.pole.size,
            contacts=own.size,
            kinds=contacts.kinds,
            nodes=nodes.size,
            pole=_split(modes.slow.pole),
            excitation=_split(modes.slow.excitation),
            motion=_split(modes.slow.motion.T),
            projection=_split(modes.slow.projection.T),
            others=self._others,
            onset=contacts.onset,
            first=nodes[0],
            spacing=spacing,
            secant=kernel.contiguous(secant.transpose(1, 3, 0, 2)),
            contraction=stiffness * np.linalg.norm(modes.flexibility(frequency) - self._own, 2),
            tolerance=tolerance,
        )

    def step(
        self, duration: float, *, frequency: float | None = None, magnitude: float | None = None
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

        Raises
        ------
        SlipmodeError
            If an input is not allowed, or the step cannot meet its tolerance. The state is
            unchanged.
        """
        before = (self.frequency, self.magnitude)
        ends = (
            before[0] if frequency is None else float(frequency),
            before[1] if magnitude is None else float(magnitude),
        )
        if not (np.isfinite(duration) and duration >= 0.0):
            raise SlipmodeError(f"duration: must be a finite number >= 0, got {duration}")
        if not abs(ends[0] - self._reference) <= SPAN * self._reference:
            raise SlipmodeError(
                f"frequency = {ends[0]:g} rad/s: must be within {percentage(SPAN)} of "
                f"{self._reference:g} rad/s; start another flow at this frequency"
            )
        if not np.isfinite(ends[1]):
            raise SlipmodeError(f"magnitude: must be a finite number, got {ends[1]}")
        state = [each.copy() for each in (self._amplitude, self._deficit, self._next_step)]
        start = before if duration > 0.0 else ends
        if duration == 0.0:
            jump = ends[1] - before[1]
            state[0] += _split(self._modes.slow.after_jump(jump, ends[0], self._angle))
        for band, inputs in self._in_bands(duration, start, ends):
            self._enter_band(band)
            status = kernel.lib.sm_tone_march(self._tone, inputs, *state)
            if status == kernel.NOT_CONVERGED:
                raise SlipmodeError(
                    "contacts: the slow flow does not converge, because contacts act too strongly "
                    "on each other; integrate the structure in time (rom.full), of a disk "
                    "CyclicStructure.annulus()"
                )
            kernel.check(status, "slow flow of the tone")
        self.time += duration
        self._angle += 0.5 * duration * (before[0] + ends[0])
        self.frequency, self.magnitude = ends
        self._amplitude, self._deficit, self._next_step = state

    def displacement(self) -> Complexes:
        """Return the present harmonics of all DOFs.

        Returns
        -------
        (n,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m]; (N, n_s) of the free DOFs of
            the N sectors of a disk.
        """
        _, y = self._state()
        return self._modes.expand(self.modal_amplitude(), self.magnitude, y)

    def modal_amplitude(self) -> Complexes:
        """Return the present amplitudes of the modes.

        Returns
        -------
        (R,) complex ndarray
            Amplitudes a_j [kg^1/2 m], q_j = 2 Re(a_j exp(i theta)): of the retained modes, in
            their order, then of the others. Of a disk, of the modes with open contacts.
        """
        a, y = self._state()
        return self._modes.modal(self.frequency, a, self.magnitude, y)

    def contact_displacement(self) -> Complexes:
        """Return the present harmonics of all contact displacements.

        Returns
        -------
        (N_c,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m], without higher harmonics;
            of a disk sector by sector.
        """
        a, y = self._state()
        moved = self._modes.slow.motion @ a + self._modes.flexibility(self.frequency) @ y
        return np.asarray(moved + self.magnitude * self._modes.displacement(self.frequency))

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

    def _state(self) -> tuple[Complexes, Complexes]:
        """Return the amplitudes of the slow modes, and the force deficits of the contacts."""
        a, y = (each[0] + 1j * each[1] for each in (self._amplitude, self._deficit))
        return a, y

    def _in_bands(
        self, duration: float, start: tuple[float, float], end: tuple[float, float]
    ) -> Iterator[tuple[int, kernel.Structure]]:
        """Yield the bands of frequency that a step passes through, and its inputs there."""
        first, last = (round((each[0] / self._reference - 1.0) / _BAND) for each in (start, end))
        way = 1 if last >= first else -1
        begin, begun = start, 0.0
        for band in range(first, last + way, way):
            stop, stopped = end, 1.0
            if band != last:
                edge = self._reference * (1.0 + (band + 0.5 * way) * _BAND)
                stopped = max((edge - start[0]) / (end[0] - start[0]), begun)
                stop = (edge, start[1] + stopped * (end[1] - start[1]))
            inputs = kernel.ToneInputs(duration=duration * (stopped - begun))
            inputs.frequency[:], inputs.force[:] = zip(begin, stop, strict=True)
            yield band, inputs
            begin, begun = stop, stopped

    def _enter_band(self, band: int) -> None:
        if band != self._band:
            self._band = band
            self._others[:] = self._in_band(band)

    def _in_band(self, band: int) -> Floats:
        """Return what moves the contacts besides the slow modes and their own force deficits.

        Columns (N_c + 1, 2, N_c) per force deficit of each contact, then per magnitude.
        """
        frequency = self._reference * (1.0 + band * _BAND)
        by_contacts = self._modes.flexibility(frequency) - self._own
        return _split(np.vstack((by_contacts.T, self._modes.displacement(frequency))))


def _split(values: Complexes) -> Floats:
    """Return (..., n) complex numbers as (..., 2, n) real and imaginary parts."""
    return np.ascontiguousarray(np.stack((values.real, values.imag), axis=-2))
