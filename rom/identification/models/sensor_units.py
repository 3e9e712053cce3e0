"""Sensor units as modal amplitudes."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.rom.slow import parse_unit

QUANTITIES: tuple[str, ...] = (
    "displacement",
    "velocity",
    "acceleration",
)  # by the number of time derivatives


def sensor_unit(unit: str) -> tuple[str, float]:
    """Return the quantity of a unit, and the unit in m, m/s or m/s^2; refuse other units."""
    found = parse_unit(unit)
    if found is None or found.quantity not in QUANTITIES:
        raise SlipmodeError(
            f"unit = {unit!r}: must be m, m/s, m/s^2 (also with prefix m, u or n) or g"
        )
    return found.quantity, found.size


def derivative(unit: str) -> int:
    """Return the number of time derivatives of the displacement, 0 for other units."""
    found = parse_unit(unit)
    if found is None or found.quantity not in QUANTITIES:
        return 0
    return QUANTITIES.index(found.quantity)


def shape_at_sensor(modes: int, modal_mass: Any, mode_shape: Any) -> Floats:
    """Return the mass-normalised modes at the reference channel, (modes,) [kg^-1/2]."""
    if modal_mass is not None and mode_shape is not None:
        raise SlipmodeError("modal_mass: must be left out if mode_shape is given")
    name = "modal_mass" if mode_shape is None else "mode_shape"
    given = as_floats(name, 1.0 if modal_mass is None else modal_mass)
    if mode_shape is not None:
        given = as_floats(name, mode_shape)
    elif given.ndim == 0:
        given = np.full(modes, given)
    allowed = np.isfinite(given) & ((given != 0.0) if name == "mode_shape" else (given > 0.0))
    if given.shape != (modes,) or not allowed.all():
        what = "other than 0 [kg^-1/2]" if name == "mode_shape" else "> 0 [kg]"
        raise SlipmodeError(
            f"{name} = {in_one_line(given.tolist())}: must be one number {what} for each of the "
            f"{modes} modes"
        )
    return given if name == "mode_shape" else 1.0 / np.sqrt(given)


def sensor_factors(law: SlowLaw, unit: str, shape: Floats) -> Complexes:
    """Return the sensor amplitude of a modal amplitude of 1 kg^1/2 m, (modes,) complex.

    It is 2 phi (i omega)^k for the k-th time derivative of the displacement, at the frequency
    omega of small amplitudes. A frequency that shifts by 1 % changes velocities by 1 %: the shifts
    of a measured double beam are 0.3 and 0.6 %.
    """
    quantity, size = sensor_unit(unit)
    omega = law.frequencies(*np.zeros((law.form.modes, 1)))[:, 0]
    return np.asarray(2.0 * shape * (1j * omega) ** QUANTITIES.index(quantity) / size)
