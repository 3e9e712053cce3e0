"""Several modes on one tone: close and equal frequencies under one force."""

import re
import warnings
from functools import cache

import numpy as np
import pytest
from beside_oracle import demodulated
from oracles.families import close_modes
from oracles.harmonic_balance import balance
from oracles.system import System, jenkins

from slipmode import fmu, rom

DISTANCES = 0.0, 1e-4, 3e-3, 0.01, 0.03, 0.1


def reduced(system, modes):
    """A structure of the oracles on one tone, and its law."""
    laws = [rom.Sliders(each.limits, each.stiffnesses) for each in system.laws]
    law = rom.Contacts([(each, [contact]) for contact, each in enumerate(laws)])
    matrices = {"mass": system.M, "damping": system.C, "stiffness": system.K}
    structure = rom.Structure(**matrices, contact=system.W)
    tones = (0,) * len(modes)
    return rom.reduce(structure, modes, law=law, tones=tones, warned=False), law


def balanced(model, system, Omega, force):
    """Amplitudes of modes and DOFs by harmonic balance, and what half the harmonics change."""
    rows = 0.5 * model.reduced.mode_shapes.T @ system.M
    fine, coarse = (balance(system, Omega, force, H)[1] for H in (23, 11))
    return rows @ fine, 0.5 * fine, np.abs(rows @ (fine - coarse)).max()


@pytest.mark.oracle
@pytest.mark.parametrize(
    "seed", [*range(6), *(pytest.param(k, marks=pytest.mark.slow) for k in range(6, 12))]
)
def test_steady_states_of_two_close_modes(seed):
    """Within 1e-5, and harmonic balance with 23 harmonics within 3e-5."""
    case = close_modes(seed, DISTANCES[seed % 6])
    (tone,) = case.tones
    model = rom.tabulate(*reduced(case.system, case.modes))
    expected, _, own = balanced(model, case.system, tone.Omega, tone.F)
    a = rom.steady(model, [tone.Omega], [tone.F.real])
    assert np.abs(a - expected).max() < 2e-5 * np.abs(expected).max() + own, case.name


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("seed", "share"),
    [(1, 0.03), (2, 0.3), *(pytest.param(k, 0.03, marks=pytest.mark.slow) for k in (0, 3, 5))],
)
def test_amplitudes_from_rest(seed, share):
    """Within 0.4 % at 3 % of the stiffness; beyond 1 %, a warning states the error."""
    case = close_modes(seed, DISTANCES[seed], (share, share * 1.001))
    (tone,), periods = case.tones, 120
    model = rom.tabulate(*reduced(case.system, case.modes))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        flow = rom.tone_flow(model, tone.Omega, tone.F.real)
    stated = [float(re.search("about ([0-9.]+) %", str(each.message))[1]) for each in caught]
    flow.step(0.0, magnitude=1.0)
    period, found = 2.0 * np.pi / tone.Omega, []
    for k in range(periods):  # in the middle of the samples of a period
        flow.step(period * (1.0 if k else 0.5 + 0.5 / 32))
        found.append(flow.modal_amplitude()[:2])
    shapes = model.reduced.mode_shapes.T
    expected = [
        demodulated(case.system, each, tone.Omega, tone.F, 0.0, periods) for each in shapes
    ]
    off = np.linalg.norm(np.array(found) - np.transpose(expected)) / np.linalg.norm(expected)
    assert off < 0.01 * max(stated, default=1.0)
    assert share < 0.1 or stated


def plate(contacts, share):
    """A nearly square, simply supported plate: modes 4 to 8 are within 12 %.

    The last two are near three times their frequencies.
    """
    orders = [(1, 7), (7, 1), (5, 5), (4, 6), (6, 4), (3, 6), (6, 3), (2, 7), (7, 2), (4, 5),
              (5, 4), (1, 6), (6, 1), (5, 6), (12, 3), (11, 6)]  # fmt: skip
    m, n = np.transpose(orders)
    omega = 0.1 * (m**2 + (1.01 * n) ** 2)
    x, y = np.random.default_rng(1).uniform(0.1, 0.9, (2, contacts + 1))
    shapes = 2.0 * np.sin(np.pi * np.outer(m, x)) * np.sin(np.pi * np.outer(n, y))
    k = share * omega[0] ** 2 / np.mean(np.sum(shapes[:5, :contacts] ** 2, axis=1))
    laws = [jenkins(0.3 * k, k)] * contacts
    system = System(
        np.eye(m.size), np.diag(0.006 * omega), np.diag(omega**2), shapes[:, :contacts], laws
    )
    return system, shapes[:, -1]


