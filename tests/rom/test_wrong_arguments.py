"""Wrong arguments of the public functions: one line that names the argument and what it may be."""

import numpy as np
import pytest

from slipmode import fmu, rom
from slipmode.rom.full import Excitation
from slipmode.runner import run_study

pytestmark = pytest.mark.quick

STRUCTURE = rom.two_mass(beta=0.01)
JENKINS = rom.Jenkins(2.0, 50.0)
OMEGA, FORCE = (0.98, 1.65), ({0: 0.15}, {1: 0.25})
NAN = float("nan")


def check(call, message):
    with pytest.raises(rom.SlipmodeError) as refusal:
        call()
    assert str(refusal.value).startswith(message)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "phase", [(), (0.1,), (0.1, 0.2, 0.3), (NAN, 0.0), ("a", "b"), None, [(0.1, 0.2)]]
)
def test_phases_that_do_not_fit(two_mode_model, phase):
    calls = [
        lambda: rom.steady(two_mode_model, OMEGA, FORCE, phase),
        lambda: rom.response_curve(two_mode_model, OMEGA, FORCE, "force", (0.0, 1.0), phase),
        lambda: rom.limit_cycles(two_mode_model, OMEGA, FORCE, phase),
    ]
    for call in calls:
        check(call, "phase: must be")


def test_one_phase_is_that_of_every_force(two_mode_model, one_mode_model):
    turned, both = (rom.steady(two_mode_model, OMEGA, FORCE, phase) for phase in (0.3, (0.3, 0.3)))
    np.testing.assert_array_equal(turned, both)
    alone = rom.steady(one_mode_model, 0.98, FORCE[:1], (0.3,))
    np.testing.assert_array_equal(alone, rom.steady(one_mode_model, 0.98, FORCE[:1], 0.3))


@pytest.mark.parametrize(
    ("force", "message"),
    [
        (3.0, "force: needs one entry per mode (2), each {DOF: amplitude} or an array of 4"),
        (None, "force: needs one entry per mode (2)"),
        ("ab", "force: needs one entry per mode (2)"),
        ({0: 0.1, 1: 0.2}, "force: needs one entry per mode (2)"),
        ([3.0, 2.0], "force: must be 4 finite numbers"),
        (["a", "b"], "force: must be real numbers, got 'a'"),
        ([{"x": 1.0}, {}], "force: DOF 'x' is out of range, allowed: 0 to 3"),
        ([{0.5: 1.0}, {}], "force: DOF 0.5 is out of range"),
        ([{0: "x"}, {}], "force: must be real numbers, got 'x'"),
        ([{0: 1j}, {}], "force: must be real numbers, got 1j"),
        ([{0: [1.0, 2.0]}, {}], "force: must be one number at DOF 0"),
    ],
)
def test_forces_that_are_none(two_mode_model, force, message):
    reduced, law = two_mode_model.reduced, two_mode_model.law
    check(lambda: rom.steady(two_mode_model, OMEGA, force), message)
    check(lambda: rom.steady_state(reduced, law, OMEGA, force), message)
    check(lambda: rom.response_curve(two_mode_model, OMEGA, force, "force", (0, 1)), message)
    of_patterns = message.replace("force: ", "force_patterns: ")
    if force is not None:
        check(lambda: rom.reduce(STRUCTURE, force_patterns=force), of_patterns)
        check(lambda: fmu.Component(two_mode_model, force_patterns=force), of_patterns)


@pytest.mark.parametrize("count", [-1, 0, 1.5, True, "2"])
def test_counts_that_are_none(one_mode_model, count, tmp_path):
    reduced, law = one_mode_model.reduced, one_mode_model.law
    must = "must be an integer >= 1, got"
    check(lambda: rom.tabulate(reduced, law, (4.0,), threads=count), f"threads: {must}")
    check(lambda: run_study(tmp_path / "none.toml", workers=count), f"workers: {must}")
    check(lambda: rom.modes(STRUCTURE, n=count), f"n: {must}")


