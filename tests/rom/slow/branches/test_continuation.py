"""A closed curve that is known is followed by continuation."""

import numpy as np
import pytest

from slipmode.rom import kernel
from slipmode.rom.slow.branches.continuation import branch_through

pytestmark = pytest.mark.quick


@kernel.CurveRates
def circle(_, z, F, J):
    """y^2 + (p - 1/2)^2 = 0.16: folds at p = 0.1 and 0.9."""
    y, p = z[0], z[1] - 0.5
    F[0], J[0], J[1] = y**2 + p**2 - 0.16, 2.0 * y, 2.0 * p
    return kernel.OK


@pytest.mark.oracle
def test_a_closed_curve_is_passed_once():
    branch = branch_through(kernel.Curve(1, 0.02, circle), np.array([0.4, 0.5]))
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