@pytest.mark.slow
@pytest.mark.oracle
@pytest.mark.parametrize(("contacts", "share"), [(3, 0.03), (12, 0.3)])
def test_curves_of_five_modes_of_a_plate(contacts, share):
    """Amplitudes within 4e-5, displacements too, also at 1:3; their error is stated."""
    system, shape = plate(contacts, share)
    force = 3.0 * shape + 1.5j * system.W[:, 0]  # at two points, a quarter of a period apart
    model = rom.tabulate(*reduced(system, range(4, 9)))
    low, *_, high = model.reduced.frequency
    curve = rom.tone_curve(model, force, (0.97 * low, 1.02 * high))
    for Omega in (1.02 * low, *(system.K.diagonal()[-2:] ** 0.5 / 3.0)):
        point = np.abs(curve.frequency - Omega).argmin()
        Omega = curve.frequency[point]
        expected, moved, own = balanced(model, system, Omega, force)
        off = np.abs(curve.amplitude[point] - expected).max()
        assert off < curve.error[point].max() + own
        assert curve.error[point].max() < 1e-3 * np.abs(expected).max()
        found = np.array([curve.displacement(dof)[point] for dof in range(moved.size)])
        assert np.abs(found - moved).max() < 1e-4 * np.abs(moved).max()


@pytest.mark.oracle
def test_stuck_contacts_leave_the_linear_response():
    """Of a floating structure with one damper, which couples all modes."""
    M, springs = np.diag([50.0, 1.0, 1.0]), np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]).T
    K, C = springs @ springs.T, 0.02 * np.outer(springs[:, 0], springs[:, 0])
    system = System(M, C, K, springs, [jenkins(1e6, 0.1)] * 2)
    model, force = rom.tabulate(*reduced(system, (1, 2))), np.array([1.0, 0.5j, 2.0 - 1.0j])
    omega = model.reduced.frequency
    curve = rom.tone_curve(model, force, omega * [0.98, 1.02])
    dynamic = [system.stuck() - w**2 * M + 1j * w * C for w in curve.frequency]
    expected = np.array([np.linalg.solve(each, 0.5 * force) for each in dynamic])
    found = np.transpose([curve.displacement(dof) for dof in range(3)])
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    flow = rom.tone_flow(model, curve.frequency[0], force)
    flow.step(0.0, magnitude=1.0)
    flow.step(3e4)
    assert np.abs(flow.displacement() - expected[0]).max() < 1e-5 * np.abs(expected).max()


SYSTEM, SHAPE = plate(3, 0.03)
LAW = rom.Jenkins(1.0, 1.0)


def reduce(modes=(4, 5), tones=(0, 0), law=LAW, **options):
    structure = rom.Structure(
        mass=SYSTEM.M, damping=SYSTEM.C, stiffness=SYSTEM.K, contact=SYSTEM.W
    )
    return rom.reduce(structure, modes, law=law, tones=tones, warned=False, **options)


@cache
def made(model):
    return fmu.Component(model, [SHAPE], warned=False)


def at_resonance():
    two = {"mass": np.eye(2), "stiffness": np.eye(2), "damping": np.zeros((2, 2))}
    reduced = rom.reduce(rom.Structure(**two, contact=[0, 1]), (0, 1), law=LAW, tones=(0, 0))
    rom.steady(rom.tabulate(reduced, LAW), reduced.frequency[:1], [{0: 1.0}])


