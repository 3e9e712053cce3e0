"""Curves of a scene: files, pictures, and the numbers in them."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recordings import table

from slipmode import rom
from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.rom.slow.branches import continuation
from slipmode.runner import load_scene, scene_performance, scene_response_curve, shipped_scenes
from slipmode.runner.curves.scene_curves import SceneForcing


def test_a_curve_that_goes_on_is_said_in_a_line(tmp_path, capsys, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(continuation, "MOST_POINTS", 10)
    assert main(["curve", "one-mode", "-o", str(tmp_path)]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "is incomplete" in line]
    assert len(said) == 1
    assert "curve is incomplete beyond frequency_A = 0.9" in said[0]
    assert "A shorter span shows more of it" in said[0]


def test_a_curve_is_written_and_drawn(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    assert main(["curve", "one-mode", "-o", str(tmp_path)]) == 0
    said = capsys.readouterr().out.splitlines()
    found = table(tmp_path / "one-mode.curve.csv")
    forcing = SceneForcing.of(load_scene("one-mode"))
    natural = forcing.plan.excited.reduced.frequency[0]
    ends = found["frequency_A"][[0, -1]]
    assert ends == pytest.approx([0.95 * natural, 1.05 * natural])
    assert np.all(found["growth"] < 0.0)
    size = np.hypot(found["A_re"], found["A_im"])
    assert said[-2] == f"largest: |A| [kg^0.5 m] = {size.max():.4g}"
    picture, recording = (tmp_path / f"one-mode.curve.{ending}" for ending in ("png", "rrd"))
    assert said[-1] == f"next:  open {picture}, or in Rerun: rerun {recording}"
    for k in (10, size.argmax()):
        Omega = [found["frequency_A"][k]]
        reduced = forcing.plan.excited.reduced.at_carrier(Omega)
        model = rom.tabulate(reduced, forcing.plan.excited.law, (4.0,), 1e-4)
        (a,) = rom.steady(model, Omega, forcing.force, tuple(forcing.phase))
        assert found["A_re"][k] + 1j * found["A_im"][k] == pytest.approx(a, rel=1e-3)
    assert (tmp_path / "one-mode.curve.png").stat().st_size > 10_000


def test_curves_of_other_parameters_and_modes_are_other_files(tmp_path):
    """And a link in the folder is replaced, its target stays."""
    pytest.importorskip("matplotlib")
    (tmp_path / "precious").write_text("precious")
    for ending in ("csv", "png", "rrd"):
        (tmp_path / f"one-mode.curve.force.{ending}").symlink_to(tmp_path / "precious")
    force = ["--vary", "force", "--span", "0.5", "1"]
    for command in (["curve"], ["curve", *force], ["backbone", "--mode", "A"]):
        assert main([*command, "one-mode", "-o", str(tmp_path)]) == 0
    assert "frequency_A" in table(tmp_path / "one-mode.curve.csv")
    assert table(tmp_path / "one-mode.curve.force.csv")["force"][[0, -1]].tolist() == [0.5, 1.0]
    assert "damping" in table(tmp_path / "one-mode.backbone.A.csv")
    assert (tmp_path / "precious").read_text() == "precious"


def test_a_title_with_dots_is_no_matter_for_rerun(tmp_path):
    """Rerun would print a line about its name of the application."""
    scene = tmp_path / "own.toml"
    before = Path(shipped_scenes()["one-mode"]).read_text(encoding="utf-8")
    scene.write_text(re.sub("title = .*", 'title = "Both. Modes, v1.2"', before), encoding="utf-8")
    code = "import sys; from slipmode.runner.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "curve", scene, "-o", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "app_id" not in done.stderr + done.stdout
    assert "\x1b" not in done.stderr + done.stdout


def test_it_goes_as_far_as_the_amplitudes_do():
    """Past those of the scene, for which the friction table of a run is made."""
    scene = load_scene("one-mode")
    curve = scene_response_curve(scene, "force", (0.5, 3.0))
    assert curve.parameter[-1] == 3.0
    assert np.abs(curve.amplitude).max() > 2.0 * SceneForcing.of(scene).plan.amplitude[0]


def test_a_backbone_is_written_and_drawn(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    assert main(["backbone", "one-mode", "-o", str(tmp_path)]) == 0
    assert "damping ratio to" in capsys.readouterr().out
    found = table(tmp_path / "one-mode.backbone.csv")
    assert found["damping"].max() > 1.3 * found["damping"][0]
    assert found["frequency"][-1] < found["frequency"][0]
    assert (tmp_path / "one-mode.backbone.png").stat().st_size > 10_000


def coulomb_scene(folder, limit):
    """The shipped scene of one mode, with Coulomb's law."""
    text = shipped_scenes()["one-mode"].read_text()
    for old, new in (
        ('law = "tanh"', 'law = "coulomb"'),
        ("alpha = 0.02", ""),
        ("limit = 2.0", f"limit = {limit}"),
    ):
        assert old in text
        text = text.replace(old, new)
    (folder / "own.toml").write_text(text)
    return folder / "own.toml"


