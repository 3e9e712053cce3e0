"""Laws of the slow flow: damping and frequency of one or two modes against their amplitudes.

With a_j(t) the complex amplitude of mode j in sensor units, y = Re sum_j a_j,

    a_j' = (-delta_j + i omega_j) a_j + q_j(a),
    delta_j = delta_0 + g (s_j / R_j)^p,    omega_j = omega_0 - h (s_j / R_j)^p,
    s_A^2 = |a|^2 + kappa_A |b|^2,          s_B^2 = |b|^2 + kappa_B |a|^2,
    q_A = q_1 conj(a) b,                    q_B = q_2 a^2        (near omega_B = 2 omega_A),

where R_j is a reference amplitude: g and h are what friction adds at that amplitude.

A constant friction force takes an equal part of the amplitude in each cycle, p = -1.

Laws of a joint that slips completely at large amplitudes are in `models/macro_slip.py`: friction
then adds g R_j / s_j to the damping rate, and the frequency tends to omega_0 - h.

Sliders of Iwan's distribution ~ phi^chi follow this law below macro-slip, with p = chi + 1. Then
Masing's rule ties h to g (see `masing_ratio`); other terms soften or stiffen elastically.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import numpy as np
import scipy

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Complexes, Flags, Floats, frozen, in_one_line
from slipmode.rom.identification.models.macro_slip import (
    NO_MACRO_SLIP,
    macro_slip_rates,
    slip_amplitude,
)

LawName = Literal["linear", "coulomb", "jenkins", "iwan", "power", "segalman", "quadratic"]

PER_MODE: Final = ("delta_0", "omega_0", "g", "h", "p", "kappa", "J", "k")
WIDTH = len(PER_MODE)
COUPLING: Final = ("Re q_1", "Im q_1", "Re q_2", "Im q_2")
LAWS: Final = get_args(LawName)
CONSTANT_FORCE = -1.0  # exponent p of a constant friction force
_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class LawForm:
    """Which terms a law has.

    Attributes
    ----------
    modes : int
        1 or 2.
    law : {"linear", "coulomb", "jenkins", "iwan", "power", "segalman", "quadratic"}
        Constant rates; a constant friction force; one Jenkins element; damping and frequency by
        joints alone; frequency that elastic terms shift too; a joint up to macro-slip and beyond;
        a power law and the quadratic coupling of two modes near a ratio of 1:2.
    cross : bool
        Whether the rates of a mode depend on the amplitude of the other mode.
    """

    modes: int
    law: LawName
    cross: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all parameters, free or not, in the order of their values."""
        modes = "AB"[: self.modes]
        own = tuple(f"{name}_{mode}" for mode in modes for name in PER_MODE)
        return own + (COUPLING if self.modes == 2 else ())

    @property
    def free(self) -> Flags:
        """Which parameters are fitted, (parameters,)."""
        nonlinear = self.law != "linear"
        shift = self.law not in ("linear", "coulomb", "iwan")
        exponent = self.law not in ("linear", "coulomb", "jenkins")
        own = [True, True, nonlinear, shift, exponent, nonlinear and self.cross]
        own += [self.law == "segalman", False]
        coupling = [self.law == "quadratic"] * 4 if self.modes == 2 else []
        return np.array(own * self.modes + coupling)

    @property
    def kind(self) -> str:
        """Meaning of g, h and p: laws of one kind have comparable parameters."""
        joint = self.law in ("jenkins", "segalman")
        return "macro-slip" if joint else "coulomb" if self.law == "coulomb" else "power"

    def without_others(self, values: Floats) -> Floats:
        """Return values (parameters,) in which terms that the law does not have are zero.

        If the law has another exponent, damping is kept at R and R / 2.
        """
        made = np.where(self.free, values, 0.0)
        for k in range(0, WIDTH * self.modes, WIDTH):
            delta_0, _, g, _, p = values[k : k + 5]
            made[k + 4] = p
            if self.kind == "macro-slip":
                made[k + 6] = values[k + 6] if self.law == "segalman" else 1.0
                made[k + 7] = values[k + 7]
                continue
            made[k + 6] = NO_MACRO_SLIP
            if (self.law == "coulomb") != (p == CONSTANT_FORCE):
                made[k + 4] = CONSTANT_FORCE if self.law == "coulomb" else 1.0
                made[k + 2] = g * (1.0 - 0.5**p) / (1.0 - 0.5 ** made[k + 4])
                made[k] = delta_0 + g - made[k + 2]
        return self.limited(made)

    def limited(self, values: Floats) -> Floats:
        """Return values (parameters,) within their limits, with h that follow from the others.

        Exponents are 0.1 to 6, of Segalman's law at most 2. A friction force does not drive the
        vibration.
        """
        made = values.copy()
        for k in range(0, WIDTH * self.modes, WIDTH):
            if self.law == "coulomb":
                made[k + 2] = max(made[k + 2], 0.0)
            elif self.kind == "macro-slip":
                made[k + 2] = max(made[k + 2], 0.0)
                made[k + 3] = np.clip(made[k + 3], 1e-6 * made[k + 1], 0.9 * made[k + 1])
                made[k + 4] = np.clip(made[k + 4], 0.1, 2.0)
                made[k + 6] = np.clip(made[k + 6], 0.0, 1.0)
            elif self.law != "linear":
                made[k + 4] = np.clip(made[k + 4], 0.1, 6.0)
        return self.tied(made)

    def tied(self, values: Floats) -> Floats:
        """Return values (parameters, ...) whose h follow from the others, if the law ties them."""
        if self.law != "iwan":
            return values
        made = values.copy()
        for k in range(0, WIDTH * self.modes, WIDTH):
            made[k + 3] = masing_ratio(values[k + 4]) * values[k + 2]
        return made

    def __str__(self) -> str:
        return self.law + (" with cross effects" if self.cross else "")


