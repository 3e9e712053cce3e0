"""What a table's tolerance means: frequency and damping at every amplitude of its range."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation

SHARES = np.geomspace(5e-3, 0.99, 60)  # of the range


def iwan_energy(law, amplitude):
    """Energy lost in a cycle of displacement amplitude, by the continuous distribution.

    The integral of 4 R phi^(chi + 1) (x - phi) over 0 to x (Segalman 2005), below macro-slip.
    """
    share = law.beta + (law.chi + 1.0) / (law.chi + 2.0)
    largest = law.force * (1.0 + law.beta) / (law.stiffness * share)
    R = law.force * (law.chi + 1.0) / (largest ** (law.chi + 2.0) * share)
    exponents = 1.0 / (law.chi + 2.0) - 1.0 / (law.chi + 3.0)
    return 4.0 * R * amplitude ** (law.chi + 3.0) * exponents, largest


@pytest.mark.parametrize(
    ("chi", "error"), [(-0.2, 0.01), (-0.5, 0.01), (-0.8, 0.01), (0.6, 0.016), (1.0, 0.021)]
)
def test_sliders_of_an_iwan_joint_lose_the_energy_of_its_distribution(chi, error):
    law = rom.Iwan(force=2.0, stiffness=20.0, chi=chi, beta=0.3)
    limit, stiffness = law.distribution()
    _, largest = iwan_energy(law, 1.0)
    for x in np.geomspace(3e-3, 0.99, 400) * largest:
        lost = 4.0 * np.sum(limit * np.maximum(x - limit / stiffness, 0.0))
        assert lost == pytest.approx(iwan_energy(law, x)[0], rel=error)


@pytest.mark.parametrize("chi", [-1.0, 1.01, 1e9, float("nan")])
def test_an_exponent_of_iwan_that_is_not_allowed_is_refused(chi):
    with pytest.raises(rom.SlipmodeError, match="chi: must be above -1 and at most 1, got"):
        rom.Iwan(force=2.0, stiffness=20.0, chi=chi, beta=0.3)


@pytest.mark.parametrize("damping", [1e-3, 0.0])
def test_a_joint_is_damped_as_its_hysteresis_says_at_small_amplitudes(damping):
    """A mass on a spring and an Iwan joint, and another mass far away.

    The energy of a cycle gives the damping of a backbone: pi gamma Omega x^2 + E(x), x the motion.
    """
    K, M = np.diag([1.0, 400.0]), np.eye(2)
    structure = rom.Structure(M, K, damping * M, contact=(0,))
    law = rom.Iwan(force=0.02, stiffness=0.05, chi=-0.5, beta=0.3)
    reduced = rom.reduce(structure, (0,), law=law)
    model = rom.tabulate(reduced, law, (0.4,), warned=False)
    amplitude = SHARES * 0.4
    curve = rom.backbone(model, amplitude=amplitude)
    x = 2.0 * amplitude
    lost, largest = iwan_energy(law, x)
    assert x.max() < 1.01 * largest
    # structural part of 2 zeta Omega^2 |a|, and that of the joint: E = 2 pi zeta_joint k x^2
    zeta = 0.5 * damping / curve.frequency + lost / (2.0 * np.pi * curve.frequency**2 * x**2)
    assert np.abs(curve.damping / zeta - 1.0).max() < 0.01
    assert np.all(np.abs(curve.damping / zeta - 1.0) <= 0.01 + curve.damping_error / zeta)


def test_where_contacts_stick_the_backbone_is_linear():
    law = rom.Jenkins(limit=2.0, stiffness=20.0)
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,), law=law)
    onset = 2.0 / float(np.abs(2.0 * reduced.coupling[0] * 20.0).max())
    model = rom.tabulate(reduced, law, (5.0 * onset,), warned=False)
    curve = rom.backbone(model, amplitude=np.geomspace(0.01, 0.99, 30) * onset)
    linear = 0.5 * reduced.modal_damping[0] / reduced.frequency[0]
    np.testing.assert_allclose(curve.frequency, reduced.frequency[0], rtol=1e-5)
    np.testing.assert_allclose(curve.damping, linear, rtol=1e-3)


@pytest.mark.parametrize("law", [rom.Coulomb(2.0), rom.Tanh(2.0, 0.005), rom.Tanh(2.0, 0.02)])
def test_rigid_friction_holds_it_at_every_amplitude(law):
    """Against marches in at least four times the steps, also just past the onset of slip."""
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,))
    model = rom.tabulate(reduced, law, (4.0,), 1e-3, warned=False)
    points = np.concatenate((np.geomspace(4e-3, 4.0, 60), np.linspace(0.9, 1.2, 60)))
    grid = Discretisation(max(4 * model.accuracy.steps, 2048), 1)
    S = ContactProblem.of(reduced, law).on(grid, 1e-8).solve(points[:, np.newaxis]).S[:, 0]
    loss = reduced.modal_damping[0] * reduced.carrier[0]
    error = np.abs(model.table(points[:, np.newaxis])[:, 0] - S)
    assert np.all(error <= 1e-3 * (np.abs(S) + loss * points))
