"""The examples run, those of the documentation as they are printed, and keep their numbers."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.rom import full
from slipmode.runner import open_results, parse_scene, replay, scene_performance

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


def test_blocks_on_meshes_that_do_not_match_keep_their_numbers():
    """Stuck at first, slipping at twice the force: that of full order."""
    blocks = example("two_blocks")
    structure, pairs, (_, sideways, _) = blocks.two_blocks()
    assert pairs.area == pytest.approx([0.04 * 0.03 / 4] * 4)
    rest, reduced, (stuck, slipping) = blocks.shaken([1000.0, 2000.0])
    np.testing.assert_allclose(rest.normal_force, 5e7 * pairs.area, rtol=1e-6)
    assert reduced.frequency == pytest.approx([38159.3], rel=1e-5)
    assert abs(stuck.amplitude[0]) == pytest.approx(8.6103e-6, rel=1e-4)
    Omega, shapes = blocks.BELOW * reduced.frequency, reduced.mode_shapes
    a = slipping.amplitude
    near = full.State(0.0, 2 * np.real(shapes @ a), 2 * np.real(shapes @ (1j * Omega * a)))
    found = full.steady_amplitude(
        structure,
        rest.law,
        full.Excitation.harmonic(structure, [2000.0 * sideways], Omega),
        outputs=shapes.T @ structure.mass,
        tolerance=1e-3,
        steps_per_period=64,
        start=near,
    )
    assert a == pytest.approx(found.amplitude[0], rel=6e-3)  # 0.43 %
    assert abs(a[0]) < 0.96 * 2.0 * abs(stuck.amplitude[0])


@pytest.mark.slow
def test_the_preload_of_the_dampers_is_chosen(tmp_path, capsys):
    """From one command; and for one coefficient the peaks are those of its performance curve."""
    pytest.importorskip("distributed")
    path = EXAMPLES / "damper_preload.toml"
    assert main(["study", str(path), "-o", str(tmp_path)]) == 0
    first, best, *_ = capsys.readouterr().out.splitlines()
    assert first == "Resonance peak of the blade under uncertain friction: 3840 samples, 0 failed"
    chosen = float(best.split(" = ")[1].split()[0].strip(":"))
    assert 55.0 < chosen < 80.0 and " of resonance_A at DOF 202 " in best
    assert (tmp_path / "damper_preload.png").stat().st_size > 10_000
    data = open_results(tmp_path / "damper_preload.zarr").load().isel(sample=slice(600, 660))
    (mu,) = np.unique(data["contacts.0.mu"]).tolist()
    text = (
        runner.shipped_scenes()["blade"].read_text().replace("amplitude = 25.0", "amplitude = 0.0")
    )
    text = text.replace("mu = 0.4 ", f"mu = {mu!r} ").replace("[16.0, 24.0]", "24.0")
    text = text.replace("tolerance = 1e-2", "tolerance = 1e-3")
    scene = parse_scene(text, runner.shipped_scenes()["blade"].parent)
    curve = scene_performance(scene)
    *_, peak, unit = best.split()
    tip = 1.63e-4 * 2.0 * abs(curve.mode_shape[202])
    assert unit == "m" and float(peak) == pytest.approx(tip, rel=0.02)
    preload = data["contacts.0.preload"].values
    within = (preload > 24.0 * curve.limit.min()) & (preload < 24.0 * curve.limit.max())
    expected = np.interp(preload[within] / 24.0, curve.limit, curve.peak)
    assert np.count_nonzero(within) > 30
    np.testing.assert_allclose(data["resonance"].sel(mode="A")[within], expected, rtol=0.012)


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
