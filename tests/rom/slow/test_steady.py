"""Steady states on a table beside time integration, harmonic balance and closed forms."""

import numpy as np
import pytest
from beside_oracle import amplitudes, run, steady_amplitudes, system_of
from oracles.closed_forms import jenkins_first_harmonic
from oracles.harmonic_balance import balance

from slipmode import rom

pytestmark = pytest.mark.quick

NATURAL = np.array([1.0, 1.7])
BOTH = ({0: 0.15}, {1: 0.25})
PATTERNS = ({0: 1.0}, {1: 1.0})
TANH = rom.Tanh(limit=2.0, alpha=0.02)
TOLERANCE = 1e-3  # of the tables


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("law", "modes", "detuning", "steps"),
    [
        pytest.param(TANH, (0, 1), (-0.0175, -0.046), 512, marks=pytest.mark.slow),
        (TANH, (0, 1), (-0.005, -0.02), 512),
        (TANH, (0,), (-0.03, 0.0), 512),
        (rom.Coulomb(2.0), (1,), (0.0, -0.046), 4096),
        (rom.Jenkins(2.0, 50.0), (0,), (-0.0175, 0.0), 512),
        (rom.Iwan(3.0, 50.0, -0.5, 0.5, sliders=12), (1,), (0.0, -0.1), 512),
    ],
)
def test_amplitudes_and_phases_are_those_of_time_integration(law, modes, detuning, steps):
    """The error of friction, relative to its largest force, changes amplitudes by up to twice."""
    structure, j = rom.two_mass(beta=0.01), list(modes)
    Omega, forces = (NATURAL + detuning)[j], [BOTH[mode] for mode in j]
    elastic = law if isinstance(law, rom.Jenkins | rom.Iwan) else None
    reduced = rom.reduce(structure, modes, carrier=Omega, law=elastic, force_patterns=forces)
    model = rom.tabulate(reduced, law, np.array([4.0, 2.0])[j].tolist(), TOLERANCE)
    exact, own = steady_amplitudes(
        *(system_of(structure, law), reduced, Omega, forces), tolerance=2e-5, steps=steps
    )
    found = rom.steady(model, Omega, forces)
    assert np.all(np.abs(found - exact) <= 2.0 * TOLERANCE * np.abs(exact) + own)


def oscillator(law, reach, carrier=None):
    """Return a table of a mass 1 on a spring 1, with a contact beside the spring."""
    structure = rom.Structure(np.eye(1), np.eye(1), 0.004, contact=(0,))
    reduced = rom.reduce(structure, (0,), law=law, carrier=carrier)
    return structure, rom.tabulate(reduced, law, (reach,), 1e-4, warned=False)


@pytest.mark.oracle
@pytest.mark.parametrize("frequency", [0.97, 1.02, 1.05])
def test_a_mass_on_a_jenkins_element_has_its_closed_form(frequency):
    """(k - Omega^2 + i c Omega) X + q(X) = F; harmonics of the mass itself are of order q / 8."""
    law = rom.Jenkins(limit=0.02, stiffness=0.1)
    structure, model = oscillator(law, 1.2, (frequency,))
    force = 0.06
    (a,) = rom.steady(model, (frequency,), ({0: force},))
    X = 2.0 * a
    q = jenkins_first_harmonic(abs(X), 0.02, 0.1) * X / abs(X)
    left = (1.0 - frequency**2 + 0.004j * frequency) * X + q - force
    assert abs(left) <= 0.01 * abs(q)
    exact = balance(system_of(structure, law), frequency, np.array([force + 0j]))[1, 0]
    assert abs(X - exact) <= 1e-3 * abs(exact)


