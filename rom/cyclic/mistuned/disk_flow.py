"""Slow flow of a disk whose blades differ: amplitudes of all slow modes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.cyclic.mistuned.local_contacts import LocalContacts
from slipmode.rom.cyclic.mistuned.stuck_modes import StuckModes
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen, percentage

# Width of the bands of frequency within which the fast modes respond as in the middle, relative to
# the reference frequency: their response changes by less than 1e-3.
_BAND = 2e-3
# Part of the reference frequency by which the frequency may differ from it: the contacts respond
# to the harmonics of the reference (tests/rom/cyclic/test_mistuned_transients.py).
SPAN = 0.1


class DiskFlow:
    """Step a mistuned disk in time, from rest.

    `MistunedDisk.flow` makes it. With the force deficits y of the contacts and the magnitude F of
    the force, the amplitudes a_m of the modes with stuck contacts obey::

        a_m' = (s_m - i Omega) a_m + b_m F + l_m y.

    Parameters
    ----------
    modes : StuckModes
        Modes of the disk with stuck contacts.
    contacts : LocalContacts
        Force deficit of each contact against its displacement without the flexibility `own`.
    own : (N N_c,) complex ndarray
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
        modes: StuckModes,
        contacts: LocalContacts,
        own: Complexes,
        frequency: float,
        tolerance: float,
    ) -> None:
        self.time, self.frequency, self.magnitude = 0.0, frequency, 0.0
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
        secant = np.array(parts).reshape(2, nodes.size, 2, contacts.contacts)
        stiffness = np.abs(parts[0]).max()
        self._disk = kernel.Disk(
            modes=modes.slow.pole.size,
            contacts=own.size,
            kinds=contacts.contacts,
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
        for band, inputs in self._in_bands(duration, start, ends):
            self._enter_band(band)
            status = kernel.lib.sm_disk_march(self._disk, inputs, *state)
            if status == kernel.NOT_CONVERGED:
                raise SlipmodeError(
                    "contacts: the slow flow does not converge, because contacts act too strongly "
                    "on each other; integrate CyclicStructure.annulus() in time (rom.full)"
                )
            kernel.check(status, "slow flow of the disk")
        self.time += duration
        self.frequency, self.magnitude = ends
        self._amplitude, self._deficit, self._next_step = state

    def displacement(self) -> Complexes:
        """Return the present harmonics of all free DOFs.

        Returns
        -------
        (N, n_s) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m].
        """
        a, y = (each[0] + 1j * each[1] for each in (self._amplitude, self._deficit))
        return self._modes.blades(self.frequency, a, self.magnitude, y)

    def contact_displacement(self) -> Complexes:
        """Return the present harmonics of all contact displacements.

        Returns
        -------
        (N N_c,) complex ndarray
            Harmonics c of the displacements 2 Re(c exp(i theta)) [m], sector by sector, without
            higher harmonics.
        """
        a, y = (each[0] + 1j * each[1] for each in (self._amplitude, self._deficit))
        moved = self._modes.slow.motion @ a + self._modes.flexibility(self.frequency) @ y
        return np.asarray(moved + self.magnitude * self._modes.displacement(self.frequency))

    def amplitude(self, dof: int) -> Floats:
        """Return the present displacement amplitude of a DOF of every blade.

        Parameters
        ----------
        dof : int
            Free DOF of the sector.

        Returns
        -------
        (N,) ndarray
            Amplitudes [m].
        """
        return np.asarray(2.0 * np.abs(self.displacement()[:, dof]))

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
            inputs = kernel.DiskInputs(duration=duration * (stopped - begun))
            inputs.frequency[:], inputs.force[:] = zip(begin, stop, strict=True)
            yield band, inputs
            begin, begun = stop, stopped

    def _enter_band(self, band: int) -> None:
        if band != self._band:
            self._band = band
            self._others[:] = self._in_band(band)

    def _in_band(self, band: int) -> Floats:
        """Return what moves the contacts besides the slow modes and their own force deficits.

        Columns (N N_c + 1, 2, N N_c) per force deficit of each contact, then per magnitude.
        """
        frequency = self._reference * (1.0 + band * _BAND)
        by_contacts = self._modes.flexibility(frequency) - self._own
        return _split(np.vstack((by_contacts.T, self._modes.displacement(frequency))))


@frozen
class Script:
    """Inputs of a transient, straight lines between its times.

    Attributes
    ----------
    time : (samples,) ndarray
        Increasing [s].
    frequency, magnitude : (samples,) ndarray
        Inputs at these times.
    """

    time: Floats
    frequency: Floats
    magnitude: Floats

    @classmethod
    def of(cls, time: ArrayLike, frequency: ArrayLike, magnitude: ArrayLike) -> Self:
        """Return a script of numbers, or of arrays with a number for each time."""
        times = as_floats("time", time)
        if times.ndim != 1 or times.size == 0 or not np.all(np.diff(times) > 0.0):
            raise SlipmodeError(f"time: must be increasing numbers, got {in_one_line(time)}")
        inputs = []
        for name, value in (("frequency", frequency), ("magnitude", magnitude)):
            given = as_floats(name, value)
            if given.shape not in ((), times.shape) or not np.all(np.isfinite(given)):
                raise SlipmodeError(
                    f"{name}: must be a finite number or {times.size}, one per time, got "
                    f"{in_one_line(value)}"
                )
            inputs.append(np.array(np.broadcast_to(given, times.shape)))
        if not np.all(inputs[0] > 0.0):
            raise SlipmodeError(f"frequency: must be > 0, got {in_one_line(frequency)}")
        return cls(times, *inputs)

    def follow(self, flow: DiskFlow) -> Complexes:
        """Return displacements (samples, N, n_s) of a disk that is at rest at the first time."""
        moved = []
        steps = (np.diff(self.time, prepend=self.time[0]), self.frequency, self.magnitude)
        for duration, frequency, magnitude in np.transpose(steps).tolist():
            flow.step(duration, frequency=frequency, magnitude=magnitude)
            moved.append(flow.displacement())
        return np.array(moved)


def _split(values: Complexes) -> Floats:
    """Return (..., n) complex numbers as (..., 2, n) real and imaginary parts."""
    return np.ascontiguousarray(np.stack((values.real, values.imag), axis=-2))
