"""Quadratic and cubic stiffness of the retained modes (geometric nonlinearity), in slow time.

The modal forces are the gradient of a potential,

    F_j = sum_kl alpha_jkl q_k q_l + sum_klm gamma_jklm q_k q_l q_m,

with coefficients that do not depend on the order of their indices. With q_j = a_j exp(i theta_j)
+ c.c., the cubic terms act on a mode at its carrier as the stiffness sum_k h_jk |a_k|^2,

    h_jj = 3 gamma_jjjj,    h_jk = 6 gamma_jjkk.

Quadratic terms move the modes at harmonics 0, 2 theta_j, theta_j + theta_k and theta_j - theta_k.
This motion acts back on the modes at their carriers, which adds to h (Nayfeh and Mook 1979, 2.3).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import permutations

import numpy as np

from slipmode.rom.arrays import Floats, as_floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.representable import ALLOWED, fits
from slipmode.rom.short_repr import percentage

# Coefficients of other orders of the letters, relative to each other, that are equal.
_EQUAL = 1e-6
# Distance of a harmonic of nonlinear stiffness from a natural frequency, relative to it, below
# which the other mode is in resonance with it.
_RESONANT = 0.1
# Force on the other mode, relative to its stiffness and amplitude range, which may be neglected:
# in resonance with a damping ratio of 0.5 % it moves the mode by 1 % of the range.
_LEAST_FORCE = 1e-4
# Largest part of the stiffness that quadratic terms may remove at the ends of the amplitude range.
# Its error is then below 0.7 % (tests/rom/slow/test_nonlinear_stiffness.py).
_MOST_QUADRATIC = 0.08


def with_nonlinear_stiffness(reduced: Reduced, coefficients: Mapping[str, float]) -> Reduced:
    """Return a reduced model with quadratic and cubic stiffness of its modes.

    The modal forces are F_j = sum_kl alpha_jkl q_k q_l + sum_klm gamma_jklm q_k q_l q_m, with the
    modal displacements q of mass-normalised modes. All other modes follow statically in the
    coefficients, for instance membrane modes of a plate (implicit condensation).

    Parameters
    ----------
    reduced : Reduced
        One or two modes with a tone each.
    coefficients : {str: float}
        alpha [kg^-1/2 m^-1 s^-2] by three letters, gamma [kg^-1 m^-2 s^-2] by four letters, as
        {"AAA": 2e4, "AAAA": 1e8, "AABB": 3e7}. A coefficient is the same for each order of its
        letters, because the forces have a potential: the force on A has 3 gamma_AABB q_A q_B^2.
        Coefficients that are not given are 0.

    Returns
    -------
    Reduced
        Model with `quadratic` and `cubic`.

    Raises
    ------
    SlipmodeError
        If a coefficient is not allowed, or two orders of its letters differ. If the formulation is
        "paper", or modes share a tone.

    Notes
    -----
    In the slow flow they are the stiffness sum_k h_jk |a_k|^2 of mode j, with h_jj = 3 gamma_jjjj
    and h_jk = 6 gamma_jjkk. Quadratic coefficients add to h to second order, for one mode -10/3
    alpha^2 / omega^2. Harmonics of the modes due to the coefficients are not part of the motion.
    `rom.tabulate` refuses amplitudes at which a mode becomes unstable, and modes that the
    coefficients couple near a ratio of 1:1, 1:2 or 1:3. See "Nonlinear stiffness" in
    docs/theory.md.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), modes=(0,))
    >>> stiffer = rom.with_nonlinear_stiffness(reduced, {"AAAA": 0.01})
    >>> model = rom.tabulate(stiffer, rom.Coulomb(2.0), amplitude=(4.0,))
    >>> rom.backbone(model, amplitude=[1.0, 3.0]).frequency.round(3)
    array([1.015, 1.112])
    """
    if reduced.formulation == "paper" or reduced.tone_numbers or reduced.ratio:
        raise SlipmodeError(
            "coefficients: must be of one or two modes with a tone each, in the formulation "
            "'consistent'"
        )
    quadratic, cubic = coefficient_tensors(coefficients, len(reduced.modes))
    return replace(reduced, quadratic=quadratic, cubic=cubic)


def refuse_nonlinear_stiffness(reduced: Reduced, name: str, advice: str) -> None:
    """Raise SlipmodeError if the modes have nonlinear stiffness, which `name` neglects."""
    if reduced.cubic is not None:
        raise SlipmodeError(f"nonlinear stiffness: {name} does not include it; {advice}")


def coefficient_tensors(coefficients: Mapping[str, float], modes: int) -> tuple[Floats, Floats]:
    """Return alpha (modes,)*3 and gamma (modes,)*4 of coefficients by letters, as "AABB".

    Raises
    ------
    SlipmodeError
        If a name or value is not allowed, or two orders of the same letters differ.
    """
    names = "AB"[:modes]
    tensors = {n: np.full((modes,) * n, np.nan) for n in (3, 4)}
    for name, value in coefficients.items():
        if len(name) not in tensors or not set(name) <= set(names):
            raise SlipmodeError(
                f"coefficient {name}: must be three or four of the letters {', '.join(names)}, "
                "as AAA or AAAA"
            )
        if not (np.ndim(value) == 0 and fits(as_floats(f"coefficient {name}", value))):
            raise SlipmodeError(f"coefficient {name}: must be {ALLOWED}, got {value}")
        for order in set(permutations(names.index(letter) for letter in name)):
            known = tensors[len(name)][order]
            if abs(known - value) > _EQUAL * abs(value):
                raise SlipmodeError(
                    f"coefficient {name} = {value:g}: other orders of these letters have "
                    f"{known:g}; forces of a potential have equal coefficients"
                )
            tensors[len(name)][order] = value
    return np.nan_to_num(tensors[3]), np.nan_to_num(tensors[4])


def hardening(reduced: Reduced) -> Floats:
    """Return h_jk, the stiffness of mode j per |a_k|^2, (modes, modes) [kg^-1 m^-2 s^-2]."""
    if reduced.quadratic is None or reduced.cubic is None:
        return np.zeros((len(reduced.modes), len(reduced.modes)))
    by_cubic, by_quadratic = _parts(reduced.frequency, reduced.quadratic, reduced.cubic)
    return np.asarray(by_cubic + by_quadratic)


def _parts(frequency: Floats, quadratic: Floats, cubic: Floats) -> tuple[Floats, Floats]:
    """Return the parts of h due to cubic and to quadratic terms; frequencies (modes,) [rad/s]."""
    modes = np.arange(len(frequency))
    square, alpha = frequency**2, quadratic
    by_cubic, by_quadratic = np.zeros((2, len(modes), len(modes)))
    for j in modes:
        for k in modes:
            by_cubic[j, k] = (3.0 if j == k else 6.0) * cubic[j, j, k, k]
            mean = alpha[:, j, j] * alpha[:, k, k] / square
            coupled = alpha[:, j, k] != 0.0
            own, coupling = square[coupled], alpha[coupled, j, k] ** 2
            above = coupling / (own - (frequency[j] + frequency[k]) ** 2)
            if j == k:
                by_quadratic[j, j] = -4.0 * np.sum(mean) - 2.0 * np.sum(above)
            else:
                below = coupling / (own - (frequency[j] - frequency[k]) ** 2)
                by_quadratic[j, k] = -4.0 * (np.sum(mean) + np.sum(above + below))
    return by_cubic, by_quadratic


def _refuse_resonances(omega: Floats, alpha: Floats, gamma: Floats, largest: Floats) -> None:
    """Refuse terms that drive the other mode in resonance, whose amplitudes would not be slow."""
    for j, k in permutations(range(omega.size), 2):
        r = largest[j]
        coupling = np.abs(gamma[j, k] * np.multiply.outer(largest, largest)).max() * largest.max()
        driven = {1: coupling, 2: abs(alpha[j, j, k]) * r**2, 3: abs(gamma[j, j, j, k]) * r**3}
        for order, force in driven.items():
            apart = abs(order * omega[j] / omega[k] - 1.0)
            if apart < _RESONANT and force > _LEAST_FORCE * omega[k] ** 2 * largest[k]:
                raise SlipmodeError(
                    f"amplitude: {order} omega_{'AB'[j]} is {percentage(apart)} from "
                    f"omega_{'AB'[k]}, and nonlinear stiffness couples both modes in this "
                    f"resonance, which is not modelled within {percentage(_RESONANT)}; retain one "
                    "mode"
                )


def check_amplitude_range(reduced: Reduced, largest: Floats) -> None:
    """Refuse amplitudes (modes,) at which the nonlinear stiffness is not valid."""
    if reduced.quadratic is None or reduced.cubic is None:
        return
    coefficients = reduced.frequency, reduced.quadratic, reduced.cubic
    _refuse_resonances(*coefficients, largest)
    parts = _parts(*coefficients)
    square = reduced.frequency**2
    # The restoring force of q = 2 |a| vanishes where 4/3 h_jj |a_j|^2 + 2 h_jk |a_k|^2 is -omega^2
    peak = np.where(np.eye(square.size) > 0.0, 4.0 / 3.0, 2.0)
    for kind, h, most in (("cubic", sum(parts), 1.0), ("quadratic", parts[1], _MOST_QUADRATIC)):
        removed = -(peak * np.minimum(h, 0.0)) @ largest**2 / square
        j = int(removed.argmax())
        if removed[j] >= most:
            advice = "reduce the amplitudes, or leave the coefficients out"
            what = (
                f"soften mode {'AB'[j]} to instability within the range"
                if kind == "cubic"
                else f"remove {percentage(removed[j])} of the stiffness of mode {'AB'[j]}, "
                f"allowed: {percentage(most)}"
            )
            amplitudes = ", ".join(f"{a:.3g}" for a in largest)
            raise SlipmodeError(
                f"amplitude: {kind} coefficients {what}, |a| = {amplitudes} kg^1/2 m; {advice}"
            )
