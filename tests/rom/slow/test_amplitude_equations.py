"""The amplitude equations written out, integrated by scipy; phases, sweeps, beats."""

from dataclasses import dataclass

import numpy as np
import pytest
from beside_oracle import amplitudes, run
from scipy.integrate import solve_ivp

from slipmode import rom
from slipmode.rom.contact.detuning import MOST_DETUNING, coupling_factor
from slipmode.rom.reduction.force_response import AppliedForces

pytestmark = pytest.mark.quick

FORCES = ({0: 1.0}, {1: 1.0})
NEAR_PEAKS = {"force_A": 0.15, "force_B": 0.25, "frequency_A": 0.98, "frequency_B": 1.65}
SWEEPS = {"frequency_rate_A": 1e-4, "frequency_rate_B": -2e-4, "force_rate_A": 1e-4}


def largest_difference(amplitude, exact):
    return np.abs(amplitude - exact).max() / np.abs(exact).max()


@dataclass(frozen=True)
class Forcing:
    """What drives both modes at an instant."""

    force: np.ndarray  # modal, F_j exp(i phase_j)
    frequency: np.ndarray
    angle: np.ndarray

    @classmethod
    def at(cls, model, t, phase=0.0):
        """Return the sweeps from NEAR_PEAKS after a time."""
        each = [model.reduced.modal_force(j, pattern) for j, pattern in enumerate(FORCES)]
        force = np.array([0.15 + 1e-4 * t, 0.25]) * each * np.exp(1j * phase)
        start, rate = np.array([0.98, 1.65]), np.array([1e-4, -2e-4])
        return cls(force, start + rate * t, start * t + 0.5 * rate * t**2)


def mass_and_slow_root(reduced, Omega):
    """P [rad/s] and r [rad/s] of the amplitude equations (d/dt + P) (d/dt - r) a = G.

    In the "paper" formulation the carrier is the natural frequency, the detuning enters to first
    order and P alone stands for d/dt + P; in "consistent" the carrier is the forcing itself, and r
    is how the mode vibrates without contacts.
    """
    omega, half = reduced.frequency, 0.5 * reduced.modal_damping
    if reduced.formulation == "paper":
        return 2j * omega, -half + 1j * (omega - Omega)
    vibration = np.sqrt(omega**2 - half**2)
    return half + 1j * (vibration + Omega), -half + 1j * (vibration - Omega)


def effective_amplitude(model, a, now):
    shift = AppliedForces.of(model.reduced, FORCES).shift
    return coupling_factor(model.reduced, now.frequency) * (a + shift * now.force)


def detuning(model, frequency):
    """Return the distance from the carriers as far as the table has slopes."""
    most = MOST_DETUNING * model.reduced.carrier
    return np.clip(frequency - model.reduced.carrier, -most, most)


def contact_force(model, a, now):
    """Return Q_j a_j and the combination resonances, straight from the table."""
    effective = effective_amplitude(model, a, now)
    size, unit = np.abs(effective), effective / np.abs(effective)
    terms = model.table.terms(size)
    apart = detuning(model, now.frequency)
    force = (terms[: model.modes] + model.table.detuning_at(size) @ apart) * unit
    for term, T in zip(model.combinations, terms[model.modes :], strict=False):
        angle = term.n * now.angle[0] + term.m * now.angle[1] - now.angle[term.mode]
        force[term.mode] += T * unit[0] ** term.n * unit[1] ** term.m * np.exp(1j * angle)
    return coupling_factor(model.reduced, now.frequency) * force


def rate_of(model, t, a, forcing):
    """Return da/dt; `forcing` gives the Forcing at a time."""

    def driven(t, a):
        now = forcing(t)
        forces = 0.5 * now.force + contact_force(model, a, now)
        return forces / mass_and_slow_root(model.reduced, now.frequency)[0]

    frequency = forcing(t).frequency
    mass, slow = mass_and_slow_root(model.reduced, frequency)
    v = slow * a + driven(t, a)
    if model.reduced.formulation == "paper":
        return v
    h = 1e-3
    after, before = (driven(t + s, a + s * v) for s in (h, -h))
    effective_after, effective, effective_before = (
        effective_amplitude(model, a + s * v, forcing(t + s)) for s in (h, 0.0, -h)
    )
    size = np.abs(effective)
    growth = (np.abs(effective_after) - np.abs(effective_before)) / (2 * h)
    rotation = np.angle(effective_after / effective_before) / (2 * h)
    rotated, unrotated = detuning(model, frequency + rotation), detuning(model, frequency)
    behind = (
        model.table.rate_correction_at(size) @ growth
        + model.table.detuning_at(size) @ (rotated - unrotated)
    ) * (effective / size)
    rate_correction = coupling_factor(model.reduced, frequency) * behind
    return v - ((after - before) / (2 * h) - rate_correction) / mass


@pytest.mark.oracle
@pytest.mark.parametrize("name", ["paper_model", "two_mode_model"])
def test_the_flow_is_that_of_an_independent_integrator(name, request):
    model = request.getfixturevalue(name)
    assert bool(model.combinations) == (name == "two_mode_model")
    start, times = np.array([0.3 - 0.2j, 0.1j]), np.array([40.0])
    phases = {"phase_A": 0.4, "phase_B": -0.7}
    found = run(*(model, FORCES, times, start), tolerance=1e-10, **NEAR_PEAKS | SWEEPS | phases)
    phase = np.array([0.4, -0.7])

    def rate(t, y):
        forcing = lambda t: Forcing.at(model, t, phase)  # noqa: E731
        return rate_of(model, t, y.view(complex), forcing).view(float)

    exact = solve_ivp(rate, (0.0, 40.0), start.view(float), rtol=1e-8, atol=1e-10)
    assert largest_difference(amplitudes(found)[-1], exact.y[:, -1].copy().view(complex)) < 1e-6


