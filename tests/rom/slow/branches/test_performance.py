"""Performance curves: the peak of a response curve for each friction limit."""

import numpy as np
import pytest
from oracles.harmonic_balance import balance
from oracles.system import System, jenkins

from slipmode import rom
from slipmode.rom import SlipmodeError

FORCE = {0: 0.15}


@pytest.fixture(scope="module")
def model():
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,))
    return rom.tabulate(reduced, rom.Coulomb(2.0), (12.0,), 1e-3)


@pytest.mark.oracle
def test_a_jenkins_damper_on_one_mass_has_its_closed_form():
    """At phase resonance F = c Omega X + 4 L / pi (1 - L / (k_t X)), a quadratic in X.

    Without c the best limit is L = pi F / 2 with X = pi F / k_t. Harmonics of the mass are of
    order k_t / 8.
    """
    c, k_t, F, L = 0.004, 0.1, 0.06, 0.02
    structure = rom.Structure(np.eye(1), np.eye(1), c, contact=(0,))
    law = rom.Jenkins(L, k_t)
    reduced = rom.reduce(structure, (0,), law=law)
    model = rom.tabulate(reduced, law, (2.0,), 1e-3, detuning=True, warned=False)
    curve = rom.performance_curve(model, {0: F})
    limit, viscous = curve.limit * L, c * curve.frequency
    b = 4.0 * limit / np.pi - F
    X = (np.sqrt(b**2 + 16.0 * viscous * limit**2 / (np.pi * k_t)) - b) / (2.0 * viscous)
    slips = 1.1 * limit / k_t < X
    assert slips.sum() > 100
    found = 2.0 * curve.peak
    assert np.abs(found / X - 1.0)[slips].max() <= 0.01
    factor, peak = curve.optimum
    assert 2.0 * peak == pytest.approx(X[slips].min(), rel=0.01)
    # The dampers take the more, the higher the limit.
    assert 0.8 * np.pi * F / 2.0 <= factor * L <= np.pi * F / 2.0
    assert 2.0 * peak <= np.pi * F / k_t


def forced_at_its_contact(K, k_t):
    """Unit masses with one contact, the force on it: curve, optimum, harmonics by balance."""
    C, W, F, limit = 0.01 * K, np.eye(len(K))[:, [1]], 0.02, 0.02
    law, force = rom.Jenkins(limit, k_t), {1: F}
    structure = rom.Structure(np.eye(len(K)), K, C, contact=W)
    reduced = rom.reduce(structure, (0,), law=law, force_patterns=(force,))
    model = rom.tabulate(reduced, law, (0.8,), 1e-3, detuning=True, warned=False)
    curve = rom.performance_curve(model, force)

    def exact(k, Omega):
        system = System(np.eye(len(K)), C, K, W, [jenkins(curve.limit[k] * limit, k_t)])
        return balance(system, Omega, F * W[:, 0] + 0j)[1]

    return curve, np.flatnonzero(curve.limit == curve.optimum[0])[0], exact


@pytest.mark.oracle
def test_a_force_on_the_contact_itself_has_the_peaks_of_harmonic_balance():
    K = 2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    curve, at, exact = forced_at_its_contact(K, 0.15)
    off = np.array([-0.005, 0.0, 0.005])
    for k in (at - 20, at, at + 20):
        size = [
            abs(0.5 * curve.mode_shape @ exact(k, w)) for w in curve.frequency[k] * (1.0 + off)
        ]
        a, b, c = np.polyfit(off, 1.0 / np.square(size), 2)  # 1 / |a|^2 of a mode is a parabola
        assert curve.peak[k] == pytest.approx((c - 0.25 * b**2 / a) ** -0.5, rel=5e-3)


@pytest.mark.oracle
def test_a_contact_that_the_mode_hardly_moves_has_the_displacement_of_harmonic_balance():
    """The response of the other mode to the force leads the slow mode by a quarter turn."""
    curve, at, exact = forced_at_its_contact(np.array([[1.2, -0.2], [-0.2, 1.6]]), 0.3)
    found = [curve.displacement(dof)[at] for dof in (0, 1)]
    np.testing.assert_allclose(found, np.abs(exact(at, curve.frequency[at])), rtol=2e-3)


@pytest.mark.oracle
def test_contacts_that_stick_leave_the_peak_to_structural_damping(model):
    curve = rom.performance_curve(model, FORCE)
    F = abs(model.reduced.modal_force(0, FORCE))
    assert curve.peak[-1] == pytest.approx(F / (4.0 * 0.005), rel=1e-3)
    assert curve.limit[-1] > 10.0


@pytest.mark.oracle
@pytest.mark.quick
def test_between_slip_and_stick_there_is_a_best_limit(model):
    curve = rom.performance_curve(model, FORCE)
    limit, peak = curve.optimum
    assert peak < 0.65 * min(curve.peak[0], curve.peak[-1])
    low, high = curve.within(1.1)
    assert low < limit < high
    inside = (curve.limit >= low) & (curve.limit <= high)
    assert np.all(curve.peak[inside] <= 1.1 * peak)
    assert np.all(curve.peak[~inside] > 1.1 * peak)
    twice = rom.performance_curve(model, {0: 0.3})
    assert twice.optimum == pytest.approx((2.0 * limit, 2.0 * peak))
    assert twice.displacement(0) == pytest.approx(2.0 * curve.displacement(0))


def test_what_has_no_such_curve_is_named(model):
    smooth = rom.tabulate(model.reduced, rom.Tanh(2.0, 0.02), (4.0,), 1e-2)
    with pytest.raises(SlipmodeError, match="law: the motion must scale"):
        rom.performance_curve(smooth, FORCE)
    with pytest.raises(SlipmodeError, match="mode: must be 0 to 0, got 1"):
        rom.performance_curve(model, FORCE, mode=1)
    with pytest.raises(SlipmodeError, match="force: does not excite mode A"):
        rom.performance_curve(model, {0: 0.0})
