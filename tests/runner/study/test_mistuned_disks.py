"""Studies of mistuned disks: amplification factors against `rom.MistunedDisk`, and refusals."""

import re
import shutil
import subprocess
import sysconfig

import numpy as np
import pytest

from slipmode import rom
from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import open_results, run_study
from slipmode.runner.study.study_file import load_study
from slipmode.runner.study.summary.amplifications import amplifications

SLIPMODE = shutil.which("slipmode", path=sysconfig.get_path("scripts"))
SCENE = 'scene = "mistuned-disk"'
SEEDS = '[[vary]]\nkey = "mistuning.seed"\nfrom = 0\nto = {last}\npoints = {points}\n'
CURVE = '[outputs]\ncurve = {mode = "A", from = 190.0, to = 204.0, points = 10}\n'


def test_factors_are_those_of_the_disks(study_file, tmp_path, scheduler):
    text = SEEDS.format(last=2, points=3) + '[[vary]]\nkey = "forcing.A.amplitude"\n'
    path = study_file(text + f"values = [0.1, 4.0]\n{CURVE}", SCENE)
    done = run_study(path, tmp_path, scheduler=scheduler)
    results, lines = done.dataset().sel(mode="A"), amplifications(done.dataset(), done.study)
    structure = rom.lumped_disk(24, 1e-5, blade_stiffnesses=(1e6, 4e6))
    patterns = np.vstack([rom.random_mistuning(1, 24, 0.02, seed=seed) for seed in range(3)])
    disks = rom.MistunedDisk(structure, rom.Jenkins(1.0, 5e4), patterns, 1e5)
    omega = 2.0 * np.pi * np.linspace(190.0, 204.0, 10)
    for force, line in zip((0.1, 4.0), lines, strict=True):
        expected = disks.amplification(omega, 3, {2: force}, dof=2)
        own = results["forcing.A.amplitude"].values == force
        assert results["mistuning.seed"].values[own].tolist() == [0, 1, 2]
        found = results["amplification"].values[own]
        # measured 2e-6; scenes have fewer modes
        np.testing.assert_allclose(np.sort(found), expected.factor, rtol=1e-4)
        peak = results["resonance"].values[own]
        np.testing.assert_allclose(peak / found, expected.tuned, rtol=1e-4)
        np.testing.assert_array_equal(peak, results["curve"].values[own].max(axis=1))
        assert line.startswith(f"forcing.A.amplitude = {force}: amplification of 3 disks: median ")
        largest = re.search(r"largest ([0-9.]+), below Whitehead's bound 2\.949", line)
        assert float(largest[1]) == pytest.approx(expected.factor[-1], abs=2e-3)


@pytest.mark.slow
def test_extreme_values_are_those_of_all_disks(study_file, tmp_path, scheduler, capsys):
    text = 'set = {"structure.blade_stiffnesses" = [1e6, 2e6]}\n'
    text += SEEDS.format(last=19, points=20) + CURVE.replace("points = 10", "points = 4")
    text += '[[vary]]\nkey = "mistuning.standard_deviation"\nvalues = [0.01, 0.5]\n'
    text += '[choose]\nkey = "mistuning.standard_deviation"\noutput = "resonance_A"\n'
    path = str(study_file(text, SCENE))
    assert main(["study", path, "-o", str(tmp_path), "--scheduler", scheduler]) == 0
    said = capsys.readouterr()
    assert "internal resonance 1:3" in said.err
    lines = said.out.splitlines()
    assert lines.pop(2).startswith("best mistuning.standard_deviation = 0.01: 95% quantile of res")
    assert lines[0] == "study: 40 samples, 20 failed"  # those of 0.5
    assert lines[1].startswith("failed: 20 x mistuning.standard_deviation: must be")
    data = open_results(tmp_path / "study.zarr").sel(mode="A")
    factor = data["amplification"].values[data["mistuning.standard_deviation"].values == 0.01]
    _, low, high = rom.Amplification(np.sort(factor), 1.0, 24).extreme_quantile(0.999)
    assert lines[2].startswith("mistuning.standard_deviation = 0.01: amplification of 20 disks")
    assert f"({low:.3f} to {high:.3f}) by an extreme value distribution" in lines[2]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[outputs]\nsteady = true\n", "outputs: of a mistuned disk must be curve alone, got st"),
        (CURVE + "dofs = [2]\n", "outputs: of a mistuned disk must be curve alone, got curve, do"),
        ("", "outputs: of a mistuned disk must be curve alone, got none"),
    ],
)
def test_other_outputs_are_refused(study_file, text, said):
    with pytest.raises(SlipmodeError, match=said):
        load_study(study_file(SEEDS.format(last=2, points=3) + text, SCENE))


def test_seeds_are_integers(study_file):
    with pytest.raises(SlipmodeError, match=r"vary\[0\].points: must give integers"):
        load_study(study_file(SEEDS.format(last=4, points=4) + CURVE, SCENE))


def test_warnings_of_samples_are_one_line_with_their_number(study_file, tmp_path):
    """The workers are processes of their own, as by default."""
    text = 'set = {"structure.blade_stiffnesses" = [1e6, 2e6]}\n'
    text += SEEDS.format(last=59, points=60) + CURVE.replace("points = 10", "points = 3")
    command = ["study", str(study_file(text, SCENE)), "-o", str(tmp_path), "--workers", "2"]
    done = subprocess.run([SLIPMODE, *command], capture_output=True, text=True)
    assert done.returncode == 0
    assert "ValidityWarning" not in done.stderr
    (line,) = (each for each in done.stderr.splitlines() if "internal resonance" in each)
    assert line.startswith("slipmode: warning: internal resonance 1:3 is neglected")
    assert "(60 samples have such a warning" in line