def test_the_best_limit_is_found_where_the_scene_never_slips(tmp_path):
    """The table of such a scene ends before its contacts yield; that of its design does not."""
    curve = scene_performance(load_scene(coulomb_scene(tmp_path, 2000.0)))
    limit, peak = curve.optimum
    assert 2000.0 * limit == pytest.approx(2.0 * 1.53, abs=0.04)
    assert curve.peak[-1] > 1.4 * peak  # stuck
    assert curve.peak[0] > 1.4 * peak  # slipping


def test_the_end_of_a_design_is_not_called_the_best(tmp_path, capsys):
    """Its table ends at 1.6 kg^0.5 m; the peak is lowest at 2.0."""
    pytest.importorskip("matplotlib")
    scene = coulomb_scene(tmp_path, 2.0)
    scene.write_text(scene.read_text() + "\n[model]\namplitude = [0.2]\n")
    assert main(["design", str(scene), "-o", str(tmp_path)]) == 0
    said = capsys.readouterr()
    assert "lowest" not in said.out
    assert "where the curve ends: no optimum is known" in said.out
    assert "give a larger model.amplitude" in said.err


def test_a_design_has_the_forcing_frequency_as_its_reference(tmp_path):
    scene = coulomb_scene(tmp_path, 2.0)
    curve = scene_performance(load_scene(scene))
    assert curve.motion.model.reduced.carrier == pytest.approx([0.9825])


def test_the_best_limit_is_said(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    coulomb_scene(tmp_path, 2.0)
    assert main(["design", str(tmp_path / "own.toml"), "-o", str(tmp_path)]) == 0
    found = table(tmp_path / "own.design.csv")
    said = capsys.readouterr().out.splitlines()
    best = found["peak"].argmin()
    assert said[-3].startswith(f"lowest peak [kg^0.5 m] = {found['peak'][best]:.4g} at ")
    assert found["peak"][best] < 0.7 * found["peak"][-1]
    assert found["limit"][best] == pytest.approx(1.53, abs=0.02)


def test_curves_and_designs_answer_in_the_units_of_the_scene_at_a_dof(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    scene = coulomb_scene(tmp_path, 2.0)
    scene.write_text(scene.read_text() + '\n[units]\ndisplacement = "mm"\n')
    options = [str(scene), "--dof", "0", "-o", str(tmp_path)]
    assert main(["design", *options]) == 0
    found, said = table(tmp_path / "own.design.csv"), capsys.readouterr().out.splitlines()
    peak = found["peak at DOF 0 [mm]"]
    assert said[-3].startswith(f"lowest peak at DOF 0 [mm] = {peak.min():.4g} at ")
    assert main(["curve", *options]) == 0
    size = table(tmp_path / "own.curve.csv")["A at DOF 0 [mm]"]
    said = capsys.readouterr().out.splitlines()
    assert said[-2] == f"largest: |A| at DOF 0 [mm] = {size.max():.4g}"


@pytest.mark.parametrize(
    ("vary", "span", "key"),
    [
        ("force", None, "span: is missing; give the first and last value of force"),
        ("frequency_B", None, "vary: the scene does not force mode B"),
        ("force", (1.0, 1.0), "span: must be two different values"),
        ("frequency_A", (0.1, 1.0), "frequency: must be"),
    ],
)
def test_what_makes_no_curve_is_named(vary, span, key):
    with pytest.raises(SlipmodeError, match=key):
        scene_response_curve(load_scene("one-mode"), vary, span)


@pytest.mark.slow
def test_a_performance_curve_is_as_exact_as_the_scene_asks_where_the_scene_goes():
    """Its table goes to eight times the scene's amplitudes; errors count by its largest |S|."""
    scene = load_scene(shipped_scenes()["blade"])
    finer = replace(scene, model=replace(scene.model, tolerance=scene.model.tolerance / 10))
    found, exact = scene_performance(scene), scene_performance(finer)
    limit = np.linspace(0.5, 8.0, 200)
    peak, expected = (np.interp(limit, curve.limit, curve.peak) for curve in (found, exact))
    # of a tolerance of 1e-2; measured 0.023, and 0.33 where that was of the largest |S| alone
    assert np.abs(peak / expected - 1.0).max() < 3e-2
