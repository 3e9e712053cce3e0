"""The amplitude equations: tolerances of transients, phases and sweeps."""

import numpy as np
import pytest
from beside_oracle import amplitudes, run
from scipy.integrate import solve_ivp

from slipmode import rom

pytestmark = pytest.mark.quick

FORCES = ({0: 1.0}, {1: 1.0})
NEAR_PEAKS = {"force_A": 0.15, "force_B": 0.25, "frequency_A": 0.98, "frequency_B": 1.65}


def largest_difference(amplitude, exact):
    return np.abs(amplitude - exact).max() / np.abs(exact).max()


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