@pytest.mark.oracle
@pytest.mark.parametrize("phase", [(0.0, 0.0), (0.7, -0.4)])
def test_the_slow_flow_from_rest_ends_in_the_steady_state(paper_model, phase):
    """Without combination resonances. The phase of a force turns its amplitude."""
    Omega = np.add(NATURAL, (-0.0175, -0.046))
    inputs = {"force_A": 0.15, "force_B": 0.25, "frequency_A": Omega[0], "frequency_B": Omega[1]}
    inputs |= {"phase_A": phase[0], "phase_B": phase[1]}
    (end,) = amplitudes(run(paper_model, PATTERNS, [5000.0], tolerance=1e-9, **inputs))
    found = rom.steady(paper_model, Omega, BOTH, phase)
    np.testing.assert_allclose(end, found, rtol=1e-6)
    turned = rom.steady(paper_model, Omega, BOTH) * np.exp(1j * np.array(phase))
    np.testing.assert_allclose(found, turned, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two_mode_model", "paper_model"])
@pytest.mark.parametrize("mode", [0, 1])
def test_the_curve_inverted_gives_back_the_amplitude(name, mode, request):
    """Within 0.2 %: steady states alone have the effect of the force on the contacts."""
    model, held = request.getfixturevalue(name), np.zeros((9, 2))
    held[:, mode] = np.linspace(0.3, 1.1, 9)
    curve = rom.resonance_curve(model, mode, BOTH[mode], held)
    assert np.all(curve.below < curve.above)
    alone = [force if j == mode else {0: 0.0} for j, force in enumerate(BOTH)]
    for branch in (curve.below, curve.above):
        frequency = np.tile(NATURAL, (branch.size, 1))
        frequency[:, mode] = branch
        found = np.abs(rom.steady(model, frequency, alone)[:, mode])
        np.testing.assert_allclose(found, curve.amplitude, rtol=2e-3)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_frequencies_of_a_linear_mode_have_their_closed_form_up_to_the_peak():
    """(omega^2 - Omega^2)^2 + (gamma Omega)^2 = (F / 2 |a|)^2; what is not found is left out."""
    reduced = rom.reduce(rom.two_mass(beta=0.3), modes=(0,))
    model = rom.tabulate(reduced, rom.Coulomb(50.0), (1.0,), 1e-2)
    (omega,), (gamma,) = reduced.frequency, reduced.modal_damping
    half_force = 0.5 * abs(reduced.modal_force(0, {0: 0.15}))
    peak = half_force / (gamma * np.sqrt(omega**2 - 0.25 * gamma**2))
    amplitude = peak * (1.0 - np.geomspace(1e-6, 0.5, 60))
    curve = rom.resonance_curve(model, 0, {0: 0.15}, amplitude)
    for frequency in (curve.below, curve.above):
        found = np.isfinite(frequency)
        assert found.sum() > 10
        dynamic = omega**2 - frequency**2 + 1j * gamma * frequency
        expected = half_force / np.abs(dynamic)[found]
        np.testing.assert_allclose(amplitude[found], expected, rtol=1e-8)


@pytest.mark.slow
def test_the_surface_is_the_steady_state_at_each_pair_of_frequencies(two_mode_model):
    axis_A, axis_B = np.array([0.96, 0.98, 1.0]), np.array([1.6, 1.65])
    surface = rom.resonance(two_mode_model, BOTH, axis_A, axis_B)
    alone = rom.steady(two_mode_model, (axis_A[2], axis_B[1]), BOTH)
    np.testing.assert_allclose(surface.amplitude[2, 1], alone, rtol=1e-9)
    np.testing.assert_allclose(surface.euclidean, np.linalg.norm(surface.amplitude, axis=-1))
    columns = surface.columns(dof=1, units=rom.Units("Hz", "mm"))
    k = 2 * 2 + 1  # A 2, B 1
    assert columns["frequency_A [Hz]"][k] == pytest.approx(axis_A[2] / (2 * np.pi))
    assert columns["B at DOF 1 [mm]"][k] == pytest.approx(1e3 * surface.displacement(1)[2, 1, 1])


@pytest.mark.parametrize(
    ("frequency", "force", "message"),
    [
        ((0.98, np.nan), BOTH, "frequency: must be finite and > 0"),
        ((1.65, 1.65), BOTH, "must differ at each point"),
        ((0.98, 1.65), BOTH[:1], "force: needs one entry per mode"),
        ((0.985, 1.65), ({0: 15.0}, {1: 0.25}), "outside the friction table"),
    ],
)
def test_refuses_in_one_line(two_mode_model, frequency, force, message):
    with pytest.raises(rom.SlipmodeError, match=message) as refusal:
        rom.steady(two_mode_model, frequency, force)
    assert "\n" not in str(refusal.value)
