"""Measured backbones as points with deviations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Floats, as_floats, frozen, in_one_line
from slipmode.rom.identification.contacts.table_check import TABLE_TOLERANCE
from slipmode.rom.identification.models.identified import IdentifiedBackbone
from slipmode.rom.identification.models.sensor_units import QUANTITIES, sensor_unit

# Curves of an identified law have few parameters; so many points of a curve describe it.
_POINTS = 30


@frozen
class Points:
    """Frequency and damping of a mode at measured amplitudes.

    Attributes
    ----------
    displacement : (points,) ndarray
        Amplitude of the sensor [m].
    values : (2, points) ndarray
        Frequency [rad/s] and damping ratio.
    deviation : (2, points) ndarray
        Standard deviations, with the error of friction tables.
    whitening : (2 points, 2 points) ndarray
        Matrix that makes errors relative to `deviation` independent, with a deviation of 1.
        Their covariance is the scatter between records and the identity.
    records : int
        Number of these records; 0 if the points are independent.
    steady : bool
        Whether the vibration is steady, not free.
    """

    displacement: Floats
    values: Floats
    deviation: Floats
    whitening: Floats
    records: int
    steady: bool

    @classmethod
    def of(cls, mode: Any, backbone: IdentifiedBackbone) -> Points:
        """Return the points of a backbone, checked."""
        if not isinstance(backbone, IdentifiedBackbone):
            raise SlipmodeError(
                f"backbones: must be {{mode: rom.IdentifiedBackbone}}, got {in_one_line(backbone)}"
            )
        key = f"backbones[{mode}]"
        amplitude, *curves = (
            as_floats(f"{key}.{name}", getattr(backbone, name))
            for name in (
                "amplitude",
                "frequency",
                "damping",
                "frequency_deviation",
                "damping_deviation",
            )
        )
        names = ("frequency", "damping", "frequency_deviation", "damping_deviation")
        for name, curve in zip(("amplitude", *names), (amplitude, *curves), strict=True):
            if curve.shape != (amplitude.size,) or not np.all(np.isfinite(curve) & (curve > 0.0)):
                more = (
                    "; identify at least three records, so that deviations are known"
                    if "deviation" in name
                    else ""
                )
                raise SlipmodeError(
                    f"{key}.{name}: must be {amplitude.size} finite numbers > 0{more}"
                )
        quantity, size = sensor_unit(backbone.unit)
        left_out = np.asarray(backbone.left_out, dtype=float)
        records = len(left_out)
        at = np.arange(amplitude.size)
        if records and amplitude.size > _POINTS:
            at = np.linspace(0, amplitude.size - 1, _POINTS).round().astype(int)
        values, deviation = np.array(curves[:2])[:, at], np.array(curves[2:])[:, at]
        displacement = amplitude[at] * size / values[0] ** QUANTITIES.index(quantity)
        # Fits compare with friction tables, which have this error relative to the damping.
        table_error = TABLE_TOLERANCE * values[1] * np.stack((values[0], np.ones(at.size)))
        deviation = np.hypot(deviation, table_error)
        whitening = np.eye(values.size)
        if records:
            changes = ((left_out - left_out.mean(axis=0))[..., at] / deviation).reshape(
                records, -1
            )
            covariance = (records - 1) / records * changes.T @ changes  # jackknife
            whitening = np.linalg.inv(np.linalg.cholesky(covariance + whitening))
        return cls(displacement, values, deviation, whitening, records, backbone.steady)

    def residuals(self, values: Floats) -> Floats:
        """Return values (..., 2, points) less the measured ones, (..., 2 points) independent."""
        off = (values - self.values) / self.deviation
        return np.asarray(off.reshape(*off.shape[:-2], -1) @ self.whitening.T)


def measured_points(backbones: Any) -> dict[int, Points]:
    """Return the points of each mode."""
    if not isinstance(backbones, Mapping) or not backbones:
        raise SlipmodeError(
            f"backbones: must be {{mode: rom.IdentifiedBackbone}}, got {in_one_line(backbones)}"
        )
    return {mode: Points.of(mode, each) for mode, each in backbones.items()}
