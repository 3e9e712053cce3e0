"""Contacts that the retained mode alone moves: one DOF with a contact, decoupled DOFs.

Oracle: the describing function of a Jenkins element at x = X cos(Omega t), X > y = limit / k_t:

    k = k_t (theta - sin(2 theta) / 2) / pi,  theta = arccos(1 - 2 y / X),   E = 4 limit (X - y).
"""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import full

LIMIT, STIFFNESS, SPRING, DAMPER = 1.0, 1e3, 1e4, 0.1
LAW = rom.Jenkins(LIMIT, STIFFNESS)
RANGE = 5e-3


def describing(x):
    """Stiffness, and loss E / (pi x^2), of the element at a displacement amplitude x [N/m]."""
    y = LIMIT / STIFFNESS
    theta = np.arccos(1.0 - 2.0 * y / np.maximum(x, y))
    stiffness = STIFFNESS * (theta - 0.5 * np.sin(2.0 * theta)) / np.pi
    return stiffness, 4.0 * LIMIT * np.maximum(x - y, 0.0) / (np.pi * x**2)


def oscillator():
    return rom.Structure([[1.0]], [[SPRING]], [[DAMPER]], contact=(0,))


@pytest.mark.quick
def test_one_dof_with_a_contact_follows_the_describing_function():
    reduced = rom.reduce(oscillator(), (0,), law=LAW)
    model = rom.tabulate(reduced, LAW, (RANGE,), 1e-3, warned=False)
    curve = rom.backbone(model, amplitude=np.geomspace(2e-4, 0.99 * RANGE, 40))
    stiffness, loss = describing(2.0 * curve.amplitude)
    frequency = np.sqrt(SPRING + stiffness)
    damping = (DAMPER * frequency + loss) / (2.0 * frequency**2)
    # The describing function neglects the third harmonic of the motion; measured 3.1e-5, 4.1e-3.
    np.testing.assert_allclose(curve.frequency, frequency, rtol=4.5e-5)
    np.testing.assert_allclose(curve.damping, damping, rtol=5e-3)


@pytest.mark.parametrize("other", [2.1e4, 3e4, 3.3e4])
@pytest.mark.parametrize("mass", [0.31, 0.7, 1.0])
def test_a_contact_on_a_decoupled_dof_is_tabulated(other, mass):
    """Its residual flexibility is 0 but for rounding, which may have either sign."""
    structure = rom.Structure(np.diag([mass, 1.0]), np.diag([SPRING, other]), 0.0, contact=(0,))
    frequency = np.sqrt(np.array([(SPRING + STIFFNESS) / mass, other]))
    mode = int(np.argsort(frequency).argmin())
    reduced = rom.reduce(structure, (mode,), law=LAW)
    assert reduced.stiffness[0, 0] == 0.0
    model = rom.tabulate(reduced, LAW, (RANGE,), 1e-2, warned=False)
    at = 0.5 * RANGE
    stiffness, _ = describing(2.0 * at / np.sqrt(mass))
    expected = np.sqrt((SPRING + stiffness) / mass)
    curve = rom.backbone(model, amplitude=[at])
    assert curve.frequency[0] == pytest.approx(expected, rel=1e-3)


def test_one_dof_moves_as_at_full_order():
    structure, force, Omega = oscillator(), {0: 3.0}, 102.0
    reduced = rom.reduce(structure, (0,), law=LAW)
    steady = rom.steady_state(reduced, LAW, [Omega], [force], tolerance=1e-3)
    found = abs(steady.amplitude[0])
    excitation = full.Excitation.harmonic(structure, (force,), (Omega,))
    period = 2.0 * np.pi / Omega
    time = period * (300.0 + np.arange(256) / 256)
    motion = full.integrate(structure, LAW, excitation, time, steps_per_period=512, outputs=[0])
    carried = motion.displacement[:, 0] * np.exp(-1j * Omega * time)
    assert found == pytest.approx(abs(carried.mean()), rel=2e-3)


def test_every_dof_may_be_a_contact():
    structure = rom.Structure(np.eye(2), np.diag([SPRING, 3e4]), 1e-5, contact=(0, 1))
    assert rom.reduce(structure, (0, 1), law=LAW).n_contacts == 2
    with pytest.raises(rom.SlipmodeError, match="contact: all 2 DOFs are contacts") as refusal:
        rom.reduce(structure, (0,))
    assert "\n" not in str(refusal.value)


def test_modes_of_a_structure_whose_every_dof_is_a_contact():
    structure = rom.Structure(np.eye(2), np.diag([SPRING, 3e4]), 1e-5, contact=(0, 1))
    found = rom.modes(structure, LAW)
    assert list(found.states) == ["free", "stuck"]
    expected = np.sqrt([SPRING + STIFFNESS, 3e4 + STIFFNESS])
    np.testing.assert_allclose(found.states["stuck"].frequency, expected)
    assert "stuck Hz" in str(found)
    with pytest.raises(rom.SlipmodeError, match="contact: all 2 DOFs are contacts"):
        rom.modes(structure)
