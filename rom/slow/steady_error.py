"""Errors of steady amplitudes due to errors of friction, measured by contact problems.

An error of friction changes an amplitude in proportion to the share that friction has in the force
balance. Away from resonance this share is small, and where contacts stick it is 0.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import Finding
from slipmode.rom.reduction.reduced import coupling_factor
from slipmode.rom.slow.answer_error import TableError, off_carrier_findings
from slipmode.rom.slow.slow_flow import ForcedFlow

# Estimate of the error by forcing off the carriers, relative to the tolerance, above which the
# error is measured. The estimate scales trials of the table at other amplitudes.
_WORTH_MEASURING = 0.1


def amplitude_error(flow: ForcedFlow, amplitude: Complexes, friction: Complexes) -> Floats:
    """Return |delta a_j| / |a_j| by an error of S_j at steady states, (points, modes).

    `amplitude` and `friction` are (points, modes); 0 for a mode at rest.
    """
    size = np.abs(amplitude)
    _, jacobian = flow.rate_and_jacobian(amplitude)
    factor = coupling_factor(flow.model.reduced, flow.frequency)
    turned = np.exp(1j * np.angle(flow.effective(amplitude)))
    change = np.ascontiguousarray(factor * turned * friction / flow.balance(amplitude).mass)
    moved = np.linalg.pinv(jacobian) @ change.view(float)[..., np.newaxis]
    moved = np.abs(np.ascontiguousarray(moved[..., 0]).view(complex))
    return np.asarray(np.divide(moved, size, out=np.zeros_like(size), where=size > 0.0))


def error_at_point(
    flow: ForcedFlow, amplitude: Complexes, point: int, friction: Complexes
) -> float:
    """Return the largest relative error of the amplitudes at a point by an error of S_j (modes,).

    The error of S_j is relative to the scale of the friction limits there.
    """
    at = flow.with_inputs(flow.inputs[[point]])
    scaled: Complexes = at.inputs["limit_scale"][:, np.newaxis] * friction
    return float(amplitude_error(at, amplitude[[point]], scaled).max())


def detuning_findings(flow: ForcedFlow, amplitude: Complexes) -> list[Finding]:
    """Report steady states (points, modes) whose error by forcing off the carriers is large."""
    model, forced = flow.model, (flow.force != 0.0).any(axis=0)
    stated, apart = model.accuracy, flow.frequency / model.reduced.carrier - 1.0
    if stated.detuning is None:
        return model.detuning_findings(flow.frequency, forced)
    apart = np.where(forced, apart, 0.0)
    effective = np.abs(flow.effective(amplitude))
    part = stated.detuning_at(np.abs(apart).max(axis=1), model.table.detuning is not None)
    friction = part[:, np.newaxis] * model.error_scale(effective)
    estimate = amplitude_error(flow, amplitude, friction.astype(complex)).max(axis=1)
    if np.all(estimate <= _WORTH_MEASURING * stated.tolerance):
        return []
    scale = np.ones(len(amplitude))
    found = TableError.of(model, effective, flow.frequency, scale, estimate)
    at = flow.with_inputs(flow.inputs[found.measured])
    error = amplitude_error(at, amplitude[found.measured], found.off_carriers)
    largest = float(np.nan_to_num(error, nan=np.inf).max(initial=0.0))
    return off_carrier_findings(stated.tolerance, largest, apart, "the amplitudes")
