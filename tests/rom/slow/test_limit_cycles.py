"""Limit cycles of self-excited modes beside closed forms and time integration; refusals."""

import numpy as np
import pytest
from beside_oracle import amplitudes, demodulated, fluttering, run, system_of
from oracles.closed_forms import jenkins_dissipation, jenkins_first_harmonic

from slipmode import rom

STRUCTURE = rom.two_mass(beta=0.01)
PATTERNS = ({0: 1.0}, {1: 1.0})
LIMIT, STIFFNESS = 0.02, 0.1  # of a Jenkins element on one mass
VISCOUS, FLUTTER = 0.004, -0.024  # dampers of the mass


def model(law=None, aerodynamics=(-0.02j,), reach=(6.0,), tolerance=1e-3, **given):
    law = law or rom.Coulomb(2.0)
    reduced = rom.reduce(STRUCTURE, range(len(reach)), aerodynamics=aerodynamics, **given)
    return rom.tabulate(reduced, law, reach, tolerance, combinations=())


@pytest.fixture(scope="module")
def mass():
    """A mass 1 on a spring 1 and a Jenkins element, self-excited; the damper c by aerodynamics."""
    law = rom.Jenkins(LIMIT, STIFFNESS)
    structure = rom.Structure(np.eye(1), np.eye(1), VISCOUS, contact=(0,))
    coefficient = 1j * FLUTTER * np.sqrt(1.0 + STIFFNESS)
    reduced = rom.reduce(structure, (0,), law=law, aerodynamics=(coefficient,))
    return rom.tabulate(reduced, law, (0.8,), 1e-4, detuning=True, warned=False)


@pytest.mark.oracle
def test_a_mass_on_a_jenkins_element_has_its_closed_form(mass):
    """-c Omega X = 4 L / pi (1 - L / (k_t X)); beyond the second root the amplitude grows."""
    stable, unstable = rom.limit_cycles(mass)
    assert stable.stable and not unstable.stable
    for cycle in (stable, unstable):
        X, Omega = 2.0 * abs(cycle.amplitude[0]), cycle.frequency[0]
        q = jenkins_first_harmonic(X, LIMIT, STIFFNESS)
        assert pytest.approx(q.imag, rel=0.01) == -(VISCOUS + FLUTTER) * Omega * X
        assert Omega**2 == pytest.approx(1.0 + q.real / X, abs=0.01 * STIFFNESS)
    # The growth rate: d/dX of -(c Omega X + Im q) / (2 Omega).
    X, Omega = 2.0 * abs(stable.amplitude[0]), stable.frequency[0]
    slope = 4.0 * LIMIT**2 / (np.pi * STIFFNESS * X**2)
    growth = -(slope + (VISCOUS + FLUTTER) * Omega) / (2.0 * Omega)
    assert stable.growth == pytest.approx(growth, rel=0.05)


@pytest.mark.oracle
def test_what_aerodynamics_put_in_leaves_by_friction_and_dampers(mass):
    stable, _ = rom.limit_cycles(mass)
    (Omega,), X = stable.frequency, 2.0 * abs(stable.amplitude[0])
    start = 0.95 * stable.amplitude
    end = run(mass, None, [40.0 / abs(stable.growth)], start=start, frequency_A=Omega)
    assert abs(amplitudes(end)[0, 0]) == pytest.approx(X / 2.0, rel=1e-5)
    assert end["input_power"][0] == 0.0
    lost = jenkins_dissipation(X, LIMIT, STIFFNESS) * Omega / (2.0 * np.pi)
    assert end["dissipated_power"][0] == pytest.approx(lost, rel=0.01)
    put_in = -0.5 * (FLUTTER + VISCOUS) * (Omega * X) ** 2
    assert end["dissipated_power"][0] == pytest.approx(put_in, rel=0.01)


@pytest.mark.slow
@pytest.mark.oracle
def test_amplitude_and_frequency_are_those_of_time_integration():
    """It keeps to the stable one, and leaves the unstable one to either side."""
    law, coefficient = rom.Tanh(2.0, 0.02), 0.05 - 0.024j
    of = model(law, (coefficient,), tolerance=1e-4)
    stable, unstable = rom.limit_cycles(of)
    shape = of.reduced.mode_shapes[:, 0]
    system = fluttering(system_of(STRUCTURE, law), shape, coefficient)
    (Omega,), (a,) = stable.frequency, stable.amplitude
    found = demodulated(system, shape, Omega, {}, 1.02 * a, 1500, 512)[-100:]
    # 0.1 % of friction may be 1 % of the amplitude.
    assert np.abs(found).mean() == pytest.approx(abs(a), rel=2e-3)
    turn = np.polyfit(np.arange(100), np.unwrap(np.angle(found)), 1)[0] / (2.0 * np.pi)
    assert abs(turn) <= 1e-4
    (Omega,), (a,) = unstable.frequency, unstable.amplitude
    for off, grows in ((0.93, False), (1.07, True)):
        end = demodulated(system, shape, Omega, {}, off * a, 60, 256)[-1]
        assert (abs(end) > abs(off * a)) == grows


def beside(of, cycle, off, duration, **inputs):
    """Amplitudes of a component that starts beside a limit cycle, at its frequencies."""
    A, B = cycle.frequency
    start = off * cycle.amplitude
    inputs |= {"frequency_A": A, "frequency_B": B}
    return amplitudes(run(of, PATTERNS, [duration], start=start, **inputs))[0]


def test_the_slow_flow_settles_beside_a_forced_mode():
    force, frequency = ({0: 0.1}, {}), (0.985, None)
    reduced = rom.reduce(STRUCTURE, carrier=(0.985, 1.69), aerodynamics=(0.0, -0.1j))
    of = rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), 0.02, combinations=())
    stable, unstable = rom.limit_cycles(of, frequency, force)
    assert stable.stable and not unstable.stable
    now = beside(of, stable, 0.99, 8000.0, force_A=0.1)
    np.testing.assert_allclose(np.abs(now), np.abs(stable.amplitude), rtol=1e-5)
    assert now[0] == pytest.approx(stable.amplitude[0], rel=1e-5)  # in phase with its force


@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_a_force_at_its_own_frequency_holds_a_self_excited_mode(mass):
    stable, _ = rom.limit_cycles(mass)
    (held,) = rom.steady(mass, stable.frequency, ({0: 1e-4},))
    assert 1.0 < np.abs(held) / np.abs(stable.amplitude[0]) < 1.05


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda of: rom.limit_cycles(of, (0.98,), ({0: 0.1},)), "^force: no unforced mode"),
        (
            lambda of: rom.steady(of, (0.98,), ({},)),
            "self-excited and not forced",
        ),
        (lambda of: rom.steady(of, (0.98,), ({0: 0.05},)), "and mode A is self-excited"),
        (
            lambda of: rom.steady(of, (0.98,), ({0: 0.15},)),
            "self-excited mode A leaves",
        ),
    ],
)
def test_what_is_no_limit_cycle_or_no_steady_state_is_refused(call, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        call(model(tolerance=1e-2))
