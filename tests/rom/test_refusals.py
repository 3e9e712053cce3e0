"""Refusals of the public functions: one line that names the argument and what it may be."""

import numpy as np
import pytest
from written.matrices import beam

from slipmode import fmu, rom
from slipmode.rom import Rayleigh, Structure, full

pytestmark = pytest.mark.quick

TWO = rom.two_mass(beta=0.01)
OMEGA, FORCE = (0.98, 1.65), ({0: 0.15}, {1: 0.25})
MASS = np.diag([1.0, 2.0, 1.5])
STIFFNESS = 2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
FLOATING = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
K, M = beam(3)  # rotations without mass
JENKINS = rom.Jenkins(1.0, 10.0)


def changed(matrix, i, j, value):
    matrix = np.array(matrix, dtype=float)
    matrix[i, j] = value
    return matrix


def of_structure(**given):
    arguments = {"mass": MASS, "stiffness": STIFFNESS, "contact": [2]} | given
    return lambda: Structure(**arguments)


def of_beam(**given):
    return of_structure(**{"mass": M, "stiffness": K, "contact": [0]} | given)


LOOSE, DAMPER = K.copy(), np.zeros((6, 6))
LOOSE[1::2, :] = LOOSE[:, 1::2] = 0.0
LOOSE[1::2, 1::2] = 1.0
DAMPER[3, 3] = 1.0

WITHOUT_MODEL = [
    (of_structure(mass=MASS[:2]), "mass: must be square, got 2 x 3"),
    (of_structure(mass=[[1.0], [1.0, 2.0]]), "mass: rows must all have the same length"),
    (of_structure(mass=changed(MASS, 0, 1, 0.1)), "mass: must be symmetric"),
    (of_structure(mass=changed(MASS, 0, 0, -1.0)), "mass: must be positive definite"),
    (of_structure(mass=MASS.astype(str)), "mass: must hold real numbers"),
    (of_structure(mass=changed(MASS, 0, 0, 1e-300)), "mass: every DOF needs at least 1e-30"),
    (of_structure(stiffness=np.eye(2)), "stiffness: must be 3 x 3 like mass"),
    (of_structure(damping=-0.01), "damping: beta must be a finite number >= 0"),
    (of_structure(damping=changed(np.eye(3), 1, 1, -1e-6)), "damping: must be positive semi"),
    (of_structure(contact=[]), "contact: must name at least one DOF"),
    (of_structure(contact=[3]), "contact: DOF 3 is out of range, allowed: 0 to 2"),
    (of_structure(contact=np.ones((2, 1))), "contact: W must have 3 rows"),
    (of_structure(contact=np.ones((3, 2))), "contact: directions (columns of W) must be linearly"),
    (lambda: rom.Labels([7, 7], [1, 1]), "labels: node 7 has direction x twice"),
    (lambda: rom.Labels([1], ["z"]), "labels.direction: must be integers, 1 to 6 for x, y, z, rx"),
    (lambda: TWO.save("/absent/structure.npz"), "/absent/structure.npz: cannot be written"),
    (of_structure(stiffness=(1 - 0.1j) * STIFFNESS), "stiffness: the imaginary part must be"),
    (of_structure(stiffness=1.1j * STIFFNESS, damping=rom.LossFactor(0.1)), "damping: leave the"),
    (lambda: rom.LossFactor(-0.1), "damping: eta must be a finite number >= 0"),
    # DOFs without mass
    (of_beam(damping=DAMPER), "damping: DOF 3 has no mass"),
    (of_beam(stiffness=changed(K, slice(None), 5, 0.0) * np.outer([1] * 5 + [0], [1] * 6)),
     "mass, stiffness: DOF 5 has neither mass nor stiffness"),
    (of_beam(stiffness=LOOSE), "stiffness: must be positive definite on the 3 DOFs without mass"),
    (of_beam(mass=changed(changed(M, 0, 1, 0.01), 1, 0, 0.01)),
     "mass: must be positive definite, except for DOFs without mass"),
    (lambda: rom.reduce(Structure(M, K, contact=[0]), (3,), law=JENKINS), "modes: must be 0 to 2"),
    # Damping
    (lambda: Rayleigh(-0.1, 0.0), "damping: alpha must be a finite number >= 0"),
    (lambda: Rayleigh.from_ratios((0.01, 0.1), (1.0, 2.0)), "ratio: with alpha M + beta K the"),
    # Reductions and modes
    (lambda: rom.reduce(TWO, (0, 2)), "modes: must be 0 to 1"),
    (lambda: rom.reduce(TWO, formulation="exact"), "formulation: must be 'consistent' or 'paper'"),
    (lambda: rom.reduce(TWO, formulation="paper", carrier=OMEGA),
     'carrier: the "paper" formulation solves contacts at the natural frequencies; leave'),
    (lambda: rom.reduce(TWO, formulation="paper", aerodynamics=(1j, 1j)),
     "aerodynamics: formulation must be"),
    (lambda: rom.reduce(TWO, carrier=(0.98, 0.26)),
     "carrier: must be 1.06 to 17 rad/s, because mode B resonates at 1.7 rad/s; got 0.26"),
    (lambda: rom.reduce(TWO, aerodynamics=(0.0, -3.0)),
     "aerodynamics: the real part for mode B must be above -omega^2 = -2.89"),
    (lambda: rom.reduce(Structure(np.eye(3), FLOATING, contact=[2]), (0,)),
     "stiffness: must be positive definite with bonded contacts, but the structure then has"),
    (lambda: rom.reduce(Structure(np.eye(2), np.eye(2), contact=[0, 1])),
     "contact: all 2 DOFs are contacts, so there is no mode with rigid friction"),
    (lambda: rom.modes(TWO, rom.Coulomb(2.0)), "law: must be elastic; leave it out"),
    # Laws, combination resonances and others
    (lambda: rom.Tanh(2.0, "x"), "alpha: must be real numbers"),
    (lambda: rom.Coulomb(-1.0), "limit: must be 0 or 1e-30 to"),
    (lambda: rom.CombinationResonance(0, 1, 32), "m: must be an integer from -31 to 31, got 32"),
    (lambda: rom.CombinationResonance(1, 0, 1), "n, m: (0, 1) is the carrier of mode B"),
    (lambda: rom.combination_resonances((1, 2, 3)), "frequencies: must be finite numbers > 0"),
    (lambda: full.Excitation.harmonic(TWO, 3.0, OMEGA), "force: must be one or two forces"),
]  # fmt: skip


