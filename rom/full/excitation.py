"""One or two harmonic forces whose parameters are piecewise linear in time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom import kernel
from slipmode.rom.arrays import Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.force_vector import force_vector
from slipmode.rom.structure.structure import Structure


@frozen
class Excitation:
    """Hold harmonic forces f(t) = sum_j patterns_j amplitude_j(t) cos(theta_j(t) + phase_j(t)).

    The carrier phase has the rate theta_j' = frequency_j(t). It is continuous, and 0 at the first
    start. Amplitude, frequency and phase are linear in time on each segment and may jump between
    segments. The last segment has no end. See source Eq. (2).

    Attributes
    ----------
    patterns : (modes, n) ndarray
        Force on every DOF per unit of amplitude [-], one or two rows.
    start : (segments,) ndarray
        Start times of the segments [s], increasing.
    amplitude, frequency, phase : (segments, modes) ndarray
        Values at the start of each segment: amplitude [N], frequency [rad/s] > 0, phase [rad].
    amplitude_rate, frequency_rate, phase_rate : (segments, modes) ndarray
        Their rates in each segment [N/s], [rad/s^2], [rad/s].

    Raises
    ------
    SlipmodeError
        If an array has a wrong shape or is not finite, or a frequency is not positive.
    """

    patterns: Floats
    start: Floats
    amplitude: Floats
    amplitude_rate: Floats
    frequency: Floats
    frequency_rate: Floats
    phase: Floats
    phase_rate: Floats

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = kernel.contiguous(getattr(self, name))
            if not np.all(np.isfinite(value)):
                raise SlipmodeError(f"{name}: must be finite, found NaN or infinity")
            object.__setattr__(self, name, value)
        if self.patterns.ndim != 2 or self.modes not in (1, 2):
            raise SlipmodeError("patterns: must be one or two rows, one force per DOF each")
        if self.start.ndim != 1 or self.start.size == 0 or np.any(np.diff(self.start) <= 0):
            raise SlipmodeError("start: must be increasing times, at least one [s]")
        shape = (self.start.size, self.modes)
        for quantity in ("amplitude", "frequency", "phase"):
            for name in (quantity, f"{quantity}_rate"):
                if getattr(self, name).shape != shape:
                    raise SlipmodeError(f"{name}: must have shape {shape} (segments, modes)")
        duration = np.append(np.diff(self.start), 0.0)[:, np.newaxis]
        last = self.frequency + duration * self.frequency_rate
        if np.any(self.frequency <= 0) or np.any(last <= 0):
            raise SlipmodeError("frequency: must stay > 0 [rad/s]")

    @classmethod
    def harmonic(
        cls,
        structure: Structure,
        force: Sequence[Mapping[int, float] | ArrayLike],
        frequency: ArrayLike,
        phase: ArrayLike = 0.0,
    ) -> Self:
        """Return forces with constant amplitude, frequency and phase from t = 0 on.

        Parameters
        ----------
        structure : Structure
            Structure on which the forces act.
        force : sequence of {DOF: amplitude} or (n,) array_like
            Force amplitudes [N] of one or two harmonic forces.
        frequency : (modes,) array_like
            Forcing frequencies Omega_j [rad/s].
        phase : (modes,) array_like or float, default 0.0
            Phases of the forces [rad].

        Returns
        -------
        Excitation
            One segment.

        Raises
        ------
        SlipmodeError
            If there are not one or two forces, or an array has a wrong shape.

        Examples
        --------
        >>> structure = rom.two_mass()
        >>> forces = ({0: 0.15}, {1: 0.25})
        >>> excitation = full.Excitation.harmonic(structure, forces, (0.98, 1.65))
        """
        if not isinstance(force, Sequence | np.ndarray) or len(force) not in (1, 2):
            raise SlipmodeError("force: must be one or two forces, one per mode")
        patterns = np.array([force_vector(each, structure.n_dofs) for each in force])
        row = (1, len(patterns))
        values = {}
        for name, value in (("frequency", frequency), ("phase", phase)):
            given = as_floats(name, value)
            if given.shape not in ((), row[1:]):
                raise SlipmodeError(f"{name}: must be {row[1]} numbers, one per mode")
            values[name] = np.broadcast_to(given, row)
        zero = np.zeros(row)
        return cls(
            patterns=patterns,
            start=np.zeros(1),
            amplitude=np.ones(row),
            amplitude_rate=zero,
            frequency_rate=zero,
            phase_rate=zero,
            **values,
        )

    @property
    def modes(self) -> int:
        """Number of harmonic forces, 1 or 2."""
        return int(self.patterns.shape[0])

    @property
    def is_constant(self) -> bool:
        """Whether amplitudes, frequencies and phases are constant."""
        rates = (self.amplitude_rate, self.frequency_rate, self.phase_rate)
        return self.start.size == 1 and not any(np.any(rate) for rate in rates)

    def fastest(self, until: float) -> float:
        """Return the largest forcing frequency up to a time.

        Parameters
        ----------
        until : float
            Time [s], not before the first start.

        Returns
        -------
        float
            Largest frequency [rad/s].
        """
        end = np.minimum(np.append(self.start[1:], until), until)
        duration = np.clip(end - self.start, 0.0, None)[:, np.newaxis]
        reached = np.maximum(self.frequency, self.frequency + duration * self.frequency_rate)
        return float(reached[self.start <= until].max())

    def at(self, times: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the forces and their carriers at given times, after jumps.

        Parameters
        ----------
        times : (n,) ndarray
            Times [s].

        Returns
        -------
        angle : (n, modes) ndarray
            Carrier phases theta_j [rad].
        frequency : (n, modes) ndarray
            Frequencies [rad/s].
        force : (n, modes) ndarray
            amplitude_j cos(theta_j + phase_j) [N].
        """
        k = np.maximum(np.searchsorted(self.start, times, side="right") - 1, 0)
        since = (times - self.start[k])[:, np.newaxis]
        frequency = self.frequency[k] + since * self.frequency_rate[k]
        angle = self.inputs()["angle"][k, : self.modes]
        angle = angle + 0.5 * since * (self.frequency[k] + frequency)
        phase = self.phase[k] + since * self.phase_rate[k]
        amplitude = self.amplitude[k] + since * self.amplitude_rate[k]
        return angle, frequency, amplitude * np.cos(angle + phase)

    def inputs(self) -> np.ndarray:
        """Return the segments as the compiled core reads them.

        Returns
        -------
        (segments,) structured ndarray
            Forces, frequencies, phases and their rates.
        """
        duration = np.diff(self.start)[:, np.newaxis]
        turned = duration * (self.frequency[:-1] + 0.5 * duration * self.frequency_rate[:-1])
        inputs = kernel.inputs(self.start.size)
        modes = slice(0, self.modes)
        inputs["force"][:, modes] = self.amplitude
        inputs["force_rate"][:, modes] = self.amplitude_rate
        for name in ("frequency", "frequency_rate", "phase", "phase_rate"):
            inputs[name][:, modes] = getattr(self, name)
        inputs["angle"][1:, modes] = np.cumsum(turned, axis=0) % (2 * np.pi)
        return inputs
