"""The examples run, those of the documentation as they are printed, and keep their numbers."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from slipmode import rom, runner

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_example_of_the_package_runs():
    lines = rom.__doc__.splitlines()
    example = "\n".join(line.strip() for line in lines if " = " in line)
    assert example.count("\n") >= 3
    names = {"rom": rom}
    exec(example, names)
    assert abs(names["a_A"]) > abs(names["a_B"]) > 1.0


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.oracle
def test_a_controlled_friction_limit_makes_the_structure_linear(tmp_path):
    """Peaks of |A| at three forces: in proportion, and no higher than with a fixed limit."""
    peaks = np.array(example("friction_control").main(tmp_path))
    np.testing.assert_allclose(peaks[:, 1] / [0.05, 0.15, 0.45], 19.75, rtol=2e-3)
    assert np.all(peaks[:, 1] < peaks[:, 0])
    (event,) = runner.read(tmp_path / "controlled.mcap").events
    assert event.message == "the friction limit follows |A|"


def test_flutter_has_a_stable_and_an_unstable_limit_cycle_until_friction_is_too_weak():
    held, lost = example("flutter").branches([-0.02j, -0.03j])
    assert [cycle.stable for cycle in held] == [True, False]
    assert lost == ()


@pytest.mark.slow
@pytest.mark.oracle
def test_blocks_on_meshes_that_do_not_match_are_in_equilibrium():
    """Pressed by a uniform pressure; stuck at first, slipping at twice the force."""
    blocks = example("two_blocks")
    _, pairs, _ = blocks.two_blocks()
    assert pairs.area == pytest.approx([0.04 * 0.03 / 4] * 4)
    rest, reduced, (stuck, slipping) = blocks.shaken([1000.0, 2000.0])
    np.testing.assert_allclose(rest.normal_force, 5e7 * pairs.area, rtol=1e-6)
    omega, damping = reduced.frequency[0], reduced.modal_damping[0]
    Omega = blocks.BELOW * omega
    force = 1000.0 * reduced.mode_shapes[:, 0] @ blocks.two_blocks()[2][1]
    linear = 0.5 * force / (omega**2 - Omega**2 + 1j * Omega * damping)
    assert abs(stuck.amplitude[0]) == pytest.approx(abs(linear), rel=1e-2)
    assert abs(slipping.amplitude[0]) < 0.96 * 2.0 * abs(stuck.amplitude[0])


@pytest.mark.oracle
@pytest.mark.slow
def test_coupled_structures_are_as_exact_as_their_master():
    """Of first order where the spring's force is held, of second where it moves; as its energy."""
    table = np.array(example("coupled_structures").main())
    step, held, held_energy, moved, moved_energy = table.T
    assert step.tolist() == [8.0, 4.0, 2.0, 1.0, 0.5]
    expected = [3.3e-2, 1.6e-2, 7.6e-3, 3.7e-3, 1.8e-3]
    np.testing.assert_allclose(held, expected, rtol=0.05)
    for values, order in ((held, 1.0), (held_energy, 1.0), (moved, 1.7), (moved_energy, 1.9)):
        slope = np.polyfit(np.log(step), np.log(np.abs(values)), 1)[0]
        assert slope > order - 0.1
    assert moved[-1] < 1e-4 and abs(moved_energy[-1]) < 1e-6  # balanced


@pytest.mark.slow
def test_the_plate_turns_from_one_mode_to_the_other():
    """Frequencies of both peaks where the damper sticks and slips [Hz]."""
    _, found = example("square_plate_picture").curves()
    peaks = [curve.frequency[np.abs(curve.amplitude).argmax(axis=0)] for curve in found]
    expected = [[273.98, 279.44], [273.5, 276.8]]
    np.testing.assert_allclose(np.array(peaks) / (2.0 * np.pi), expected, rtol=2e-3)


MADE = ("lap-joint", "square-plate", "wedge-damper")


@pytest.mark.parametrize(
    ("script", "name"),
    [("meshed_blade", "blade"), *((name.replace("-", "_"), name) for name in MADE)],
)
def test_scripts_make_the_matrices_of_shipped_scenes(script, name):
    """Up to rounding."""
    made = getattr(example(script), script.removeprefix("meshed_"))()
    stored = runner.shipped_scenes()[name].with_suffix(".npz")
    assert stored.stat().st_size < 30_000
    for attribute in ("mass", "stiffness", "damping", "directions"):
        ours = getattr(made, attribute).toarray()
        theirs = getattr(rom.load_structure(stored), attribute).toarray()
        np.testing.assert_allclose(ours, theirs, atol=1e-12 * np.abs(theirs).max())
