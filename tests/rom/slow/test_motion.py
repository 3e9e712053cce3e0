"""Fast motion from the slow amplitudes: windows, segments, elastic DOFs, energy."""

import numpy as np
import pytest
from beside_oracle import system_of
from oracles.time_integration import integrate
from slow_time import slow_trajectory, steady_balance

from slipmode.rom import (
    SlipmodeError,
    SlowTrajectory,
    Tanh,
    reconstruct,
    reduce,
    sum_harmonics,
    tabulate,
    two_mass,
)

pytestmark = pytest.mark.quick

LAW = Tanh(limit=2.0, alpha=0.02)
FORCE_PATTERNS = ({0: 1.0}, {1: 1.0})
DURATION = 300.0


@pytest.fixture(scope="module")
def two_mode_model():
    """Without harmonics: the modes move at their carriers alone."""
    return tabulate(reduce(two_mass()), LAW, amplitude=(4.0, 4.0))


@pytest.fixture(scope="module")
def transient(two_mode_model):
    """From rest, with a step of force on B and a sweep of A."""
    time = np.linspace(0, DURATION, 301)
    start = time[:-1]
    return slow_trajectory(
        two_mode_model,
        FORCE_PATTERNS,
        time,
        force_A=0.15,
        force_B=np.where(start < 100, 0.0, 0.25),
        frequency_A=0.96 + 1e-4 * start,
        frequency_rate_A=1e-4,
        frequency_B=1.65,
    )


def held_amplitude(model, amplitude, duration):
    """A trajectory at constant amplitudes, under the forces that hold them there."""
    a = np.array(amplitude, dtype=complex)
    Omega = model.reduced.frequency
    at_rest = steady_balance(model, a, Omega, np.zeros(2))
    force = -2 * (at_rest.mass * at_rest.rate)[0]
    steps = 100
    time = np.linspace(0, duration, steps + 1)
    still = np.zeros((steps, 2))
    return SlowTrajectory(
        time=time,
        amplitude=np.tile(a, (steps + 1, 1)),
        angle=np.outer(time, Omega),
        frequency=still + Omega,
        frequency_rate=still,
        force=still + force,
        force_rate=still,
    )