@pytest.fixture(scope="module")
def model():
    return rom.tabulate(reduce(), LAW)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_components_are_flows_whose_force_does_the_work_of_friction_and_dampers(model):
    """In a steady state, with limits, forces and phases that moved; jumps leave displacements."""
    of = {"tolerance": model.tolerance, "contact": True, "elastic": (0, 3)}
    made, flow = fmu.Component(model, [SHAPE], **of), rom.tone_flow(model, model.middle, SHAPE)
    flow.step(0.0, magnitude=2.0, frequency=4.9, phase=0.4)
    flow.step(50.0, magnitude=4.0, phase=-0.2)
    made.set_inputs(force_A=4.0, frequency_A=4.9, phase_A=0.4, limit_scale=2.0)
    made.set_inputs(force_rate_A=0.08, phase_rate_A=-0.012)
    made.do_step(0.0, 50.0)
    before, turn = made.outputs(), 4.0 * np.exp(1j * flow.angle)
    for mode, a in zip(("A", "A2"), flow.modal_amplitude(), strict=False):
        assert before[f"{mode}_re"] + 1j * before[f"{mode}_im"] == pytest.approx(2.0 * a, rel=1e-6)
    assert before["x_3"] == pytest.approx((turn * flow.displacement()[3]).real, rel=1e-6)
    made.set_inputs(force_A=12.0, phase_A=2.0, force_rate_A=0.0, phase_rate_A=0.0)
    after = made.outputs()
    assert after["x_3"] == pytest.approx(before["x_3"], rel=0.02)
    flow.step(0.0, magnitude=6.0, phase=2.0)
    flow.step(2000.0)
    made.do_step(50.0, 2000.0)
    now, c = made.outputs(), 2.0 * flow.displacement()
    a = rom.steady(model, [4.9], [6.0 * SHAPE], 2.0)
    assert np.abs(flow.modal_amplitude()[:2] - a).max() < 0.01 * np.abs(a).max()
    damped = 2.0 * 4.9**2 * (c.conj() @ SYSTEM.C @ c).real
    assert now["input_power"] == pytest.approx(damped + now["dissipated_power"], rel=2e-3)
    assert now["dissipated_power"] > 0.1 * damped


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda _: reduce((0, 4, 5), (0, 0, 0)), "tones: mode 0 at .* rad/s and mode 5 at .*15 %"),
        (lambda _: reduce((0, 1, 2), None), r"modes: must be one or two .*tones=\(0, 0, ...\)"),
        (lambda _: reduce((0, 4, 5), (0, 0, 1)), "tones: mode 0 at .* rad/s and mode 4 at .*15 %"),
        (lambda _: reduce((4, 0, 5), (0, 1, 0)), "tones: must have the modes of tone 0 first"),
        (lambda _: reduce(tones=(0,)), "tones: must be 2 numbers, the tone 0 or 1"),
        (lambda _: reduce(range(41), (0,) * 41), "modes: at most 40 modes share a tone, got 41"),
        (lambda _: reduce(ratio=3), "ratio, tones: leave one out"),
        (lambda _: reduce((4,), None, ratio=3), "ratio = 3: needs two modes, A and B"),
        (lambda _: reduce(tones=None, ratio=1), "ratio: must be a ratio of integers up to 9"),
        (lambda _: reduce(tones=None, ratio=2), "ratio = 2: .* the ratio must be of two odd"),
        (lambda _: reduce(tones=None, ratio=3), r"ratio = 3: 3 times .* % from mode 5"),
        (lambda _: reduce(tones=None, ratio=3, carrier=(5, 15)), "carrier: must be one freq"),
        (lambda _: reduce(law=None), "law: .* slide and do not lift off .*got None"),
        (lambda _: reduce(carrier=(1.0, 1.0)), "carrier: must be left out if several modes share"),
        (lambda _: rom.tabulate(reduce(), LAW, (1.0, 1.0)), "amplitude: must be left out"),
        (lambda _: rom.tabulate(reduce(tones=None), LAW), "amplitude: is missing"),
        (
            lambda _: rom.steady_state(reduce(), LAW, [4.8], [SHAPE]),
            "reduced: must be of one mode",
        ),
        (lambda m: rom.steady(m, [50.0], [SHAPE]), "frequency: must be .*mode A resonates"),
        (lambda m: rom.steady(m, [4.8], [SHAPE, SHAPE]), "force: needs one entry"),
        (lambda m: rom.steady(m, [4.8], {0: 1.0j}), "force: needs one entry"),
        (lambda m: rom.steady(m, [4.8, 4.9], [SHAPE]), "frequency: .* last axis of length 1"),
        (lambda m: rom.tone_curve(m, SHAPE, (5.0, 4.5)), "span: must be two increasing"),
        (lambda m: rom.response_curve(m, [5.0], [SHAPE], "force", (1.0, 2.0)), "use rom.steady"),
        (lambda m: fmu.Component(m), "force_patterns: is missing"),
        (lambda m: made(m).set_inputs(frequency_A=4.0), "frequency_A: must be within 10 % of"),
        (lambda m: made(m).reset(amplitude=[1e-5]), "amplitude: must be 0; modes"),
        (lambda m: made(m).transient_error(), "transient_error: is not available"),
        (lambda _: at_resonance(), "frequency = .*: is the natural frequency of a mode without"),
    ],
)
def test_wrong_tones_are_refused(call, message, model):
    with pytest.raises(rom.SlipmodeError, match=message):
        call(model)
