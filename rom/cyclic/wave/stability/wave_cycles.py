"""Limit cycles of a self-excited wave, in which friction dissipates the aerodynamic power.

Amplitude and frequency are both unknown: D(Omega) a = psi_r^H y(|a|, Omega).
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.cyclic.wave.wave_balance import Balance, Balanced
from slipmode.rom.cyclic.wave.wave_problem import Carrier, Wave
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.contacts import Elastic

# Amplitudes that are tried, relative to the onset of slip: from micro-slip of joints with many
# sliders to contacts that hardly hold.
_SMALLEST, _LARGEST, _AMPLITUDES = 1e-3, 1e4, 100
# Of |a| at another frequency: an even number, so that none is the |a| itself.
_NEAR = np.geomspace(0.5, 2.0, 12)
# Of Omega^2, relative, at convergence.
_CHANGE, _ITERATIONS = 1e-9, 30


def wave_cycles(wave: Wave, law: Elastic, steps: int) -> list[Balanced]:
    """Return the limit cycles of a wave with so many steps a period, by amplitude.

    Raises
    ------
    SlipmodeError
        If the wave is not self-excited.
    """

    def unforced(frequency: float) -> Balance:
        nothing = np.zeros(wave.shape.size, dtype=complex)
        return Balance.of(Carrier(wave, frequency, nothing), law, steps)

    def crossings(balance: Balance, sizes: Floats) -> list[float]:
        """Return |a| between `sizes` at which the wave neither gains nor loses energy."""
        return balance.sign_changes(lambda required: required.imag, sizes)

    start = unforced(wave.frequency)
    damping = start.carrier.stiffness.imag / wave.frequency
    if damping >= 0.0:
        raise SlipmodeError(
            f"aerodynamics: mode {wave.mode} of nodal diameter {wave.nodal_diameter} is not "
            f"self-excited. Its damping is {damping:.4g} 1/s; rom.flutter_growth returns the "
            "self-excited nodal diameters"
        )
    found = []
    every = np.geomspace(_SMALLEST, _LARGEST, _AMPLITUDES)
    for size in crossings(start, _onset(wave, law) * every):
        balance, near = start, [size]
        for _ in range(_ITERATIONS):
            if not near:  # friction dissipates less at this frequency
                break
            size = near[0]
            required = balance.required(np.array([size]))
            # Re D = omega^2 - Omega^2 + ..., and Re(required) = 0 at the frequency of the cycle
            square = balance.carrier.frequency**2
            change = 0.5 * float(required[0].real) / size
            if abs(change) <= _CHANGE * square:
                found.append(Balanced(balance, complex(size)))
                break
            balance = unforced(float(np.sqrt(square + change)))
            near = crossings(balance, size * _NEAR)
    return found


def _onset(wave: Wave, law: Elastic) -> float:
    """Return |a| at which the first contact slips or lifts off [kg^1/2 m]."""
    elements = law.elements(wave.contact_motion.size)
    force = 2.0 * elements.reference * np.abs(wave.contact_motion)
    slips = (force > 0.0) & (elements.limit > 0.0)
    if not slips.any():
        raise SlipmodeError(
            f"law: no contact slips in mode {wave.mode} of nodal diameter {wave.nodal_diameter}, "
            "so friction does not limit its amplitude"
        )
    return float((elements.limit[slips] / force[slips]).min())
