"""Power in steady motion with elastic contacts: what goes in is what dampers and friction take."""

import numpy as np
import pytest
import scipy.linalg

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation, SlowTrajectory, reconstruct
from slipmode.rom.reduction.reaction import reaction_stiffness

LIMIT, STIFFNESS = 0.01, 2.0
LAW = rom.Jenkins(LIMIT, STIFFNESS)


def oscillator(coupling, law, damping=(0.001, 0.02)):
    """A mass on a spring, and a light one on the contacts beside it; modal damping."""
    K = np.array([[1.0, -coupling], [-coupling, 1.5]])
    M, W = np.diag([1.0, 0.01]), np.array([[0.0], [1.0]])
    squares, shapes = scipy.linalg.eigh(K + W @ np.diag(law.elements(1).reference) @ W.T, M)
    C = M @ (shapes * (np.array(damping) * np.sqrt(squares))) @ shapes.T @ M
    return rom.Structure(M, K, 0.5 * (C + C.T), contact=W)


def at_resonance(structure, law, detuning):
    carrier = detuning * rom.reduce(structure, (0,), law=law).frequency
    # modes that respond less have harmonics beyond those that are solved for
    return rom.reduce(structure, (0,), law=law, carrier=carrier, smallest_response=1e-3)


def imbalance(steps):
    """Of the powers at one amplitude, relative; and how far the contact slides."""
    reduced, a = at_resonance(oscillator(0.1, LAW), LAW, 0.99), 0.5
    Omega, omega, gamma = reduced.carrier[0], reduced.frequency[0], reduced.modal_damping[0]
    terms = ContactProblem.of(reduced, LAW).on(Discretisation(steps, 1), 1e-11).solve([[a]])
    force = 2.0 * ((omega**2 - Omega**2 + 1j * gamma * Omega) * a - terms.S[0, 0])
    input_power = Omega * a * force.imag
    # what moves the contact besides its own force: the mode, and responses to that force
    angle = np.linspace(0.0, 2.0 * np.pi, 200_000, endpoint=False)
    moved = -2.0 * np.real(a * reduced.coupling[0, 0] * np.exp(1j * angle))
    dampers = 2.0 * gamma * (Omega * a) ** 2
    for order, P in zip(terms.orders, terms.P[0, :, 0], strict=True):
        n, back = order[0], reaction_stiffness(reduced, (order,))[0, 0, 0] * P
        moved += 2.0 * np.real(back * np.exp(1j * n * angle))
        dampers -= 2.0 * np.real(back * np.conj(1j * n * Omega * P))
    flexibility = -reduced.stiffness[0, 0]
    X = (moved.max() - flexibility * LIMIT) / (1.0 - flexibility * STIFFNESS)
    loop = 4.0 * LIMIT * (X - LIMIT / STIFFNESS)  # Masing's, in closed form
    friction = loop * Omega / (2.0 * np.pi)
    assert friction > 0.5 * dampers
    return (input_power - dampers - friction) / friction, X * STIFFNESS / LIMIT


def test_power_balances_in_a_contact_problem_that_is_solved_tightly():
    """Harmonics, which the slow flow has, against the loop that they draw in time."""
    error, slid = imbalance(8192)
    assert slid > 10.0
    assert abs(error) < 1e-6
    assert abs(imbalance(64)[0]) > 5e-6  # it is not so by construction


def steady_powers(structure, law, reduced, force, reach):
    """Input as a table of tolerance 1e-3 tells it; dampers, friction as a march does [W]."""
    Omega, steps, periods = reduced.carrier[0], 1024, 60
    model = rom.tabulate(reduced, law, (reach,), tolerance=1e-3, harmonics=7)
    a = rom.steady(model, reduced.carrier, (force,))
    F, period = reduced.modal_force(0, force), 2.0 * np.pi / Omega
    time = period * np.arange(periods + 1)
    trajectory = SlowTrajectory(
        time=time,
        amplitude=np.tile(a, (periods + 1, 1)),
        angle=Omega * time[:, np.newaxis],
        frequency=np.full((periods, 1), Omega),
        frequency_rate=np.zeros((periods, 1)),
        force=np.full((periods, 1), F, dtype=complex),
        force_rate=np.zeros((periods, 1), dtype=complex),
    )
    times = time[-2] + period / steps * np.arange(steps + 1)
    motion = reconstruct(model, trajectory, times, steps_per_period=steps, spin_up=40.0)
    x = motion.elastic(model, range(structure.n_dofs))[:-1]
    nu = 1j * Omega * np.fft.fftfreq(steps, 1.0 / steps)[:, np.newaxis]
    v = np.fft.ifft(nu * np.fft.fft(x, axis=0), axis=0).real
    dampers = np.mean(np.einsum("ti,ij,tj->t", v, structure.damping, v))
    middle = 0.5 * (motion.force[1:] + motion.force[:-1])
    friction = np.sum(middle * np.diff(motion.displacement, axis=0)) / period
    return -F * Omega * a[0].imag, dampers, friction


def test_power_balances_in_a_steady_state_to_the_tolerance_of_its_table():
    """By the motion of the structure in time: velocities of all DOFs, force on the contact."""
    law = rom.Jenkins(0.5, 20.0)
    structure = oscillator(1.0, law, (0.02, 0.02))
    reduced = at_resonance(structure, law, 0.97)
    given, dampers, friction = steady_powers(structure, law, reduced, {0: 0.1}, 1.0)
    assert dampers > 0.1 * given
    assert friction > 0.5 * given
    assert given == pytest.approx(dampers + friction, rel=2e-3)
