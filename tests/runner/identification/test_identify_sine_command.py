"""`slipmode identify --sine`: from files of sine tests to report, pictures, scene and FMU."""

import re
from pathlib import Path

import numpy as np
import pytest
from measured.decays import power_law_amplitude
from measured.sine_tests import Oscillator, response_controlled
from measured.sweeps import RATE, JointedOscillator, sweep

from slipmode import runner
from slipmode.__main__ import main

pytest.importorskip("matplotlib")

WRITTEN = {"report.txt", "backbone.csv", "backbone.png", "sine_tests.png"}
WRITTEN |= {"model.npz", "scene.toml", "model.fmu"}
TRUE = Oscillator(c3=1.5e8)
LEVELS = (10, 25, 40, 55, 70)
BAND = ["--sine", "--band", "78", "82"]
UNITS = ["--unit", "m/s^2", "--force-unit", "N"]
PUBLISHED = Path(__file__).parents[4] / "shared" / "data" / "published"
MEASURED = PUBLISHED / "brb_forced_responses_measured.mat"


def write(folder, levels=LEVELS):
    for a in levels:
        test = response_controlled(TRUE, a, np.linspace(79.0, 81.0, 41), 0.1)
        columns = [test.frequency, np.abs(test.force), np.abs(test.response)]
        table = np.column_stack([*columns, np.angle(test.response / test.force)])
        header = "frequency,force,amplitude,phase"
        np.savetxt(folder / f"a{a}.csv", table, "%.9g", ",", header=header, comments="")
    return str(folder / "a*.csv")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sine")
    options = ["--hold-out", "40", "-o", str(folder / "beam")]
    assert main(["identify", write(folder), *BAND, *UNITS, *options]) == 1  # no test begins so
    options[1] = "a40"
    assert main(["identify", write(folder), *BAND, *UNITS, *options]) == 0
    return folder / "beam"


def test_the_report_has_law_levels_and_predictions(done):
    assert {path.name for path in done.iterdir()} == WRITTEN
    text = (done / "report.txt").read_text(encoding="utf-8")
    rows = {line.split()[0]: line for line in text.splitlines() if line}
    assert {f"a{a}" for a in LEVELS} <= set(rows)
    assert re.search(
        r"held out: error (below )?0\.\d+ % of the peak, peak [-+]0\.\d+ %", rows["a40"]
    )
    mass = float(rows["modal_mass"].split()[1])
    assert rows["modal_mass"].endswith("kg") and mass == pytest.approx(1.8, rel=0.01)
    assert float(rows["delta_0_A"].split()[1]) == pytest.approx(0.004 * TRUE.omega, rel=0.01)
    assert float(rows["p_A"].split()[1]) == pytest.approx(2.0, rel=0.02)
    assert "law: power" in text and "modal mass at" not in text


def test_the_scene_decays_as_the_oscillator(done, tmp_path):
    assert main(["run", str(done / "scene.toml"), "-o", str(tmp_path)]) == 0
    modes = runner.load(tmp_path / "scene.mcap")["/modes"]
    x = 2.0 * modes.column("A_abs") / np.sqrt(TRUE.m)  # at the sensor [m]
    assert x[0] * TRUE.omega**2 == pytest.approx(0.95 * 70.0, rel=5e-3)  # inside the table
    rates = TRUE.zeta * TRUE.omega, TRUE.omega, TRUE.c3 / (8.0 * TRUE.m), 0.0, 2.0
    exact = np.abs(power_law_amplitude(modes.time, x[0], *rates))
    assert x == pytest.approx(exact, abs=0.01 * x[0])
    assert exact[-1] < 0.15 * x[0]


def test_time_signals_of_sweeps_are_read(tmp_path, capsys):
    for k, force in enumerate((0.05, 0.15, 0.4, 0.8), 1):
        signals = JointedOscillator().signals(*sweep(78.0, 81.4, 0.1, force))
        table = np.stack([np.arange(1, signals[0].size + 1) / RATE, *signals], axis=1)
        file = tmp_path / f"level{k}.csv"
        np.savetxt(file, table, "%.9g", ",", header="time,F,v", comments="")
    options = ["--sine", "--band", "78.2", "81.2", "--unit", "m/s", "--force-unit", "N"]
    named = [*options, "--channels", "F", "v", "-o", str(tmp_path)]
    assert main(["identify", str(tmp_path / "level*.csv"), *named]) == 0
    assert re.search(r"modal_mass +1\.[78]\d+ ", capsys.readouterr().out)
    assert main(["identify", str(tmp_path / "level*.csv"), *options]) == 1
    assert "the force must be measured" in capsys.readouterr().err


REFUSED = {
    "unit": (LEVELS, [*BAND, "--force-unit", "N"], "unit: .*a10.csv does not state one; give --u"),
    "force": (LEVELS, [*BAND, "--unit", "m"], "force.unit: .* not state one; give --force-unit$"),
    "two": (LEVELS, [*BAND, *UNITS, "--band", "90", "99"], "--band: sine tests are of one mode"),
    "mass": (LEVELS, [*BAND, *UNITS, "--modal-mass", "1"], "--modal-mass: is for decays, not"),
    "cross": (LEVELS, [*BAND, *UNITS, "--cross", "no"], "--cross: is for decays, not for sine"),
    "law": (LEVELS, [*BAND, *UNITS, "--law", "iwan"], "--law 'iwan': must be power or linear"),
    "few": (LEVELS[:3], [*BAND, *UNITS], "tests: must have at least 4 levels for"),
    "absent": (LEVELS, [*BAND, *UNITS, "--hold-out", "F"], "tests: no name starts with 'F'"),
    "decays": (LEVELS, [*BAND[1:], *UNITS], "--force-unit: is for sine tests; give --sine"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_ends_in_one_line(case, tmp_path, capsys):
    levels, options, words = REFUSED[case]
    files = write(tmp_path, levels)
    assert main(["identify", files, *options, "-o", str(tmp_path / "out")]) == 1
    printed = capsys.readouterr()
    (line,) = (each for each in printed.err.splitlines() if each.startswith("slipmode: "))
    assert not printed.out and not (tmp_path / "out").exists()
    assert re.search(words, line), line


@pytest.mark.skipif(not MEASURED.exists(), reason="needs published/ of the shared data")
def test_the_measured_beam_predicts_its_force_controlled_tests(tmp_path, capsys):
    options = ["--hold-out", "Force", "-o", str(tmp_path)]
    assert main(["identify", str(MEASURED), *BAND, *options]) == 0
    errors = re.findall(r"held out: error (\S+) %", capsys.readouterr().out)
    assert len(errors) == 4 and max(map(float, errors)) < 7.0  # 3.9 to 6.8 %
