"""Force of macro-slip and stiffness ratio of a joint, from an identified law."""

from __future__ import annotations

import numpy as np

from slipmode.rom.identification.models.sensor_units import QUANTITIES
from slipmode.rom.identification.slow_laws import SlowLaw
from slipmode.rom.slow import parse_unit


def joint_parameters(law: SlowLaw, unit: str) -> dict[str, tuple[str, float, float]]:
    """Return values of `ratio_A` and `limit_A`, each after the parameter it depends on.

    `ratio_A` is the stiffness of the mode in slip relative to stick [-], `limit_A` is F_S per
    modal mass [N/kg], for a sensor of displacement, velocity or acceleration. The last number is
    the derivative by the parameter, h or g. omega_0 and R are far more certain.
    """
    omega_0, g, h = law.values[1:4].tolist()
    slip = omega_0 - h
    made = {"ratio_A": ("h_A", (slip / omega_0) ** 2, -2.0 * slip / omega_0**2)}
    known = parse_unit(unit)
    if known is not None and known.quantity in QUANTITIES:
        # In slip the displacement is its k-th derivative over the k-th power of this frequency.
        size = float(law.reference[0]) * known.size / slip ** QUANTITIES.index(known.quantity)
        factor = 0.5 * np.pi * slip * size
        made["limit_A"] = "g_A", factor * g, factor
    return made