@pytest.mark.oracle
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_the_error_of_a_transient_converges_with_the_tolerance(two_mode_model, tolerance):
    times = np.arange(1.0, 301.0)
    found, exact = (
        amplitudes(run(two_mode_model, FORCES, times, tolerance=tol, **NEAR_PEAKS))
        for tol in (tolerance, 1e-12)
    )
    # Errors of the single steps add up over some ten relaxation times.
    assert largest_difference(found, exact) < 10 * tolerance


@pytest.mark.oracle
def test_a_phase_that_turns_is_a_frequency_that_is_shifted(paper_model):
    """F exp(i nu t) at Omega is F at Omega + nu, in a frame that turns with nu."""
    end, nu = 60.0, 0.01
    turning, shifted = (
        amplitudes(run(paper_model, FORCES, [end], tolerance=1e-10, **NEAR_PEAKS | change))[-1]
        for change in ({"phase_rate_A": nu}, {"frequency_A": NEAR_PEAKS["frequency_A"] + nu})
    )
    assert largest_difference(turning, shifted * np.exp(1j * np.array([nu * end, 0.0]))) < 1e-8


def under_phases(model, psi):
    phases = {"phase_A": psi[0], "phase_B": psi[1]}
    times = np.linspace(10.0, 200.0, 20)
    return amplitudes(run(model, FORCES, times, tolerance=1e-10, **NEAR_PEAKS, **phases))


@pytest.mark.oracle
def test_the_phases_of_the_forces_turn_the_amplitudes(paper_model, two_mode_model):
    """With combination resonances only one turn of both phases is left: 5 t_A - 3 t_B stays."""
    psi = np.array([-2.0, 1.1])
    plain, turned = (under_phases(paper_model, phases) for phases in ((0.0, 0.0), psi))
    assert largest_difference(turned, plain * np.exp(1j * psi)) < 1e-8
    assert {(term.mode, term.n, term.m) for term in two_mode_model.combinations} == {
        (0, -4, 3),
        (1, 5, -2),
    }
    plain, kept, changed = (
        under_phases(two_mode_model, (s, u)) for s, u in ((0.0, 0.0), (2.1, 3.5), (2.1, 2.8))
    )
    assert largest_difference(kept, plain * np.exp(1j * np.array([2.1, 3.5]))) < 1e-8
    # A beat of 0.1 % in another phase.
    assert largest_difference(changed, plain * np.exp(1j * np.array([2.1, 2.8]))) > 1e-4


@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def error_of_a_sweep(rate):
    """RMS error where Omega passes omega, against q'' + gamma q' + omega^2 q = F cos theta."""
    reduced = rom.reduce(rom.two_mass(beta=0.2), modes=(0,))
    stuck = rom.tabulate(reduced, rom.Coulomb(1e6), (20.0,), tolerance=0.1)
    (omega,), (gamma,) = reduced.frequency, reduced.modal_damping
    start, times = omega - 100 * rate, np.linspace(0, 200, 401)[1:]
    found = run(stuck, ({0: 1.0},), times, force_A=1.0, frequency_rate_A=rate,
                frequency_A=start + rate * (times - 0.5))  # fmt: skip

    def oscillator(t, y):
        force = np.cos(start * t + 0.5 * rate * t**2)
        return y[1], force - gamma * y[1] - omega**2 * y[0]

    q = solve_ivp(oscillator, (0.0, 200.0), (0, 0), t_eval=times, rtol=1e-8, atol=1e-10).y[0]
    motion = 2 * np.real(amplitudes(found)[:, 0] * np.exp(1j * found["theta_A"]))
    late = times > 100  # the start has decayed
    return np.sqrt(np.mean((motion - q)[late] ** 2) / np.mean(q[late] ** 2))


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_second_order_in_the_rate_of_a_sweep():
    """The frame turns with the sweep; without its term i Omega' the error is of order 1."""
    errors = [error_of_a_sweep(rate) for rate in (2e-3, 1e-3)]
    assert errors[1] < 2e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


@pytest.mark.oracle
def test_what_comes_in_over_a_beat_leaves_through_damping_and_contacts(two_mode_model):
    """The energy of the modes, |v|^2 + omega^2 |a|^2, comes and goes with combinations."""
    model, Omega = two_mode_model, np.array([0.98, 1.65])
    beat = 2 * np.pi / abs(5 * Omega[0] - 3 * Omega[1])
    times = 5000.0 + beat / 256 * np.arange(257)
    found = run(model, FORCES, times, tolerance=1e-10, **NEAR_PEAKS)
    modal = np.array([0.15, 0.25]) * [model.reduced.modal_force(j, FORCES[j]) for j in (0, 1)]
    leaves, energy = [], []
    for a, *angle in zip(amplitudes(found), found["theta_A"], found["theta_B"], strict=True):

        def forcing(t, angle=tuple(angle)):
            return Forcing(modal, Omega, np.array(angle) + Omega * t)

        v = rate_of(model, 0.0, a, forcing) + 1j * Omega * a
        structure = 2 * model.reduced.modal_damping @ np.abs(v) ** 2
        leaves.append(structure - 2 * np.real(v.conj() @ contact_force(model, a, forcing(0.0))))
        energy.append(np.sum(np.abs(v) ** 2 + (model.reduced.frequency * np.abs(a)) ** 2))
    assert np.ptp(energy) > 1e-4 * energy[0]
    assert energy[-1] == pytest.approx(energy[0], rel=1e-8)
    # The second derivative is taken to first order.
    assert found["input_power"][1:].mean() == pytest.approx(np.mean(leaves[1:]), rel=1e-8)
