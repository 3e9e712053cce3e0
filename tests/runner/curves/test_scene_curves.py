"""Curves, backbones and designs of a scene: numbers, files and units."""

import re

import numpy as np
import pytest
from beside_oracle import with_laws
from oracles.harmonic_balance import nonlinear_mode
from oracles.system import Coulomb, Tanh, Tone, jenkins
from oracles.time_integration import steady_harmonics
from recordings import table

from slipmode import rom, runner
from slipmode.__main__ import main
from slipmode.runner import (
    load_scene,
    parse_scene,
    scene_backbone,
    scene_performance,
    scene_response_curve,
    shipped_scenes,
)

ONE_MODE = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
SMALLEST = 1e-6  # errors below are not stated reliably: 4.5e-7 in stick, where 2.6e-7 is stated
JENKINS = '[[contacts]]\nlaw = "jenkins"\nlimit = 0.1\nstiffness = 2.0\n'


def a_scene(contacts, damping=0.05, amplitude=0.15):
    """A scene of mode A of the two masses."""
    friction = ONE_MODE[ONE_MODE.index("[friction]") : ONE_MODE.index("[modes]")]
    text = ONE_MODE.replace(friction, contacts)
    text = re.sub(r"damping = \S+", f"damping = {damping}", text)
    return re.sub(r"amplitude = \S+", f"amplitude = {amplitude}", text)


def coulomb_scene(folder, limit):
    (folder / "own.toml").write_text(
        a_scene(f'[friction]\nlaw = "coulomb"\nlimit = {limit}\n', 0.01)
    )
    return folder / "own.toml"


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("contacts", "laws"),
    [
        (JENKINS, 2 * [jenkins(0.1, 2.0)]),
        ('[friction]\nlaw = "tanh"\nlimit = 0.5\nalpha = 0.02\n', 2 * [Tanh(0.5, 0.02)]),
    ],
    ids=["jenkins", "tanh"],
)
def test_a_curve_is_the_independent_steady_motion(contacts, laws):
    curve = scene_response_curve(parse_scene(a_scene(contacts), "."), "frequency_A", (0.94, 1.0))
    system = with_laws(rom.two_mass(beta=0.05), laws)
    assert np.all(curve.growth < 0.0)
    for k in (10, int(np.abs(curve.amplitude).argmax())):
        tone = Tone(curve.parameter[k], np.array([0.15 + 0j, 0.0, 0.0, 0.0]))
        exact = steady_harmonics(system, [tone], [[1]], steps=512)
        row = 0.5 * curve.mode_shapes[:, 0] @ system.M
        error = abs(curve.amplitude[k, 0] - row @ exact.amplitude[0])
        assert error <= curve.error[k, 0] + np.abs(row) @ exact.error[0]


@pytest.mark.slow
@pytest.mark.oracle
def test_a_backbone_is_that_of_the_independent_harmonic_balance():
    found = scene_backbone(parse_scene(a_scene(JENKINS), "."))
    system = with_laws(rom.two_mass(beta=0.05), 2 * [jenkins(0.1, 2.0)])
    law = rom.Jenkins(0.1, 2.0)
    shape = rom.reduce(rom.two_mass(beta=0.05), (0,), law=law).mode_shapes[:, 0]
    mode = coarse = None
    for k in range(0, len(found.frequency), 3):
        size = 2.0 * float(found.amplitude[k])
        mode = nonlinear_mode(system, shape, size, mode, alone=True)
        coarse = nonlinear_mode(system, shape, size, coarse, 9, alone=True)
        own = abs(mode.omega - coarse.omega) + abs(mode.zeta - coarse.zeta)
        assert abs(found.frequency[k] - mode.omega) <= found.frequency_error[k] + own + SMALLEST
        assert abs(found.damping[k] - mode.zeta) <= found.damping_error[k] + own + SMALLEST
    assert found.damping[k] > 1.02 * found.damping[0]  # slips