@pytest.mark.parametrize("mode", [2, 5, -1, 0.5, "A"])
def test_modes_that_are_not_there(two_mode_model, mode):
    for call in (
        lambda: rom.resonance_curve(two_mode_model, mode, FORCE[0], [[1.0, 0.0]]),
        lambda: rom.backbone(two_mode_model, mode),
    ):
        check(call, f"mode: must be 0 to 1, got {mode!r}")


@pytest.mark.parametrize(
    ("amplitudes", "message"),
    [
        ([1.0, 2.0], "amplitudes: must have shape (n, 2), one column per mode, got shape (2,)"),
        ([], "amplitudes: must have shape (n, 2)"),
        ("ab", "amplitudes: must be real numbers"),
        ([[0.0, 1.0]], "amplitudes: must be finite and >= 0, and > 0 for mode A"),
        ([[-1.0, 1.0]], "amplitudes: must be finite and >= 0"),
        ([[1.0, -1.0]], "amplitudes: must be finite and >= 0"),
        ([[1.0, NAN]], "amplitudes: must be finite and >= 0"),
    ],
)
def test_amplitudes_of_a_resonance_curve(two_mode_model, amplitudes, message):
    check(lambda: rom.resonance_curve(two_mode_model, 0, FORCE[0], amplitudes), message)


def test_with_one_mode_amplitudes_of_a_resonance_curve_may_be_a_row(one_mode_model):
    row, column = (
        rom.resonance_curve(one_mode_model, 0, {0: 0.15}, amplitudes)
        for amplitudes in ([1.0, 2.0], [[1.0], [2.0]])
    )
    np.testing.assert_array_equal(row.above, column.above)


@pytest.mark.parametrize(
    ("mode", "n", "m", "message"),
    [
        (0, 1, 32, "m: must be an integer from -31 to 31, got 32"),
        (0, 1, -40, "m: must be an integer from -31 to 31"),
        (0, 32, 1, "n: must be an integer from -31 to 31"),
        (0, 2.5, 1, "n: must be an integer from -31 to 31"),
        (2, 3, 1, "mode: must be 0 or 1, got 2"),
        (-1, 3, 1, "mode: must be 0 or 1, got -1"),
        (1, 0, 1, "n, m: (0, 1) is the carrier of mode B"),
    ],
)
def test_combination_resonances_that_are_none(mode, n, m, message):
    check(lambda: rom.CombinationResonance(mode, n, m), message)