def allowed_forms(law: str, cross: Any, modes: int) -> list[LawForm]:
    """Return the laws that are allowed, each with the terms of those before it or more."""
    if law not in ("auto", *LAWS):
        raise SlipmodeError(f"law = {in_one_line(law)}: must be auto, {', '.join(LAWS)}")
    if cross not in ("auto", True, False):
        raise SlipmodeError(f"cross = {in_one_line(cross)}: must be 'auto', True or False")
    if modes == 1 and (cross is True or law == "quadratic"):
        raise SlipmodeError("bands: cross effects and quadratic coupling need two modes")
    if modes == 2 and law in ("jenkins", "segalman"):
        raise SlipmodeError(f"bands: law = {law} is a law of one mode; give one band")
    if law == "linear" and cross is True:
        raise SlipmodeError("cross: a linear law has no cross effects")
    found = []
    for name in LAWS if law == "auto" else [law]:
        if modes == 1 and name == "quadratic":
            continue
        if modes == 2 and name in ("jenkins", "segalman"):
            continue
        for crossed in (False, True):
            allowed = cross == "auto" or cross is crossed or name == "linear"
            if allowed and not (crossed and (name == "linear" or modes == 1)):
                found.append(LawForm(modes, name, crossed))  # type: ignore[arg-type]
    return found


def masing_ratio(p: Floats) -> Floats:
    """Return h / g of sliders with a density ~ phi^(p - 1) of their slip displacement phi.

    With c = phi / r, a slider of stiffness k under x = r cos(omega t) has the secant stiffness
    k (theta - sin(2 theta) / 2) / pi, cos(theta) = 1 - 2 c, and the loss 4 k c (1 - c) / pi
    (Masing's rule). Integrals over c^(p - 1) give h ~ 8 B(p + 3/2, 3/2) / pi and
    g ~ 4 p / (pi (p + 1) (p + 2)), with the beta function B.
    """
    ratio: Floats = 2.0 * scipy.special.beta(p + 1.5, 1.5) * (p + 1.0) * (p + 2.0) / p
    return ratio


def parts(values: Floats, modes: int) -> tuple[Floats, Complexes]:
    """Return parameters of each mode (8, modes, ...), and q_1, q_2 (2, ...).

    `values` (parameters, ...) are in the order of `LawForm.names`.
    """
    own = values[: WIDTH * modes].reshape(modes, WIDTH, *values.shape[1:]).swapaxes(0, 1)
    q = values[WIDTH * modes :] if modes == 2 else np.zeros((4, *values.shape[1:]))
    return own, np.asarray(q[0::2] + 1j * q[1::2], complex)


