"""Continuation along curves that are known; the Jacobian of the forced slow flow."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.slow.branches.continuation import branch_through
from slipmode.rom.slow.branches.forced import ForcedSlowFlow

pytestmark = pytest.mark.quick


def curve_of(rates, unknowns, largest_step):
    """F(y, p) = 0 of a function in Python; it ends where that is NaN."""

    @kernel.CurveRates
    def called(_, z, F, J):
        values, jacobian = rates(np.ctypeslib.as_array(z, (unknowns + 1,)))
        np.ctypeslib.as_array(F, (unknowns,))[:] = values
        np.ctypeslib.as_array(J, (unknowns, unknowns + 1))[:] = jacobian
        return kernel.OK if np.isfinite(values).all() else kernel.OUTSIDE_TABLE

    return kernel.Curve(unknowns, largest_step, called)


def circle(z):
    """y^2 + (p - 1/2)^2 = 0.16: folds at p = 0.1 and 0.9."""
    y, p = z[0], z[1] - 0.5
    return np.array([y**2 + p**2 - 0.16]), np.array([[2.0 * y, 2.0 * p]])


@pytest.mark.oracle
def test_a_closed_curve_is_passed_once():
    branch = branch_through(curve_of(circle, 1, 0.02), np.array([0.4, 0.5]))
    z = branch.points.z
    assert branch.closed
    assert np.hypot(z[:, 0], z[:, 1] - 0.5) == pytest.approx(0.4, abs=1e-12)
    np.testing.assert_array_equal(
        branch.points.pass_by(np.array([[-0.4, 0.5], [0.3, 0.5]])), [True, False]
    )
    length = np.linalg.norm(np.diff(z, axis=0), axis=1).sum()
    assert length == pytest.approx(0.8 * np.pi, rel=0.02)
    assert sorted(at[-1] for _, at in branch.special) == pytest.approx([0.1, 0.9])
    assert {kind for kind, _ in branch.special} == {"fold"}


@pytest.mark.oracle
def test_an_open_curve_ends_at_the_ends_of_the_parameter_and_changes_stability_at_folds():
    """p = 1/2 + y - 8 y^3, folds at y = +-1/sqrt(24)."""

    def rates(z):
        y, p = z
        return np.array([p - 0.5 - y + 8.0 * y**3]), np.array([[24.0 * y**2 - 1.0, 1.0]])

    branch = branch_through(curve_of(rates, 1, 0.02), np.array([0.0, 0.5]))
    assert not branch.closed
    assert sorted(branch.points.z[[0, -1], -1]) == [0.0, 1.0]
    at = [z[0] for _, z in branch.special]
    assert sorted(at) == pytest.approx([-(24**-0.5), 24**-0.5], abs=1e-8)
    grows = 24.0 * branch.points.z[:, 0] ** 2 > 1.0
    np.testing.assert_array_equal(branch.points.unstable == 1, grows)


@pytest.mark.oracle
def test_a_hopf_point_is_where_a_pair_passes_zero():
    """A focus that loses its stability at p = 0.3, at a point that moves with p."""

    def rates(z):
        x, y, p = z
        J = np.array([[p - 0.3, -2.0], [2.0, p - 0.3]])
        d = np.array([x - 0.2 * p, y])
        return J @ d, np.column_stack((J, d - 0.2 * J[:, 0]))

    branch = branch_through(curve_of(rates, 2, 0.02), np.zeros(3))
    ((kind, z),) = branch.special
    assert kind == "Hopf"
    assert z == pytest.approx([0.06, 0.0, 0.3], abs=1e-8)


FORCE = ({0: 0.15}, {1: 0.25})
FREQUENCY = (0.98, 1.65)
LINES = {
    "frequency_A": (0.94, 1.02),
    "frequency": ((0.95, 1.6), (1.02, 1.72)),
    "force": (0.0, 1.0),
    "force_B": (0.1, 1.2),
    "limit": (0.95, 3.0),
}


@pytest.fixture(scope="module")
def model():
    return rom.tabulate(rom.reduce(rom.two_mass(beta=0.01)), rom.Coulomb(2.0), (4.0, 2.0), 2e-3)


def rates_at(problem, z):
    """F (k,) and its Jacobian (k, k + 1), of the core."""
    z, F, J = np.array(z), np.empty(z.size - 1), np.empty((z.size - 1, z.size))
    arrays = (np.ctypeslib.as_ctypes(each.ravel()) for each in (z, F, J))
    assert problem.curve.rates(problem.curve.of, *arrays) == kernel.OK
    return F, J


@pytest.mark.oracle
@pytest.mark.parametrize("vary", LINES)
def test_the_jacobian_is_the_derivative(model, vary):
    """Of every unknown and of what is varied; differences are 1e-8 off."""
    problem = ForcedSlowFlow.of(model, FREQUENCY, FORCE, (0.3, 0.0), vary, LINES[vary])
    z = np.array([0.31, -0.22, 0.18, 0.35, 0.4])
    _, J = rates_at(problem, z)
    for column, step in enumerate(1e-6 * np.eye(z.size)):
        ahead, behind = (rates_at(problem, z + sign * step)[0] for sign in (1, -1))
        assert J[:, column] == pytest.approx((ahead - behind) / 2e-6, abs=1e-7 * np.abs(J).max())