def check(call, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        call()
    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("call", "message"), WITHOUT_MODEL)
def test_arguments_without_a_model(call, message):
    check(call, message)


def steady(force=FORCE, frequency=OMEGA, **named):
    return lambda of: rom.steady(of, frequency, force, **named)


CONTACT_FORCE = ({0: 0.15}, {1: 0.25, 2: 0.25})
WITH_MODEL = [
    (steady(phase=(0.1, 0.2, 0.3)), "phase: must be"),
    (steady(3.0), "force: needs one entry per mode (2), each {DOF: amplitude} or an array of 4"),
    (steady([{"x": 1.0}, {}]), "force: DOF 'x' is out of range, allowed: 0 to 3"),
    (
        lambda of: fmu.Component(of, CONTACT_FORCE),
        "force_patterns: the forces also act on the contacts directly",
    ),
    (lambda of: rom.reduce(TWO, force_patterns=[{99: 1.0}, {}]), "force_patterns: DOF 99 is out"),
    (steady(frequency="abc"), "frequency: must be real numbers"),
    (lambda of: rom.resonance(of, FORCE, 0.98, (1.6, 1.7)), "frequency_A: must be a sequence"),
    (lambda of: rom.response_curve(of, OMEGA, FORCE, "force", 3), "span: must be two finite"),
    (lambda of: rom.backbone(of, 0, -1.0), "other: must be a number >= 0"),
    (lambda of: rom.backbone(of, 2), "mode: must be 0 to 1, got 2"),
    (lambda of: rom.resonance_curve(of, 0, FORCE[0], [1.0, 2.0]),
     "amplitudes: must have shape (n, 2), one column per mode, got"),
    (lambda of: rom.steady_state(of.reduced, "tanh", OMEGA, FORCE),
     "law: must be a contact law (Tanh, Coulomb, Jenkins"),
    (lambda of: of.table(0.5), "amplitudes: the last axis must have length 2"),
    (lambda of: fmu.Component(of).reset(amplitude=(4.0000000001, 0.1)),
     "amplitude: mode A reaches 4.0000000001 kg^1/2 m at the contacts"),
    (lambda of: fmu.Component(of, elastic=["0"], contact=True), "elastic: must be a list of DOFs"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "message"), WITH_MODEL)
def test_arguments_with_a_model(two_mode_model, call, message):
    check(lambda: call(two_mode_model), message)


@pytest.mark.parametrize("value", ["2", None, True, 1j, np.array([1.0]), {}], ids=repr)
def test_a_component_refuses_what_is_no_number_and_stays_as_it_was(two_mode_model, value):
    component, row = fmu.Component(two_mode_model), np.zeros((1, 12))
    check(lambda: component.set_inputs(force_A=value), "force_A: must be a real number, got ")
    check(lambda: component.do_step(value, 1.0), "time: must be a real number, got ")
    check(lambda: component.do_step(0.0, value), "step: must be a real number, got ")
    check(lambda: component.reset(time=value), "time: must be a real number, got ")
    check(lambda: component.run("2", row), "durations: must be real numbers, got ")
    check(lambda: component.run(np.ones(1), {}), "inputs: must be real numbers, got ")
    check(lambda: component.set_state("2"), "state: must be real numbers, got ")
    check(lambda: component.set_amplitude("2"), "amplitude: must be numbers, got ")
    assert component.outputs() == fmu.Component(two_mode_model).outputs()
