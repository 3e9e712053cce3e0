"""Powers of the energy balance: input = contacts + structural damping + change of energy."""

from __future__ import annotations

from functools import partial

import numpy as np

from slipmode.rom import Model
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import coupling_factor
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.transients.full_order import SlowPart


class SlowBalance:
    """The energy balance of the modes in slow time."""

    def __init__(self, plan: ModesPlan, model: Model) -> None:
        self._plan, self._model = plan, model
        self._last = np.zeros((1, model.modes), dtype=complex)  # amplitudes of the last point
        self._applied = AppliedForces.of(model.reduced, plan.excited.force_patterns)

    def rows(self, power: Floats, amplitude: Complexes, first: int) -> Floats:
        """Return the rows of ``/energy`` at communication points from number `first` on.

        Points continue the call before. `power` (points, 3) has the powers and the energy
        that a component states, `amplitude` (points, modes) is a_j. The power that is stored is
        the input less both dissipated powers.
        """
        time = self._plan.schedule.time(slice(max(first - 1, 0), first + len(amplitude)))
        before = self._last if first else amplitude[:1]
        span = np.diff(time)[:, np.newaxis] if first else 1.0
        rate = (amplitude - np.vstack((before, amplitude[:-1]))) / span
        self._last = amplitude[-1:]
        structural = self._structural(amplitude, rate, first)
        stored = power[:, 0] - power[:, 1] - structural
        return np.column_stack((power, structural, stored))

    def _structural(self, amplitude: Complexes, rate: Complexes, first: int) -> Floats:
        """Return the power that structural damping dissipates, (points,) [W]."""
        excited, schedule = self._plan.excited, self._plan.schedule
        reduced, table = self._model.reduced, self._model.table
        points = slice(first, first + len(amplitude))
        at_points = partial(schedule.at_points, points=points)
        force, frequency, scale = excited.loads(at_points)
        shift = self._applied.shift * force
        velocity = rate + 1j * frequency * amplitude
        power = 2.0 * np.abs(velocity) ** 2 @ reduced.modal_damping
        factor = coupling_factor(reduced, frequency)
        effective = factor * (amplitude + shift) / scale
        modulus = np.abs(effective)
        terms = table.terms(np.minimum(modulus, table.amplitude_range))
        unit = np.divide(effective, modulus, out=np.zeros_like(effective), where=modulus > 0.0)
        friction = scale * factor * unit * terms[:, : table.modes]  # on the modes
        # dampers of the other modes, which the force moves directly and through the contacts
        per_force, per_amplitude = self._applied.other_modes.T
        x = 2.0 * self._applied.shift * friction + per_force * force + per_amplitude * amplitude
        others = -(force.conj() * x).imag + 2.0 * (shift.conj() * friction).imag
        power += np.sum(frequency * others, axis=1)
        if table.values.shape[-1] > 2 * table.modes:  # powers of the contacts are tabulated
            power -= scale[:, 0] ** 2 * terms[:, -1].real
        return np.asarray(power)


class ToneBalance:
    """The energy balance of several modes on one or two tones."""

    def __init__(self, plan: ModesPlan) -> None:
        self._plan, reduced = plan, plan.excited.reduced
        self._natural, self._tones = reduced.frequency, list(reduced.tone_numbers)
        self._before: tuple[Floats, Complexes, Floats] | None = None  # the last point

    def rows(self, power: Floats, amplitude: Complexes, first: int) -> Floats:
        """Return the rows of ``/energy``, see `SlowBalance.rows`.

        The stored power is the rate of the energy of the modes, see `full_order_balance`, and
        structural damping dissipates what remains of the input.
        """
        if not len(power):
            return np.empty((0, 5))
        schedule, points = self._plan.schedule, slice(first, first + len(power))
        time = schedule.time(points)
        names = [f"frequency_{tone}" for tone in self._plan.excited.modes]
        tone = schedule.at_points(names, points)
        starts = self._before is None
        now, a, energy = self._before or (time[:1] - 1.0, amplitude[:1], np.zeros(1))
        span = np.diff(time, prepend=now)
        rate = np.diff(amplitude, axis=0, prepend=a) / span[:, np.newaxis]
        velocity = rate + 1j * tone[:, self._tones] * amplitude
        energies = np.sum(np.abs(velocity) ** 2 + np.abs(self._natural * amplitude) ** 2, axis=1)
        stored = np.diff(energies, prepend=energies[:1] if starts else energy) / span
        self._before = time[-1:], amplitude[-1:], energies[-1:]
        structural = power[:, 0] - power[:, 1] - stored
        structural[0] *= not starts  # nothing has moved
        return np.column_stack((power, structural, power[:, 0] - power[:, 1] - structural))


def full_order_balance(natural: Floats, frequency: Floats, slow: SlowPart) -> Floats:
    """Return the rows of ``/energy`` of a stretch at full order, (points, 5).

    The stored power is the rate of the energy of the modes, and structural damping dissipates
    what remains of the input. The energy is the sum of abs(v_j)^2 + omega_j^2 abs(a_j)^2, where
    v_j = da_j/dt + i Omega_j a_j. `natural` (modes,) has omega_j, `frequency` (points, modes)
    Omega_j, in rad/s.
    """
    velocity = slow.rate + 1j * frequency * slow.amplitude
    kinetic = velocity.conj() * (slow.second + 1j * frequency * slow.rate)
    potential = natural**2 * slow.amplitude.conj() * slow.rate
    stored = 2.0 * np.sum((kinetic + potential).real, axis=1)
    structural = slow.power[:, 0] - slow.power[:, 1] - stored
    return np.column_stack((slow.power, structural, stored))
