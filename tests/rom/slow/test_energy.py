"""Power in steady motion: what goes in is what dampers and friction take."""

import numpy as np
import pytest
from oracles.closed_forms import jenkins_dissipation

from slipmode import rom

pytestmark = pytest.mark.oracle


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "force"), [(0.5, 0.1), (0.3, 0.1)])
def test_a_jenkins_contact_dissipates_its_loop(limit, force):
    """Masing's loop 4 L (X - L / k_t) a cycle, by the displacements of the structure alone."""
    law = rom.Jenkins(limit, 20.0)
    M, K = np.diag([1.0, 0.01]), np.array([[1.0, -1.0], [-1.0, 1.5]])
    C = np.array([[0.02, -0.005], [-0.005, 0.01]])
    structure = rom.Structure(M, K, C, contact=np.array([[0.0], [1.0]]))
    reduced = rom.reduce(structure, (0,), law=law, smallest_response=0.0)
    Omega = 0.97 * float(reduced.frequency[0])
    state = rom.steady_state(reduced, law, [Omega], [{0: force}], 1e-4)
    order = np.array([n for n, _ in state.orders])
    x = state.displacement_harmonics()  # of 2 Re(c exp(i n Omega t))
    mean = order == 0
    v = 1j * Omega * order[:, np.newaxis] * x
    dampers = 2.0 * np.einsum("ni,ij,nj->", v.conj(), C, v).real
    angle = np.linspace(0.0, 2.0 * np.pi, 20_000, endpoint=False)
    waves = np.where(mean, 1.0, 2.0) * np.exp(1j * np.outer(angle, order))
    moved = (waves @ x[:, 1]).real
    X = 0.5 * (moved.max() - moved.min())
    friction = jenkins_dissipation(X, limit, 20.0) * Omega / (2.0 * np.pi)
    given = force * (1j * Omega * x[order == 1, 0]).real.item()
    stated = float(state.error[0] / abs(state.amplitude[0]))
    assert friction > 0.05 * given
    # Higher harmonics that are left out make up the loop too.
    assert given == pytest.approx(dampers + friction, rel=2.0 * stated + 1e-3)
