"""Displacements of DOFs in curves and peaks, with the share of the contacts."""

import numpy as np
import pytest
from beside_oracle import system_of
from oracles.harmonic_balance import balance

from slipmode import rom

N = 8
FORCE = {N - 1: 0.1}
LAW = rom.Jenkins(limit=0.05, stiffness=60.0)


@pytest.fixture(scope="module")
def chain():
    """A clamped chain of 8 masses with Jenkins contacts on two of them, and its table."""
    stiffness = 400.0 * (2.0 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1))
    stiffness[-1, -1] = 400.0
    structure = rom.Structure(0.05 * np.eye(N), stiffness, 5e-4, contact=(3, 6))
    reduced = rom.reduce(structure, (0,), law=LAW, force_patterns=(FORCE,))
    return system_of(structure, LAW), rom.tabulate(reduced, LAW, (0.02,), 1e-3)


def largest_difference(found, exact):
    return np.abs(found - exact).max() / exact.max()


@pytest.mark.oracle
def test_dofs_of_a_response_curve_move_as_in_harmonic_balance(chain):
    """By the shape of the mode alone they would be 30 % off."""
    system, model = chain
    Omega = 0.985 * float(model.reduced.frequency[0])
    span = (0.995 * Omega, 1.005 * Omega)
    curve = rom.response_curve(model, (Omega,), (FORCE,), "frequency_A", span)
    F = np.zeros(N, dtype=complex)
    F[N - 1] = 0.1
    for k in (0, curve.parameter.size // 2, -1):
        exact = np.abs(balance(system, float(curve.parameter[k]), F)[1])
        found = np.array([curve.displacement(dof)[k, 0] for dof in range(N)])
        stated = curve.error[k, 0] / abs(curve.amplitude[k, 0])
        assert largest_difference(found, exact) <= stated + 1e-3
        shape = 2.0 * np.abs(model.reduced.mode_shapes[:, 0] * curve.amplitude[k, 0])
        assert largest_difference(shape, exact) > 0.05


@pytest.mark.slow
@pytest.mark.oracle
def test_a_peak_moves_dofs_as_in_harmonic_balance(chain):
    system, model = chain
    peaks = rom.performance_curve(model, FORCE)
    k = int(peaks.peak.argmin())
    F = np.zeros(N, dtype=complex)
    F[N - 1] = 0.1 / peaks.limit[k]
    exact = peaks.limit[k] * np.abs(balance(system, float(peaks.frequency[k]), F)[1])
    found = np.array([peaks.displacement(dof)[k] for dof in range(N)])
    stated = peaks.error[k] / peaks.peak[k]
    assert largest_difference(found, exact) <= stated + 4e-3


@pytest.mark.oracle
def test_scaled_limits_scale_displacements(chain):
    """Under s times the force and limits everything moves s times as far."""
    _, model = chain
    Omega = (0.985 * model.reduced.frequency[0],)
    small = rom.response_curve(model, Omega, (FORCE,), "force", (0.5, 1.0))
    scaled = rom.response_curve(model, Omega, ({N - 1: 0.2},), "limit", (1.0, 2.0))
    assert scaled.displacement(7)[-1] == pytest.approx(2.0 * small.displacement(7)[-1], rel=1e-4)
    with pytest.raises(rom.SlipmodeError, match="dof: must be 0 to 7, got 8"):
        scaled.displacement(N)