def complex_rates(
    own: Floats, reference: Floats, fastest: float = np.inf
) -> Callable[[Floats], Complexes]:
    """Return the function of squares of amplitudes that returns -delta + i omega, (modes, ...).

    `own` (8, modes, ...) are the parameters of each mode, `reference` (modes, 1, ...) the
    reference amplitudes, and the squares are (modes, ...). A constant friction force damps at the
    rate `fastest` [1/s] at most: it acts like linear damping on smaller amplitudes.
    """
    delta_0, omega_0, g, h, p, kappa, J, _ = own
    linear, friction, half = 1j * omega_0 - delta_0, g + 1j * h, 0.5 * p
    crossed, slips = len(reference) == 2 and np.any(kappa), np.any(J >= 0.0)
    largest = fastest / np.maximum(np.abs(g), _TINY) if np.any(p < 0.0) else None
    scale = reference**-2.0

    def rates(square: Floats) -> Complexes:
        s2 = square + kappa * square[::-1] if crossed else square
        relative = np.maximum(s2 * scale, _TINY)
        power = np.exp(half * np.log(relative))
        if largest is not None:
            power = np.minimum(power, largest)
        found: Complexes = linear - friction * power
        if slips:
            with np.errstate(all="ignore"):  # columns of other laws are not used
                slipping = macro_slip_rates(own, np.sqrt(relative) * reference, reference)
            found = np.where(J >= 0.0, slipping, found)
        return found

    return rates


@frozen
class SlowLaw:
    """Hold an identified law of the slow flow.

    The rates are delta_j = delta_0 + g (s_j / R_j)^p and omega_j = omega_0 - h (s_j / R_j)^p, see
    `rom.identify`.

    Attributes
    ----------
    form : LawForm
        Terms of the law.
    values : (parameters,) ndarray
        Values of `form.names`: delta_0, g [1/s], omega_0, h [rad/s], p, kappa [-] of each mode,
        and q_1, q_2 [1/s per sensor unit].
    reference : (modes,) ndarray
        Reference amplitudes R [sensor unit].
    """

    form: LawForm
    values: Floats
    reference: Floats

    @property
    def friction_shift(self) -> Floats:
        """Part of h due to friction with this damping by Masing's rule, (modes,) [rad/s].

        The remaining part of h is elastic.
        """
        own = parts(self.values, self.form.modes)[0]
        shift: Floats = masing_ratio(own[4]) * own[2]
        return shift

    @property
    def slip_amplitude(self) -> float:
        """Amplitude above which the joint slips completely, infinite without such a term."""
        if self.form.kind != "macro-slip":
            return np.inf
        return float(slip_amplitude(self.values, self.reference[0]))

    @property
    def coupling(self) -> Complexes:
        """Coefficients q_1, q_2 of the quadratic coupling, (2,) [1/s per sensor unit]."""
        return parts(self.values, self.form.modes)[1]

    def damping_rates(self, *amplitudes: Floats) -> Floats:
        """Return the damping rates delta_j at given amplitudes.

        Parameters
        ----------
        *amplitudes : (...) ndarray
            Amplitudes |a|, and |b| of the second mode [sensor unit].

        Returns
        -------
        (modes, ...) ndarray
            Damping rates [1/s].
        """
        return -self._rates(amplitudes).real

    def frequencies(self, *amplitudes: Floats) -> Floats:
        """Return the frequencies omega_j at given amplitudes.

        Parameters
        ----------
        *amplitudes : (...) ndarray
            Amplitudes |a|, and |b| of the second mode [sensor unit].

        Returns
        -------
        (modes, ...) ndarray
            Frequencies [rad/s].
        """
        return self._rates(amplitudes).imag

    def logarithmic_rates(self, a: Complexes) -> Complexes:
        """Return the logarithmic rates a_j' / a_j of the complex amplitudes.

        Parameters
        ----------
        a : (modes,) complex ndarray
            Amplitudes [sensor unit]. The quadratic coupling is neglected if a mode is at rest.

        Returns
        -------
        (modes,) complex ndarray
            -delta_j + i omega_j + q_j / a_j [1/s].
        """
        rates = self._rates(tuple(np.abs(a)))
        if len(a) == 2 and np.all(a != 0.0):
            q1, q2 = self.coupling
            rates = rates + np.array([q1 * a[0].conj() * a[1] / a[0], q2 * a[0] ** 2 / a[1]])
        return rates

    def _rates(self, amplitudes: Sequence[Floats]) -> Complexes:
        square = np.stack(np.broadcast_arrays(*np.abs(amplitudes))) ** 2
        extra = (1,) * (square.ndim - 1)
        own = parts(self.values, self.form.modes)[0].reshape(WIDTH, -1, *extra)
        return complex_rates(own, self.reference.reshape(-1, *extra))(square)
