"""Fast motion from the slow amplitudes: windows, segments, harmonics, energy."""

import numpy as np
import pytest
from beside_oracle import amplitudes, run, system_of
from oracles.time_integration import integrate
from scipy.integrate import solve_ivp

from slipmode import rom

pytestmark = pytest.mark.quick

LAW = rom.Tanh(limit=2.0, alpha=0.02)
DURATION = 300.0


def trajectory(model, times, force, frequency, sweep=0.0, start=0.0):
    """Return amplitudes of the component from time 0, with `sweep` of the frequency of A."""
    modes = range(model.modes)
    patterns = [{j: 1.0} for j in modes]
    rates = np.zeros((len(times) - 1, model.modes))
    rates[:, 0] = sweep
    Omega = frequency + rates * times[:-1, np.newaxis]
    inputs = {"frequency_rate_A": sweep}
    for j, mode in enumerate("AB"[: model.modes]):
        inputs |= {f"force_{mode}": force[j], f"frequency_{mode}": Omega[:, j]}
    found = run(model, patterns, times[1:], start=start, tolerance=1e-9, **inputs)
    angle = np.column_stack([found[f"theta_{mode}"] for mode in "AB"[: model.modes]])
    modal = [force[j] * model.reduced.modal_force(j, patterns[j]) for j in modes]
    a = amplitudes(found)[:, : model.modes]
    return rom.SlowTrajectory(
        time=times,
        amplitude=np.vstack((np.broadcast_to(start, angle[:1].shape), a)),
        angle=np.vstack((np.zeros_like(angle[:1]), angle)),
        frequency=Omega,
        frequency_rate=rates,
        force=np.tile(modal, (len(rates), 1)) + 0j,
        force_rate=np.zeros_like(rates) + 0j,
    )


@pytest.fixture(scope="module")
def transient(two_mode_model):
    """From beside rest, with a sweep of A."""
    times = np.linspace(0, DURATION, 301)
    start = np.array([0.3 - 0.2j, 0.1j])
    frequency = np.array([0.96, 1.65])
    return trajectory(two_mode_model, times, (0.15, 0.25), frequency, 1e-4, start)