def test_the_highest_combination_resonance_is_tabulated():
    highest = rom.CombinationResonance(0, 0, -31)
    model = rom.tabulate(
        rom.reduce(STRUCTURE), rom.Coulomb(2.0), (1.0, 0.5), 0.1, combinations=[highest]
    )
    assert model.combinations == (highest,)
    assert model.accuracy.lines > 2 * 31


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda of: rom.steady(of, "abc", FORCE), "frequency: must be real numbers"),
        (lambda of: rom.steady(of, (0.98 + 1j, 1.65), FORCE), "frequency: must be real numbers"),
        (lambda of: rom.resonance(of, FORCE, 0.98, (1.6, 1.7)), "frequency_A: must be a sequence"),
        (lambda of: rom.response_curve(of, OMEGA, FORCE, "force", 3), "span: must be two finite"),
        (
            lambda of: rom.response_curve(of, OMEGA, FORCE, "force", (0, 1), 0.0, "x"),
            "largest_step: must be real numbers",
        ),
        (lambda of: rom.backbone(of, 0, NAN), "other: must be a number >= 0"),
        (lambda of: rom.backbone(of, 0, -1.0), "other: must be a number >= 0"),
        (lambda of: rom.backbone(of, amplitude=[]), "amplitude: must be finite numbers > 0"),
        (lambda of: rom.limit_cycles(of, "x", FORCE), "force: no unforced mode"),
        (
            lambda of: rom.steady_state(of.reduced, "tanh", OMEGA, FORCE),
            "law: must be a contact law (Tanh, Coulomb, Jenkins",
        ),
        (
            lambda of: rom.steady_state(of.reduced, of.law, OMEGA, FORCE, "x"),
            "tolerance: must be real numbers",
        ),
        (
            lambda of: rom.steady_state(of.reduced, of.law, OMEGA, FORCE, start=3),
            "start: must be a SteadyState, got 3",
        ),
        (lambda of: rom.tabulate(of.reduced, "tanh", (4.0, 4.0)), "law: must be a contact law"),
        (lambda of: of.table(0.5), "amplitudes: the last axis must have length 2"),
    ],
)
def test_arguments_with_a_model(two_mode_model, call, message):
    check(lambda: call(two_mode_model), message)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: rom.reduce(STRUCTURE, 0), "modes: must be one or two different modes, got 0"),
        (lambda: rom.reduce(STRUCTURE, "ab"), "modes: must be real numbers"),
        (lambda: rom.reduce(STRUCTURE, (0, 1.5)), "modes: must be integers, got (0, 1.5)"),
        (lambda: rom.reduce(STRUCTURE, carrier="x"), "carrier: must be real numbers"),
        (
            lambda: rom.reduce(STRUCTURE, formulation="paper", carrier=OMEGA),
            'carrier: the "paper" formulation solves contacts at the natural frequencies; leave',
        ),
        (
            lambda: rom.reduce(STRUCTURE, smallest_response="x"),
            "smallest_response: must be real numbers",
        ),
        (lambda: rom.modes(STRUCTURE, n=1.5), "n: must be an integer >= 1, got 1.5"),
        (lambda: rom.modes(STRUCTURE, rom.Coulomb(2.0)), "law: must be elastic; leave it out"),
        (lambda: rom.Tanh(2.0, "x"), "alpha: must be real numbers"),
        (lambda: rom.Jenkins("x", 1.0), "limit: must be real numbers"),
        (lambda: rom.Rayleigh("x", 1.0), "damping: alpha: must be real numbers"),
        (lambda: rom.combination_resonances("x"), "frequencies: must be real numbers"),
        (lambda: rom.combination_resonances((1, 2, 3)), "frequencies: must be finite numbers > 0"),
        (lambda: rom.combination_resonances((NAN, 1)), "frequencies: must be finite numbers > 0"),
        (lambda: rom.combination_resonances(OMEGA, (1.0,)), "until: must be finite numbers > 0"),
        (lambda: rom.load_structure(3), "path: must be a string or a path, got 3"),
        (lambda: rom.Model.load(3), "path: must be a string or a path, got 3"),
        (lambda: Excitation.harmonic(STRUCTURE, 3.0, OMEGA), "force: must be one or two forces"),
        (
            lambda: Excitation.harmonic(STRUCTURE, FORCE, OMEGA, (0.1,)),
            "phase: must be 2 numbers, one per mode",
        ),
    ],
)
def test_arguments_without_a_model(call, message):
    check(call, message)


def test_a_surface_needs_two_modes(one_mode_model):
    call = lambda: rom.resonance(one_mode_model, FORCE[:1], (0.9, 1.0), (1.6, 1.7))  # noqa: E731
    check(call, "model: must be of two modes")


def test_an_amplitude_outside_the_table_is_shown_as_the_contacts_see_it():
    """Most of it is what the force does to the contacts directly; the mode hardly moves."""
    reduced, force = rom.reduce(STRUCTURE, (0,), law=JENKINS), ({2: 5.0},)
    small, large = (rom.tabulate(reduced, JENKINS, (end,), 1e-2) for end in (0.01, 2.51))
    reason = (
        "amplitude: mode A reaches 2.501 kg^1/2 m at the contacts, outside the friction table, "
        "which ends at 0.01 kg^1/2 m; tabulate a larger range"
    )
    check(lambda: rom.steady(small, (5.0,), force), reason)
    assert abs(rom.steady(large, (5.0,), force)[0]) < 0.01