@pytest.mark.oracle
def test_the_best_limit_is_a_minimum_of_the_independent_peak(tmp_path):
    """Also where the scene never slips; peaks at the optimum and beside it."""
    curve = scene_performance(load_scene(coulomb_scene(tmp_path, 2000.0)))
    limit, peak = curve.optimum
    assert 2000.0 * limit == pytest.approx(2.0 * 1.53, abs=0.04)
    assert min(curve.peak[0], curve.peak[-1]) > 1.4 * peak
    assert curve.motion.model.reduced.carrier == pytest.approx([0.9825])
    best = int(curve.peak.argmin())
    law = 2 * [Coulomb(2000.0 * float(curve.limit[best]))]
    system = with_laws(rom.two_mass(beta=0.01), law)
    tone = Tone(float(curve.frequency[best]), np.array([0.15 + 0j, 0.0, 0.0, 0.0]))
    exact = steady_harmonics(system, [tone], [[1]], 1e-3, steps=1024)
    row = 0.5 * curve.mode_shape @ system.M
    assert curve.peak[best] == pytest.approx(abs(row @ exact.amplitude[0]), rel=1e-2)


# Files and messages of the commands


def test_curves_of_other_parameters_and_modes_are_other_files(tmp_path, capsys):
    """And a link in the folder is replaced, its target stays."""
    pytest.importorskip("matplotlib")
    (tmp_path / "precious").write_text("precious")
    for ending in ("csv", "png", "rrd"):
        (tmp_path / f"one-mode.curve.force.{ending}").symlink_to(tmp_path / "precious")
    force = ["--vary", "force", "--span", "0.5", "1", "--log"]
    said = []
    for command in (["curve"], ["curve", *force], ["backbone", "--mode", "A"]):
        assert main([*command, "one-mode", "-o", str(tmp_path)]) == 0
        said.append(capsys.readouterr())
    assert "warning" not in said[2].err
    found = table(tmp_path / "one-mode.curve.csv")
    size = found["A at DOF 0 [m]"]
    assert f"largest: |A| at DOF 0 [m] = {size.max():.4g}" in said[0].out
    assert found["frequency_A"][[0, -1]] == pytest.approx([0.95, 1.05])
    assert table(tmp_path / "one-mode.curve.force.csv")["force"][[0, -1]].tolist() == [0.5, 1.0]
    assert "damping" in table(tmp_path / "one-mode.backbone.A.csv")
    assert (tmp_path / "one-mode.curve.png").stat().st_size > 10_000
    assert (tmp_path / "precious").read_text() == "precious"


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


@pytest.mark.oracle
def test_files_are_in_units_of_the_scene_and_recordings_keep_theirs(tmp_path, capsys):
    """Hz and micrometres: factors of 2 pi and 1e6."""
    pytest.importorskip("matplotlib")
    omega = float(re.search(r"frequency = (\S+)", ONE_MODE)[1])
    hertz = ONE_MODE.replace(f"frequency = {omega}", f"frequency = {omega / (2 * np.pi)!r}")
    hertz += '\n[units]\nfrequency = "Hz"\ndisplacement = "um"\n'
    recorded = []
    for name, text in (("plain", ONE_MODE), ("hertz", hertz)):
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
        span = np.array([0.96, 1.0]) / (2 * np.pi if name == "hertz" else 1.0)
        scene, out = str(tmp_path / f"{name}.toml"), ["--dof", "0", "-o", str(tmp_path)]
        assert main(["curve", scene, "--span", *map(repr, span.tolist()), *out]) == 0
        assert main(["backbone", scene, *out]) == 0
        unlogged = text.replace("rerun = true", "rerun = false")
        recorded.append(runner.load(runner.run(parse_scene(unlogged, "."), tmp_path / name).mcap))
    assert "largest: |A| at DOF 0 [um] = " in capsys.readouterr().out
    for kind, of_frequency, size in (
        ("curve", "frequency_A", "A"),
        ("backbone", "frequency", "amplitude"),
    ):
        plain, hertz = (table(tmp_path / f"{name}.{kind}.csv") for name in ("plain", "hertz"))
        shown = 2 * np.pi * hertz[f"{of_frequency} [Hz]"]
        assert shown == pytest.approx(plain[of_frequency], rel=1e-6)
        metres = plain[f"{size} at DOF 0 [m]"]
        assert hertz[f"{size} at DOF 0 [um]"] == pytest.approx(1e6 * metres, rel=1e-5)
        assert metres.max() > 0.1
    for topic, signals in recorded[0].items():
        assert signals.units == recorded[1][topic].units
        scale = np.abs(signals.values).max(axis=0)
        error = np.abs(recorded[1][topic].values - signals.values).max(axis=0)
        assert np.all(error <= 1e-6 * scale)