def relative_difference(found, exact):
    return np.abs(found - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("start", [90.0, 270.0])
def test_a_window_is_the_same_as_a_march_from_the_beginning(two_mode_model, transient, start):
    """A march over ten periods has forgotten its start to rounding."""
    times = np.linspace(start, start + 30, 301)
    window = rom.reconstruct(two_mode_model, transient, times)
    whole = rom.reconstruct(two_mode_model, transient, times, spin_up=1e6)
    for quantity in ("displacement", "velocity", "force", "modal"):
        difference = relative_difference(getattr(window, quantity), getattr(whole, quantity))
        assert difference < 1e-12


@pytest.mark.oracle
def test_second_order_in_the_steps(two_mode_model, transient):
    times = np.linspace(250.0, 280.0, 31)

    def displacement(steps):
        return rom.reconstruct(
            two_mode_model, transient, times, steps_per_period=steps
        ).displacement

    exact = displacement(32768)
    coarse, fine = (relative_difference(displacement(steps), exact) for steps in (512, 4096))
    # Over three halvings: in a single one, where stick ends in a step matters.
    assert np.log2(coarse / fine) / 3 == pytest.approx(2.0, abs=0.3)


@pytest.fixture(scope="module")
def steady():
    """Contact motion of mode A alone once it is steady, by integration, march and sums."""
    structure, Omega, size = rom.two_mass(beta=0.01), 0.985, 0.15
    period, steps, periods = 2.0 * np.pi / Omega, 2048, 250
    exact = integrate(
        *(system_of(structure, LAW), size * np.eye(4)[:, :1]),
        *(lambda t: np.cos(Omega * t)[:, np.newaxis], periods * period),
        *(periods * steps, steps // 128),
    )
    late = slice(-256, None)
    times, x, v = exact.t[late], exact.x[late, 2:], exact.v[late, 2:]
    reference = {"displacement": x, "velocity": v, "force": LAW.limit * np.tanh(v / LAW.alpha)}
    found = {}
    for order in (5, 9):
        reduced = rom.reduce(structure, (0,), carrier=(Omega,))
        model = rom.tabulate(reduced, LAW, (4.0,), 1e-4, harmonics=order)
        grid = 0.5 * period * np.arange(2 * periods + 2)
        slow = trajectory(model, grid, (size,), np.array([Omega]))
        found[order] = rom.sum_harmonics(model, slow, times)
    marched = rom.reconstruct(model, slow, times, steps_per_period=1024)
    return reference, found | {"marched": marched}


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("quantity", "bound"), [("displacement", 5e-3), ("velocity", 2e-2), ("force", 5e-3)]
)
def test_the_sum_of_harmonics_tends_to_the_motion_of_time_integration(steady, quantity, bound):
    """Marched contacts are close; more harmonics leave less."""
    exact, found = steady

    def missed(of):
        difference = getattr(of, quantity) - exact[quantity]
        return np.sqrt((difference**2).mean() / (exact[quantity] ** 2).mean())

    assert missed(found["marched"]) < bound
    assert missed(found["marched"]) < missed(found[9]) < missed(found[5]) < 0.3


@pytest.mark.oracle
def test_the_sum_of_harmonics_is_of_second_order_in_the_steps_of_the_amplitudes(two_mode_model):
    """Coefficients are linear between the ends of a step."""
    start, times = np.array([0.3 - 0.2j, 0.1j]), np.linspace(40.0, 80.0, 201)

    def displacement(step):
        steps, frequency = np.arange(0.0, 80.1, step), np.array([0.96, 1.65])
        slow = trajectory(two_mode_model, steps, (0.15, 0.25), frequency, start=start)
        return rom.sum_harmonics(two_mode_model, slow, times).displacement

    exact = displacement(0.25)
    coarse, fine = (relative_difference(displacement(step), exact) for step in (8.0, 1.0))
    assert np.log2(coarse / fine) / 3 == pytest.approx(2.0, abs=0.2)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_a_force_that_grows_at_a_phase_has_the_rate_of_an_oscillator_with_stuck_contacts():
    """a = A + B t satisfies a'' + (gamma + 2 i Omega) a' + D a = (F + F' t) exp(i phase) / 2."""
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    stuck = rom.tabulate(reduced, rom.Coulomb(1e6), (20.0,), tolerance=0.1)
    (omega,), (gamma,), Omega = reduced.frequency, reduced.modal_damping, 0.97
    D = omega**2 - Omega**2 + 1j * gamma * Omega
    times, force, rate = np.array([[0.0], [4.0]]), 0.3 * np.exp(0.8j), 0.01 * np.exp(0.8j)
    B = 0.5 * rate / D
    start = (0.5 * force - (gamma + 2j * Omega) * B) / D
    slow = rom.SlowTrajectory(
        time=times[:, 0],
        amplitude=start + B * times,
        angle=Omega * times,
        frequency=np.array([[Omega]]),
        frequency_rate=np.array([[0.0]]),
        force=np.array([[force]]),
        force_rate=np.array([[rate]]),
    )
    np.testing.assert_allclose(slow.amplitude_rates(stuck), np.full((2, 1, 1), B), rtol=1e-12)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_a_sweep_over_long_steps_moves_as_an_oscillator_with_stuck_contacts():
    """q'' + gamma q' + omega^2 q = F cos(theta), theta' = Omega + rate t, through resonance."""
    reduced, rate, end = rom.reduce(rom.two_mass(beta=0.2), modes=(0,)), 1e-3, 200.0
    stuck = rom.tabulate(reduced, rom.Coulomb(1e6), (20.0,), tolerance=0.1)
    (omega,), (gamma,) = reduced.frequency, reduced.modal_damping
    Omega = omega - 0.5 * rate * end
    slow = trajectory(stuck, np.arange(0.0, end + 1.0, 10.0), (1.0,), np.array([Omega]), rate)

    def oscillator(t, y):
        force = slow.force[0, 0].real * np.cos(Omega * t + 0.5 * rate * t**2)
        return y[1], force - gamma * y[1] - omega**2 * y[0]

    times = np.linspace(0.5 * end, end, 401)
    q = solve_ivp(oscillator, (0.0, end), (0.0, 0.0), t_eval=times, rtol=1e-8, atol=1e-10).y[0]
    assert relative_difference(rom.reconstruct(stuck, slow, times).modal[:, 0], q) < 1e-4


# Energy


@pytest.fixture(scope="module")
def model_with_harmonics():
    """So that the modal response acts on the marched contacts, as on those of the table."""
    reduced = rom.reduce(rom.two_mass())
    return rom.tabulate(reduced, LAW, amplitude=(4.0, 4.0), combinations=(), harmonics=5)


def held_amplitude(model, modulus, duration):
    """A trajectory at constant amplitudes, under the forces 2 (i gamma omega a - S) on them."""
    reduced, steps = model.reduced, 100
    damping = 1j * reduced.modal_damping * reduced.frequency * modulus
    time, still = np.linspace(0, duration, steps + 1), np.zeros((steps, 2))
    return rom.SlowTrajectory(
        time=time,
        amplitude=np.tile(modulus + 0j, (steps + 1, 1)),
        angle=np.outer(time, reduced.frequency),
        frequency=still + reduced.frequency,
        frequency_rate=still,
        force=still + 2 * (damping - model.table(modulus)),
        force_rate=still + 0j,
    )


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
    held = held_amplitude(model, modulus, 2 * period)
    motion = rom.reconstruct(model, held, times, steps_per_period=256)
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
        ([2.0, 1.0], "times: must be finite and increasing"),
        ([1.0, DURATION + 1], "times: must lie within the run"),
        ([1.0, np.nan], "times: must be finite and increasing"),
    ],
)
def test_refuses_times_outside_the_run_or_out_of_order(two_mode_model, transient, times, message):
    with pytest.raises(rom.SlipmodeError, match=message) as refusal:
        rom.reconstruct(two_mode_model, transient, times)
    assert "\n" not in str(refusal.value)
