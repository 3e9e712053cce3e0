"""The forced slow flow as a curve: its Jacobian, and where its steady states are."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.slow.branches.forced import ForcedSlowFlow

pytestmark = pytest.mark.quick

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


@pytest.mark.parametrize("vary", LINES)
def test_the_jacobian_is_the_derivative(model, vary):
    """Of every unknown and of what is varied; differences are 1e-8 off."""
    problem = ForcedSlowFlow.of(model, FREQUENCY, FORCE, (0.3, 0.0), vary, LINES[vary])
    z = np.array([0.31, -0.22, 0.18, 0.35, 0.4])
    _, J = rates_at(problem, z)
    for column, step in enumerate(1e-6 * np.eye(z.size)):
        ahead, behind = (rates_at(problem, z + sign * step)[0] for sign in (1, -1))
        assert J[:, column] == pytest.approx((ahead - behind) / 2e-6, abs=1e-7 * np.abs(J).max())


@pytest.mark.parametrize("vary", LINES)
def test_the_rates_are_those_of_a_steady_state(model, vary):
    """Which is 0 where `steady` finds one, and is among the solutions."""
    problem = ForcedSlowFlow.of(model, FREQUENCY, FORCE, (0.3, 0.0), vary, LINES[vary])
    part = 0.6
    value = np.array(LINES[vary][0]) + part * np.subtract(*LINES[vary][::-1])
    frequency, factor, limit = list(FREQUENCY), np.ones(2), 1.0
    if vary == "frequency":
        frequency = value
    elif vary == "frequency_A":
        frequency[0] = value
    elif vary == "limit":
        limit = value
    else:
        factor["AB".index(vary[-1]) if vary[-1] in "AB" else slice(None)] = value
    force = [
        {dof: size * by / limit for dof, size in one.items()}
        for one, by in zip(FORCE, factor, strict=True)
    ]
    a = rom.steady(model, frequency, force, (0.3, 0.0))
    z = np.append(a.view(float) / problem.scale, part)
    F, _ = rates_at(problem, z)
    assert np.abs(F).max() <= 1e-9
    found = problem.solutions(6)
    assert np.abs(found - z).max(axis=1).min() <= 1e-8
    assert problem.amplitude(z[np.newaxis])[0] == pytest.approx(limit * a)


def test_beside_what_has_left_the_table_the_others_go_on(model):
    """A step from outside is outside; orbits that escaped once ended a whole curve."""
    problem = ForcedSlowFlow.of(model, FREQUENCY, FORCE, (0.0, 0.0), "force", (0.5, 1.0))
    y = np.array([[0.3, 0.1, 0.2, 0.2], [np.nan] * 4, [2.0, 0.0, 0.1, 0.0], [0.1, 0.3, 0.1, 0.0]])
    found = problem.held_at(np.array([0.2, 0.4, 0.6, 0.8]))(y)
    assert np.isfinite(found).all(axis=1).tolist() == [True, False, False, True]
