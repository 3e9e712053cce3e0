"""Damping and frequency of a mode whose joint slips completely at large amplitudes.

The joint is one Jenkins element, or Segalman's four-parameter Iwan law: sliders that slip at
displacements phi with a density ~ phi^(p - 1) up to phi_max, and one with the share J of the
stiffness that slips at phi_max. J is 1 for one element, beta / (1 + beta) for Segalman's law. Of
the stiffness D = omega_0^2 - (omega_0 - h)^2 of the joint per mass, the share N of the describing
function is left at the amplitude s of the displacement, and the share T of the sliders sticks:

    omega^2 = omega_0^2 - D (1 - Re N),    omega_T^2 = omega_0^2 - D (1 - T),
    delta = (delta_0 + D Im N / (2 omega)) omega^2 / omega_T^2.

The last line is the balance of energy between turning points. There a slider that slips has the
same elastic energy at each amplitude, so that the stored energy changes by omega_T^2 s ds. Without
the factor omega^2 / omega_T^2 the rate would be too small by 1 - (omega_T / omega)^2.
A sensor of the k-th derivative of the displacement has the amplitude omega^k s.
"""

from __future__ import annotations

import numpy as np
import scipy

from slipmode.rom.common import Complexes, Floats
from slipmode.rom.identification.contacts.describing_function import describing_function

NO_MACRO_SLIP = -1.0  # J of laws without macro-slip


def joint_stiffness(c: Floats, p: Floats, J: Floats) -> tuple[Complexes, Floats, Floats]:
    """Return the share N of the describing function, d Re N / d log s, and the share T, (...).

    `c` is phi_max / s, T the share of the sliders that stick. The integrals of the describing
    function of Jenkins elements over their density are incomplete beta functions.
    """
    c_1 = np.minimum(c, 1.0)
    N_1, slope_1 = describing_function(c_1[..., np.newaxis], np.ones(1), np.ones_like(c_1))
    if np.all(J == 1.0):
        return N_1, slope_1.real, np.asarray(c >= 1.0, float)
    slipping = np.minimum(c**-p, 1.0)
    half = p + 1.5
    beta = scipy.special.beta(half, 1.5) * scipy.special.betainc(half, 1.5, c_1)
    softer = 8.0 / np.pi * c_1**-p * beta
    loss = 4.0 * p / np.pi * (c_1 / (p + 1.0) - c_1**2 / (p + 2.0))
    of_sliders = 1.0 - slipping + slipping * (N_1.real - softer + 1j * loss)
    N = J * N_1 + (1.0 - J) * of_sliders
    slope = J * slope_1.real - (1.0 - J) * p * slipping * softer
    T = J * (c >= 1.0) + (1.0 - J) * (1.0 - slipping)
    return N, slope, T


def limit_share(p: Floats, J: Floats) -> Floats:
    """Return F_S / (K_T phi_max), with the force F_S of macro-slip and the stiffness K_T."""
    share: Floats = (p + J) / (p + 1.0)
    return share


def slip_amplitude(own: Floats, reference: Floats) -> Floats:
    """Return phi_max, the amplitude of macro-slip [sensor unit] at the frequency in stick.

    F_S per mass is pi g R (omega_0 - h)^(1 - k) / 2 for the k-th derivative of the displacement:
    far beyond macro-slip friction adds g R / s.
    """
    omega_0, g, h, p, J, k = own[[1, 2, 3, 4, 6, 7]]
    stiffness, slip = h * (2.0 * omega_0 - h), omega_0 - h
    force = 0.5 * np.pi * g * reference * slip * (omega_0 / slip) ** k
    made: Floats = force / (stiffness * limit_share(p, J))
    return made


def macro_slip_rates(own: Floats, size: Floats, reference: Floats) -> Complexes:
    """Return -delta + i omega at amplitudes `size` [sensor unit], see `complex_rates`."""
    delta_0, omega_0, _, h, p, _, J, k = own
    stiffness = h * (2.0 * omega_0 - h)
    phi = slip_amplitude(own, reference)
    if np.any(k):  # Newton's step to the displacement, times omega_0^k
        N, slope, _ = joint_stiffness(phi / size, p, J)
        square = omega_0**2 - stiffness * (1.0 - N.real)
        shift = 0.5 * k * np.log(omega_0**2 / square)
        size = size * np.exp(shift / (1.0 + 0.5 * k * stiffness * slope / square))
    N, slope, T = joint_stiffness(phi / size, p, J)
    square = omega_0**2 - stiffness * (1.0 - N.real)
    omega = np.sqrt(square)
    energy = omega_0**2 - stiffness * (1.0 - T)
    delta = (delta_0 + 0.5 * stiffness * N.imag / omega) * square / energy
    rates: Complexes = 1j * omega - delta * (1.0 + 0.5 * k * stiffness * slope / square)
    return rates
