"""Hopeless computations end with one line that says what would help."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import SlipmodeError


@pytest.mark.slow
def test_a_hopeless_table_ends_by_default():
    """It took more than 20 minutes; the limit is counted, and reached after one to two."""
    K = 1e4 * (2.0 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1))
    law = rom.Iwan(force=5.0, stiffness=3e3, chi=-0.5, beta=0.5)
    structure = rom.Structure(mass=np.eye(6), stiffness=K, damping=2e-5, contact=[2, 4])
    reduced = rom.reduce(structure, modes=(0, 1), law=law)
    with pytest.raises(SlipmodeError, match=r"budget: the friction table takes more .*one mode"):
        rom.tabulate(reduced, law, (0.02, 0.01), 1e-3)


def test_a_steady_state_has_a_budget():
    reduced = rom.reduce(rom.two_mass(), modes=(0, 1))
    forces = [{0: 0.15}, {1: 0.25}]
    with pytest.raises(SlipmodeError, match=r"the steady state takes more than 1e-05 s\. Give a"):
        rom.steady_state(reduced, rom.Coulomb(2.0), [0.98, 1.65], forces, budget=1e-5)
    with pytest.raises(SlipmodeError, match="budget: must be a finite number > 0"):
        rom.steady_state(reduced, rom.Coulomb(2.0), [0.98, 1.65], forces, budget=0.0)