def relative_difference(found, exact):
    return np.abs(found - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("start", [90.0, 270.0])
def test_a_window_is_the_same_as_a_march_from_the_beginning(two_mode_model, transient, start):
    times = np.linspace(start, start + 30, 601)
    window = reconstruct(two_mode_model, transient, times)
    whole = reconstruct(two_mode_model, transient, times, spin_up=1e6)
    for quantity in ("displacement", "velocity", "force", "modal"):
        # a march over ten periods has forgotten its start to rounding: measured 8e-14
        difference = relative_difference(getattr(window, quantity), getattr(whole, quantity))
        assert difference < 1e-12


@pytest.mark.oracle
def test_second_order_in_the_steps(two_mode_model, transient):
    times = np.linspace(250.0, 280.0, 31)

    def displacement(steps):
        return reconstruct(two_mode_model, transient, times, steps_per_period=steps).displacement

    exact = displacement(32768)
    coarse, fine = (relative_difference(displacement(steps), exact) for steps in (512, 4096))
    # over three halvings (measured 1.97): in a single one, where stick ends in a step matters
    assert np.log2(coarse / fine) / 3 == pytest.approx(2.0, abs=0.3)
    # longer ones are halved where contacts begin to slip: measured 5.8e-4, without 8.6e-3
    assert relative_difference(displacement(64), exact) < 1e-3


@pytest.mark.oracle
@pytest.mark.parametrize("end", [100.0, DURATION])
def test_motion_at_the_end_of_a_segment_is_that_of_its_amplitude(two_mode_model, transient, end):
    k = int(end)
    motion = reconstruct(two_mode_model, transient, [end - 0.5, end])
    expected = 2 * np.real(transient.amplitude[k] * np.exp(1j * transient.angle[k]))
    np.testing.assert_allclose(motion.modal[1], expected, rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("points", [26, 2])
def test_between_communication_points_the_motion_is_that_of_fine_steps(two_mode_model, points):
    """Steps of 4 s follow a cubic, and one of 100 s is divided: a cubic would be 8 % off."""
    fine, coarse = (
        slow_trajectory(
            two_mode_model,
            FORCE_PATTERNS,
            time,
            tolerance=1e-9,
            **{"force_A": 0.15, "force_B": 0.25, "frequency_A": 0.98, "frequency_B": 1.65},
        )
        for time in (np.linspace(0, 100, 1001), np.linspace(0, 100, points))
    )
    times = np.linspace(60.0, 100.0, 400)
    expected = reconstruct(two_mode_model, fine, times)
    found = reconstruct(two_mode_model, coarse, times)
    # beating by combination resonances: measured 4.3e-5 at most
    assert relative_difference(found.modal, expected.modal) < 6e-5
    # time steps of the contacts, taken elsewhere: measured 0.16 %
    assert relative_difference(found.displacement, expected.displacement) < 8e-3


@pytest.mark.oracle
def test_the_force_obeys_the_law_of_friction(two_mode_model, transient):
    motion = reconstruct(two_mode_model, transient, np.linspace(150, 200, 500))
    law = two_mode_model.law
    assert np.abs(motion.force).max() <= law.limit
    expected = law.limit * np.tanh(motion.velocity / law.alpha)
    np.testing.assert_allclose(motion.force, expected, atol=1e-6 * law.limit)


def test_the_velocity_is_the_rate_of_the_displacement(two_mode_model, transient):
    times = np.arange(150.0, 160.0, 1e-3)
    motion = reconstruct(two_mode_model, transient, times)
    difference = (motion.displacement[2:] - motion.displacement[:-2]) / 2e-3
    # central differences where stick ends: measured 1.3e-3
    assert relative_difference(difference, motion.velocity[1:-1]) < 3e-3


# Harmonics summed


@pytest.mark.oracle
@pytest.mark.parametrize("quantity", ["displacement", "velocity", "force"])
def test_the_sum_of_harmonics_tends_to_the_motion_of_time_integration(steady, quantity):
    """Marched contacts are within 0.5 %; more harmonics leave less."""
    exact, found = steady

    def missed(of):
        difference = getattr(of, quantity) - exact[quantity]
        return np.sqrt((difference**2).mean() / (exact[quantity] ** 2).mean())

    assert (
        missed(found["marched"])
        < {"displacement": 5e-3, "velocity": 0.02, "force": 5e-3}[quantity]
    )
    assert missed(found["marched"]) < missed(found[9]) < missed(found[5]) < 0.3


@pytest.fixture(scope="module")
def steady():
    """Contact motion of mode A alone once it is steady, by integration, march and sums."""
    structure, Omega, size = two_mass(beta=0.01), 0.985, 0.15
    period = 2.0 * np.pi / Omega
    steps, periods = 2048, 250
    exact = integrate(
        *(
            system_of(structure, LAW),
            np.eye(4)[:, :1],
            lambda t: size * np.cos(Omega * t)[:, None],
        ),
        *(periods * period, periods * steps, steps // 128),
    )
    late = slice(-256, None)
    times, x, v = exact.t[late], exact.x[late, 2:], exact.v[late, 2:]
    reference = {"displacement": x, "velocity": v, "force": LAW.limit * np.tanh(v / LAW.alpha)}
    found = {}
    for order in (5, 9):
        reduced = reduce(structure, (0,), carrier=(Omega,))
        model = tabulate(reduced, LAW, (4.0,), 1e-4, harmonics=order)
        grid = np.linspace(0.0, periods * period, 2 * periods + 1)
        run = slow_trajectory(
            *(model, FORCE_PATTERNS[:1], grid), start=(0.0,), force_A=size, frequency_A=Omega
        )
        found[order] = sum_harmonics(model, run, times)
    return reference, found | {"marched": reconstruct(model, run, times, steps_per_period=1024)}


# Energy


@pytest.fixture(scope="module")
def model_with_harmonics():
    """So that the modal response acts on the marched contacts, as on those of the table."""
    return tabulate(reduce(two_mass()), LAW, amplitude=(4.0, 4.0), combinations=(), harmonics=5)


@pytest.mark.oracle
@pytest.mark.parametrize("amplitude", [(1.3, 1.5), (1.05, 0.9)])
@pytest.mark.parametrize(
    ("name", "balance", "friction_power"),
    # measured at the worst: 1.3e-3, 1.3e-3; 0.36e-3, 1.5e-3 (the power takes no account of the
    # contacts' damping at harmonics above the fifth)
    [("paper_model", 1.5e-3, 1.5e-3), ("model_with_harmonics", 0.4e-3, 1.7e-3)],
)
def test_what_the_contacts_take_from_the_modes_is_dissipated_there(
    name, balance, friction_power, amplitude, request
):
    model = request.getfixturevalue(name)
    reduced, modulus = model.reduced, np.array(amplitude)
    taken = (-2 * reduced.frequency * modulus * model.table(modulus).imag).sum()
    period = 20 * np.pi  # of both carriers, 1 and 1.7 rad/s
    times = period * (1 + np.arange(1, 32001) / 32000)
    motion = reconstruct(
        model, held_amplitude(model, amplitude, 2 * period), times, steps_per_period=256
    )
    v, q_rate = motion.velocity, np.gradient(motion.modal, times, axis=0)
    friction = np.mean((motion.force * v).sum(axis=1))
    # the dampers that the contacts share with the modes take from both; the modes' part is theirs
    viscous = np.mean((v * (v @ reduced.damping + 2 * q_rate @ reduced.damper)).sum(axis=1))
    assert taken == pytest.approx(friction + viscous, rel=balance)
    dissipated = taken + model.table.terms(modulus)[-1].real
    assert dissipated == pytest.approx(friction, rel=friction_power)


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([], "times: must be finite and increasing"),
        ([2.0, 1.0], "times: must be finite and increasing"),
        ([1.0, 1.0], "times: must be finite and increasing"),
        ([-1.0, 1.0], "times: must lie within the run"),
        ([1.0, DURATION + 1], "times: must lie within the run"),
        ([1.0, np.nan], "times: must be finite and increasing"),
    ],
)
def test_refuses_times_outside_the_run_or_out_of_order(two_mode_model, transient, times, message):
    with pytest.raises(SlipmodeError, match=message) as refusal:
        reconstruct(two_mode_model, transient, times)
    assert "\n" not in str(refusal.value)
