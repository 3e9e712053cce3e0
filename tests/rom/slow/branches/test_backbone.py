"""Backbones and free vibration beside closed forms and time integration."""

import numpy as np
import pytest
from beside_oracle import demodulated, run, system_of
from oracles.closed_forms import jenkins_first_harmonic

from slipmode import rom

STRUCTURE = rom.two_mass(beta=0.01)


@pytest.fixture(scope="module")
def mass():
    """A mass 1 on a spring 1 and a Jenkins element, and its table."""
    structure, law = (
        rom.Structure(np.eye(1), np.eye(1), 0.004, contact=(0,)),
        rom.Jenkins(0.02, 0.1),
    )
    reduced = rom.reduce(structure, (0,), law=law)
    return structure, law, rom.tabulate(reduced, law, (1.0,), 1e-4, detuning=True, warned=False)


@pytest.mark.oracle
def test_a_mass_on_a_jenkins_element_has_its_closed_form(mass):
    """Omega^2 = k + Re q / X and 2 zeta Omega^2 = c Omega + Im q / X, X = 2 |a|.

    Harmonics of the mass are of order k_t / 8.
    """
    _, law, model = mass
    curve = rom.backbone(model)
    X = 2.0 * curve.amplitude
    q = np.array([jenkins_first_harmonic(each, law.limit, law.stiffness) for each in X]) / X
    off = curve.frequency**2 - 1.0 - q.real
    assert np.abs(off).max() <= 0.01 * law.stiffness
    lost = 2.0 * curve.damping * curve.frequency**2 - 0.004 * curve.frequency - q.imag
    assert np.abs(lost).max() <= 0.01 * law.stiffness
    assert q.imag.max() > 0.3 * law.stiffness


@pytest.mark.oracle
def test_free_vibration_decays_as_in_time_integration(mass):
    """Amplitude and phase over 40 cycles, in which the contact takes most of the energy.

    Means over a period leave (Omega - omega) / (2 Omega), up to 0.5 % while the contact slides;
    the estimate of the transient error is 0.4 %.
    """
    structure, law, model = mass
    Omega, shape = 1.01, model.reduced.mode_shapes[:, 0]  # of a period while the contact slides
    exact = demodulated(system_of(structure, law), shape, Omega, {}, 0.9 / shape[0], 40)
    middle = (np.arange(40) + 0.5) * 2.0 * np.pi / Omega
    found = run(model, ({0: 1.0},), middle, start=0.9 / shape[0], frequency_A=Omega)
    a = found["A_re"] + 1j * found["A_im"]
    assert abs(exact[-1]) < 0.7 * abs(exact[0])
    assert np.abs(a - exact)[2:].max() <= 0.015 * abs(exact[0])


@pytest.mark.oracle
def test_a_stuck_contact_leaves_the_linear_mode():
    model = rom.tabulate(rom.reduce(STRUCTURE, (0,)), rom.Coulomb(2.0), (4.0,), 1e-3)
    curve = rom.backbone(model)
    stuck = curve.amplitude < 0.9
    assert curve.frequency[stuck] == pytest.approx(model.reduced.frequency[0], rel=1e-4)
    assert curve.damping[stuck] == pytest.approx(0.005, rel=1e-3)
    assert curve.damping.max() > 2 * 0.005
    assert np.all(np.diff(curve.frequency[curve.amplitude > 1.2]) < 0.0)


@pytest.mark.oracle
def test_a_forced_mode_is_at_phase_resonance_on_it():
    """A quarter of a cycle behind the force, F = 4 zeta Omega^2 a."""
    reduced = rom.reduce(STRUCTURE, (0,))
    model = rom.tabulate(reduced, rom.Coulomb(2.0), (4.0,), 1e-3)
    curve = rom.backbone(model, amplitude=[1.5, 2.5])
    for a, Omega, zeta in zip(curve.amplitude, curve.frequency, curve.damping, strict=True):
        force = 4.0 * zeta * Omega**2 * a / abs(reduced.mode_shapes[0, 0])
        states = rom.response_curve(model, [Omega], [{0: force}], "force", (0.99, 1.01))
        at = np.argmin(np.abs(states.parameter - 1.0))
        assert abs(states.amplitude[at, 0]) == pytest.approx(a, rel=0.02)


def test_the_other_mode_dithers_friction():
    """Contacts that slip with B hold A less: it is softer, and damped before it slips alone."""
    model = rom.tabulate(rom.reduce(STRUCTURE), rom.Coulomb(2.0), (4.0, 2.0), 5e-3)
    alone, beside = (rom.backbone(model, 0, other, [0.9]) for other in (0.0, 1.5))
    assert beside.frequency < alone.frequency
    assert beside.damping > 1.1 * alone.damping
    assert beside.displacement(0) == pytest.approx(1.8 * abs(model.reduced.mode_shapes[0, 0]))
