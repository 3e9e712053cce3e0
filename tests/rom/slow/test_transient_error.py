"""The estimate of the transient error: what contacts keep of the change of their force.

A contact that slips further one way than back keeps half of the change of its force in a cycle as
a mean force, on elastic contacts twice that, at most its limit. It displaces the modes statically.
"""

import numpy as np
import pytest

from slipmode import rom
from slipmode.fmu import Component

pytestmark = pytest.mark.oracle

LIMIT, STIFFNESS = 0.02, 0.1


def at(model, amplitude, **inputs):
    """Return the estimate (modes,) and the growth of the amplitude in a cycle."""
    component = Component(model, ({0: 1.0},), warned=False)
    component.set_inputs(frequency_A=1.0, **inputs)
    component.reset(amplitude=amplitude)
    error, step = component.transient_error(), 1e-4
    component.do_step(0.0, step)
    out = component.outputs()
    return error[0], 2.0 * np.pi * abs(out["A_re"] + 1j * out["A_im"] - amplitude) / step


@pytest.fixture(scope="module")
def mass():
    structure = rom.Structure(np.eye(1), np.eye(1), 0.004, contact=(0,))
    law = rom.Jenkins(LIMIT, STIFFNESS)
    reduced = rom.reduce(structure, (0,), law=law)
    return rom.tabulate(reduced, law, (3.0,), 1e-3, warned=False)


def test_a_jenkins_element_keeps_the_change_of_its_force(mass):
    """It slips from |a| = L / (2 k_t) on; the force changes by 2 k_t d|a| in a cycle."""
    omega2 = 1.0 + STIFFNESS
    error, growth = at(mass, 0.5, force_A=0.05)
    assert growth * STIFFNESS < LIMIT
    assert error == pytest.approx(growth * STIFFNESS / omega2, rel=1e-3)
    assert at(mass, 0.5, force_A=5.0)[0] == pytest.approx(LIMIT / omega2)
    assert at(mass, 0.02, force_A=0.01)[0] == 0.0  # it sticks
    error, growth = at(mass, 0.1 + 0.1 * LIMIT, force_A=0.01)
    assert error == pytest.approx(growth * STIFFNESS / omega2, rel=1e-3)


def test_steady_motion_has_no_error(mass):
    (steady,) = rom.steady(mass, (1.0,), ({0: 0.03},))
    error, _ = at(mass, steady, force_A=0.03)
    assert error <= 1e-6 * abs(steady)


def test_rigid_contacts_move_on_the_flexibility_of_the_structure(one_mode_model):
    reduced = one_mode_model.reduced
    error, growth = at(one_mode_model, 3.0, force_A=0.05)
    coupling = np.abs(reduced.coupling[0])
    moved = np.abs(reduced.coupling[0] @ np.linalg.inv(reduced.stiffness))
    assert error == pytest.approx(
        0.5 * growth * moved @ coupling / reduced.frequency[0] ** 2, rel=1e-3
    )
