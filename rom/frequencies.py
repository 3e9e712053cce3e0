"""Limits of the frequencies of modes and forcing: refused, or reported as implausible."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Literal

import numpy as np

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.representable import round_down, round_up

FrequencyUnit = Literal["rad/s", "Hz"]
RPM = pi / 30.0  # revolutions a minute [rad/s]
PER_UNIT: dict[FrequencyUnit, float] = {"rad/s": 1.0, "Hz": 2.0 * pi}  # [rad/s]

# Allowed forcing frequencies relative to the natural frequency. A free vibration of mode j beats
# against the carrier with x = omega^2 / Omega^2 - 1; to second order its growth rate is
# gamma (3 x^2 / 16 - 1 / 2), > 0 for Omega < 0.617 omega.
LOWEST_CARRIER, HIGHEST_CARRIER = 0.62, 10.0
# Ratio of forcing and natural frequency, or its inverse, beyond which forcing is not resonant.
FARTHEST_FORCING = 1.5
_NEAR_TWO_PI = 0.25  # relative distance of a ratio of frequencies from 2 pi that suggests a unit
_LOWEST_MODE, _HIGHEST_MODE = 1e-3, 1e6  # natural frequencies of plausible structures [Hz]


def carrier_range(omega: float) -> tuple[float, float]:
    """Return the range of forcing frequencies that a mode at omega can follow [rad/s]."""
    return LOWEST_CARRIER * omega, HIGHEST_CARRIER * omega


def spin_of(spin: Floats | None, mode: int) -> Floats | None:
    """Return the row (4,) of `Reduced.spin` for a mode, or None."""
    return None if spin is None else spin[mode]


def can_carry(omega: Floats | float, frequency: Floats) -> Flags:
    """Return whether forcing frequencies [rad/s] lie in `carrier_range`."""
    return np.asarray(
        (frequency >= LOWEST_CARRIER * omega) & (frequency <= HIGHEST_CARRIER * omega)
    )


def is_near(omega: Floats | float, frequency: Floats) -> Flags:
    """Return whether forcing frequencies [rad/s] are within `FARTHEST_FORCING` of omega."""
    return np.asarray(
        (frequency * FARTHEST_FORCING >= omega) & (frequency <= FARTHEST_FORCING * omega)
    )


def carrier_refusal(
    key: str,
    mode: str,
    omega: float,
    frequency: float,
    unit: FrequencyUnit = "rad/s",
    spin: Floats | None = None,
) -> str:
    """Return why a forcing frequency [rad/s] is refused, in the user's unit; "" if it is not.

    `spin` is the row of the mode in `Reduced.spin`, if its frequency follows a rotor speed.
    """
    low, high = carrier_range(omega) if spin is None else spin[2:].tolist()
    if low <= frequency <= high:
        return ""
    per_unit = PER_UNIT[unit]
    if spin is not None:
        return (
            f"{key}: must be {low / per_unit:.5g} to {high / per_unit:.5g} {unit}, engine order "
            f"{spin[1]:g} at {low / spin[1] / RPM:.5g} to {high / spin[1] / RPM:.5g} rpm, the "
            f"rotor speeds of rom.reduce_rotating; got {frequency / per_unit:g}"
        )
    return (
        f"{key}: must be {round_up(low / per_unit, 3):g} to {round_down(high / per_unit, 3):g} "
        f"{unit}, because mode {mode} resonates at {omega / per_unit:.3g} {unit}; "
        f"got {frequency / per_unit:g}{_unit_hint(omega, frequency, unit)}"
    )


def check_carrier(
    key: str,
    mode: str,
    omega: float,
    frequencies: Floats,
    unit: FrequencyUnit = "rad/s",
    spin: Floats | None = None,
) -> None:
    """Refuse forcing frequencies [rad/s] that the slow flow of a mode cannot follow."""
    for value in (frequencies.min(), frequencies.max()):
        if refusal := carrier_refusal(key, mode, omega, float(value), unit, spin):
            raise SlipmodeError(refusal)


def check_table_carriers(omega: Floats, carrier: Floats) -> None:
    """Refuse carriers (modes,) of a contact problem [rad/s] that no slow flow can follow."""
    for mode, own, given in zip("AB", omega.tolist(), carrier, strict=False):
        check_carrier("carrier", mode, own, given)


def carrier_findings(
    key: str, names: Sequence[str], omega: Floats, frequency: Floats, unit: FrequencyUnit = "rad/s"
) -> list[Finding]:
    """Report forcing frequencies (..., modes) [rad/s] far from the natural frequencies (modes,).

    The farthest of each mode is reported, in the user's unit; `key` is the user's key, with {} in
    place of the name of the mode.
    """
    found = []
    for j, (name, own) in enumerate(zip(names, omega.tolist(), strict=False)):
        values = frequency[..., j].ravel()
        if is_near(own, values).all():
            continue
        farthest = float(values[np.argmax(np.abs(np.log(values / own)))])
        hint = _unit_hint(own, farthest, unit)
        reason = (
            f"{farthest / PER_UNIT[unit]:.4g} {unit} is {farthest / own:.3g} times the natural "
            f"frequency of {own / PER_UNIT[unit]:.4g} {unit}, outside {1 / FARTHEST_FORCING:.2g} "
            f"to {FARTHEST_FORCING:g} times"
            f"{hint or '; retain the mode that is nearest, or compare with slipmode validate'}"
        )
        found.append(Finding(key.format(name), f"is far from mode {name}", reason, "warning"))
    return found


def _unit_hint(omega: float, frequency: float, unit: FrequencyUnit) -> str:
    """Return advice if the distance is a factor of about 2 pi, else ""."""
    given = frequency / PER_UNIT[unit]
    factor, other = (2.0 * pi, "Hz") if unit == "rad/s" else (0.5 / pi, "rad/s")
    if abs(factor * frequency / omega - 1.0) < _NEAR_TWO_PI:
        return f"; if that is in {other}, give {factor * given:.4g} {unit}"
    if abs(frequency / (factor * omega) - 1.0) < _NEAR_TWO_PI:
        return f"; if a factor 2 pi was applied twice, give {given / factor:.4g} {unit}"
    return ""


def mode_frequency_findings(names: Sequence[str], omega: Floats) -> list[Finding]:
    """Report natural frequencies (modes,) [rad/s] that no structure has."""
    found = []
    for name, hertz in zip(names, (omega / (2.0 * pi)).tolist(), strict=False):
        if not _LOWEST_MODE <= hertz <= _HIGHEST_MODE:
            reason = (
                f"{hertz:.3g} Hz is outside {_LOWEST_MODE:g} to {_HIGHEST_MODE:g} Hz. Check "
                "whether mass and stiffness are swapped, or in units other than kg and N/m"
            )
            found.append(
                Finding(f"mode {name}", "has an implausible frequency", reason, "warning")
            )
    return found
