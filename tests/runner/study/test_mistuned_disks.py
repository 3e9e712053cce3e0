"""Studies of mistuned disks: amplification factors against `rom.MistunedDisk`, and refusals."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.__main__ import main
from slipmode.runner import open_results, run_study

SCENE = 'scene = "mistuned-disk"'
SEEDS = '[[vary]]\nkey = "mistuning.seed"\nfrom = 0\nto = {last}\npoints = {points}\n'
CURVE = '[outputs]\ncurve = {mode = "A", from = 190.0, to = 204.0, points = 10}\n'


@pytest.mark.slow
def test_factors_are_those_of_the_disks(study_file, tmp_path, capsys):
    text = SEEDS.format(last=2, points=3) + '[[vary]]\nkey = "forcing.A.amplitude"\n'
    path = str(study_file(text + f"values = [0.1, 4.0]\n{CURVE}", SCENE))
    assert main(["study", path, "-o", str(tmp_path), "--workers", "2"]) == 0
    said, results = capsys.readouterr().out, open_results(tmp_path / "study.zarr").sel(mode="A")
    structure = rom.lumped_disk(24, 1e-5, blade_stiffnesses=(1e6, 4e6))
    patterns = np.vstack([rom.random_mistuning(1, 24, 0.02, seed=seed) for seed in range(3)])
    disks = rom.MistunedDisk(structure, rom.Jenkins(1.0, 5e4), patterns, 1e5)
    omega = 2.0 * np.pi * np.linspace(190.0, 204.0, 10)
    for force in (0.1, 4.0):
        expected = disks.amplification(omega, 3, {2: force}, dof=2)
        own = results["forcing.A.amplitude"].values == force
        found = results["amplification"].values[own]
        np.testing.assert_allclose(np.sort(found), expected.factor, rtol=1e-4)
        peak = results["resonance"].values[own]
        np.testing.assert_allclose(peak / found, expected.tuned, rtol=1e-4)
        np.testing.assert_array_equal(peak, results["curve"].values[own].max(axis=1))
        assert f"forcing.A.amplitude = {force}: amplification of 3 disks: median " in said
    assert "below Whitehead's bound 2.949" in said


@pytest.mark.parametrize(
    ("points", "text", "said"),
    [
        (3, "", "outputs: of a mistuned disk must be curve alone, got none"),
        (4, CURVE, r"vary\[0\].points: must give integers"),
    ],
)
def test_other_studies_are_refused(study_file, tmp_path, points, text, said):
    with pytest.raises(rom.SlipmodeError, match=said):
        path = study_file(SEEDS.format(last=2 * points - 4, points=points) + text, SCENE)
        run_study(path, tmp_path)
