"""The examples run, those of the documentation as they are printed, and keep their numbers."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from slipmode import rom, runner
from slipmode.runner.view.replay import replay

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_example_of_the_package_runs():
    lines = rom.__doc__.splitlines()
    example = "\n".join(line.strip() for line in lines if " = " in line)
    assert example.count("\n") >= 3
    names = {"rom": rom}
    exec(example, names)
    assert abs(names["a_A"]) == pytest.approx(3.0951, rel=1e-3)
    assert abs(names["a_B"]) == pytest.approx(1.2515, rel=1e-3)


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_controlled_friction_limit_keeps_its_numbers(tmp_path):
    """Peaks of |A|: the fixed limit is good for the second force, the controlled one for all."""
    peaks = np.array(example("friction_control").main(tmp_path))
    expected = [[1.6481, 0.9868], [2.9857, 2.9653], [12.698, 8.8815]]
    np.testing.assert_allclose(peaks, expected, rtol=2e-3)
    force = np.array([0.05, 0.15, 0.45])
    np.testing.assert_allclose(peaks[:, 1] / force, 19.75, rtol=2e-3)  # as a linear structure
    for name in ("friction_control", "controlled"):
        replay(tmp_path / f"{name}.mcap", save=tmp_path / "replayed.rrd")
        assert (tmp_path / "replayed.rrd").stat().st_size > 100_000
    (event,) = runner.read(tmp_path / "controlled.mcap").events
    assert event.message == "the friction limit follows |A|"
    picture = tmp_path / "picture.png"
    example("friction_control_picture").draw(tmp_path, picture)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_flutter_keeps_its_numbers():
    """A stable and an unstable limit cycle, until friction cannot hold the mode any more."""
    held, lost = example("flutter").branches([-0.02j, -0.03j])
    assert [cycle.stable for cycle in held] == [True, False]
    amplitudes = [abs(cycle.amplitude[0]) for cycle in held]
    np.testing.assert_allclose(amplitudes, [1.2642, 4.6889], rtol=2e-3)
    assert lost == ()
