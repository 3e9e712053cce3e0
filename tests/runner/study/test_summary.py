"""What a study comes to: the best value, sensitivities, the picture and the lines printed."""

import re

import numpy as np
import pytest

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import open_results, shipped_scenes
from slipmode.runner.study.study_file import Choose, load_study
from slipmode.runner.study.summary.charts import outputs
from slipmode.runner.study.summary.statistics import choice, sensitivity


def test_the_best_value_is_that_of_the_least_quantile():
    key, peak = np.array([1.0, 1.0, 2.0, 2.0, 3.0, 3.0]), [1.0, 5.0, 2.0, 3.0, 0.1, np.nan]
    worst = choice(key, np.array(peak), Choose("friction.limit", "resonance_A", 1.0))
    line = "best friction.limit = 2: highest of resonance_A 3 kg^1/2 m"
    assert worst.text("kg^1/2 m", "") == line
    assert worst.failed.tolist() == [0, 0, 1]  # with a failed sample the quantile is unknown
    least = choice(key, np.array(peak), Choose("friction.limit", "resonance_A", 0.0))
    assert least.values[least.best] == 1.0
    with pytest.raises(SlipmodeError, match="choose: some samples failed for each value of"):
        choice(key[:1], np.array([np.nan]), Choose("friction.limit", "resonance_A", 0.5))


def test_sensitivities_are_those_that_are_known():
    sampler = pytest.importorskip("SALib.sample.sobol")
    problem = {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[0.0, 1.0]] * 3}
    unit = sampler.sample(problem, 1024, calc_second_order=False, seed=0)
    a, b, c = (2.0 * np.pi * unit - np.pi).T
    ishigami = np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)
    found = sensitivity("steady_A", ishigami, ("a", "b", "c"), 0)
    np.testing.assert_allclose(found.first, [0.3139, 0.4424, 0.0], atol=0.03)
    np.testing.assert_allclose(found.total, [0.5576, 0.4424, 0.2437], atol=0.03)
    assert len(found.text()) == 3
    ishigami[5] = np.nan
    with pytest.raises(SlipmodeError, match="no sensitivities, because 1 samples failed"):
        sensitivity("steady_A", ishigami, ("a", "b", "c"), 0)


def test_the_command_says_what_was_found_and_draws_it(study_file, tmp_path, scheduler, capsys):
    pytest.importorskip("matplotlib")
    path = study_file(
        '[[vary]]\nkey = "forcing.A.frequency"\nvalues = [0.9, 0.98, 20.0]\n'
        '[outputs]\nsteady = true\npeak = true\n[choose]\nkey = "forcing.A.frequency"\n'
        'output = "steady_A"\n'
    )
    assert main(["study", str(path), "-o", str(tmp_path), "--scheduler", scheduler]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "study: 3 samples, 1 failed"
    assert lines[1].startswith("failed: 1 x frequency: must be")
    assert lines[2].startswith("best forcing.A.frequency = 0.9: 95% quantile of steady_A ")
    assert re.fullmatch(r"estimated transient error: \|A\| [0-9.]+ %", lines[3])
    assert lines[4:-1] == [str(tmp_path / f"study.{kind}") for kind in ("zarr", "png", "rrd")]
    assert (tmp_path / "study.png").stat().st_size > 10_000


def test_a_study_answers_in_the_units_of_its_scene_at_a_dof(
    study_file, tmp_path, scheduler, capsys
):
    pytest.importorskip("matplotlib")
    path = study_file(
        '[[vary]]\nkey = "forcing.A.amplitude"\nvalues = [0.1, 0.15]\n'
        "[outputs]\nsteady = true\ndofs = [0]\n"
        'curve = { mode = "A", from = 0.97, to = 0.99, points = 3 }\n'
        '[choose]\nkey = "forcing.A.amplitude"\noutput = "steady_A"\n',
        shipped_scenes()["one-mode"].read_text(encoding="utf-8")
        + '\n[units]\ndisplacement = "mm"\n',
    )
    assert main(["study", str(path), "-o", str(tmp_path), "--scheduler", scheduler]) == 0
    (line,) = [each for each in capsys.readouterr().out.splitlines() if each.startswith("best")]
    data = open_results(tmp_path / "study.zarr")
    least = 1e3 * float(data["steady_displacement"].sel(mode="A", dof=0).min())
    assert line == (
        f"best forcing.A.amplitude = 0.1: 95% quantile of steady_A at DOF 0 {least:.4g} mm, "
        "at the end of the values given"
    )
    names = [(name, unit) for name, unit, _ in outputs(data, load_study(path))]
    assert names == [("steady A at DOF 0", "mm"), ("largest of curve A at DOF 0", "mm")]


def test_sensitivities_of_a_study(study_file, tmp_path, scheduler, capsys):
    pytest.importorskip("SALib")
    vary = '[[vary]]\nkey = "{}"\ndistribution = "uniform"\nlow = {}\nhigh = {}\n'
    path = study_file(
        vary.format("forcing.A.amplitude", 0.1, 0.2)
        + vary.format("forcing.A.phase", 0.0, 1.0)
        + '[sampling]\nmethod = "saltelli"\nsamples = 32\n[outputs]\nsteady = true\n'
    )
    assert main(["study", str(path), "-o", str(tmp_path), "--scheduler", scheduler]) == 0
    of_force, of_phase = (
        line for line in capsys.readouterr().out.splitlines() if line.startswith("steady_A")
    )
    assert float(of_force.split("first")[1].split()[0]) == pytest.approx(1.0, abs=0.1)
    assert float(of_phase.split("total")[1].split()[0]) == pytest.approx(0.0, abs=1e-3)