@pytest.mark.parametrize(
    ("amplitude", "message"),
    [
        ((0.1, 6.0), "amplitude: mode B reaches 6 kg^1/2 m at the contacts, outside"),
        ((4.0000000001, 0.1), "amplitude: mode A reaches 4.0000000001 kg^1/2 m at the contacts"),
    ],
)
def test_the_mode_that_is_outside_the_table_is_named(two_mode_model, amplitude, message):
    check(lambda: two_mode_model.table(amplitude), message)
    check(lambda: fmu.Component(two_mode_model).reset(amplitude=amplitude), message)


NOT_NUMBERS = ["2", b"2", None, True, 1j, [1.0], np.array([1.0]), np.array("2"), {}, [[1], [1, 2]]]


@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
def test_inputs_and_steps_that_are_no_numbers(two_mode_model, value):
    component = fmu.Component(two_mode_model)
    check(lambda: component.set_inputs(force_A=value), "force_A: must be a real number, got ")
    check(lambda: component.do_step(value, 1.0), "time: must be a real number, got ")
    check(lambda: component.do_step(0.0, value), "step: must be a real number, got ")
    check(lambda: component.reset(time=value), "time: must be a real number, got ")
    check(lambda: fmu.Component(two_mode_model, tolerance=value), "tolerance: must be a real")
    assert component.outputs() == fmu.Component(two_mode_model).outputs()


@pytest.mark.parametrize("values", ["2", b"2", ["2"], np.array("2"), {}, [[1], [1, 2]]], ids=repr)
def test_arrays_of_a_component_that_are_no_numbers(two_mode_model, values):
    component, row = fmu.Component(two_mode_model), np.zeros((1, 12))
    check(lambda: component.run(values, row), "durations: must be real numbers, got ")
    check(lambda: component.run(np.ones(1), values), "inputs: must be real numbers, got ")
    check(lambda: next(component.trace(values, row)), "durations: must be real numbers, got ")
    check(lambda: component.set_state(values), "state: must be real numbers, got ")
    check(lambda: component.reset(amplitude=values), "amplitude: must be numbers, got ")
    check(lambda: component.set_amplitude(values), "amplitude: must be numbers, got ")


@pytest.mark.parametrize("listed", ["0", None, True, 1j, [0.0], ["0"], [[0]]], ids=repr)
def test_lists_of_a_component_that_are_none(two_mode_model, listed):
    def of(**options):
        return lambda: fmu.Component(two_mode_model, **options)

    check(of(elastic=listed, contact=True), "elastic: must be a list of DOFs, got ")
    check(of(mode_names=listed), "mode_names: must have 2 different names out of A and B, got ")


@pytest.mark.parametrize("value", [1, np.float32(1.0), np.int64(1), np.array(1.0)], ids=repr)
def test_numbers_of_any_kind_are_inputs(two_mode_model, value):
    given, expected = fmu.Component(two_mode_model), fmu.Component(two_mode_model)
    given.set_inputs(force_A=value)
    given.do_step(0, value)
    expected.set_inputs(force_A=1.0)
    expected.do_step(0.0, 1.0)
    assert given.outputs() == expected.outputs()


@pytest.mark.parametrize(
    ("node", "direction", "message"),
    [
        (
            [1],
            ["z"],
            "labels.direction: must be integers, 1 to 6 for x, y, z, rx, ry, rz, got ['z']",
        ),
        ([1], ["3"], "labels.direction: must be integers"),
        ([1.5], [3], "labels.node: must be integers, one per DOF, got [1.5]"),
        ([NAN], [3], "labels.node: must be integers"),
        (None, [3], "labels.node: must be integers"),
        ([[1]], [3], "labels.node: must be integers"),
        ([1, 2], [3], "labels: node and direction must be equally long, got 2 and 1"),
    ],
)
def test_labels_that_are_no_integers(node, direction, message):
    check(lambda: rom.Labels(node=node, direction=direction), message)


def test_labels_may_be_lists():
    assert rom.Labels(node=[11, 12], direction=[3, 3]).dof(12, "z") == 1
