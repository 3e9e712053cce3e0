"""Names of matrices in a file with several: on the command line, and in scenes."""

import numpy as np
import pytest
import scipy.io

from slipmode.__main__ import main
from slipmode.runner import parse_scene

pytestmark = pytest.mark.quick

STIFFNESS = np.diag([1e4, 4e4, 9e4]) - 1e3 * (np.eye(3, k=1) + np.eye(3, k=-1))
SCENE = """
title = "Names"
[structure]
matrices = "w.mat"
stiffness_name = "K2"
[[contacts]]
law = "jenkins"
limit = 50.0
stiffness = 200.0
[modes]
A = 0
[forcing.A]
dof = 0
amplitude = 0.02
frequency = 100.0
[run]
duration = 100.0
step = 10.0
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    K = {"K1": STIFFNESS, "K2": 4.0 * STIFFNESS, "damp": 0.1}
    scipy.io.savemat(tmp_path / "w.mat", K | {"M": np.eye(3), "contact": [[0]]})
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_command_line_asks_for_a_name_and_takes_it(folder, capsys):
    assert main(["modes", "w.mat", "-n", "1"]) == 1
    said = capsys.readouterr().err
    assert 'choose one: --stiffness-name "K1" (in scenes stiffness_name)' in said
    assert main(["modes", "w.mat", "-n", "1", "--stiffness-name", "K2"]) == 0
    first = 2.0 * np.sqrt(np.linalg.eigvalsh(STIFFNESS)[0]) / (2.0 * np.pi)
    assert f"{first:.5g}" in capsys.readouterr().out
    assert main(["modes", "two-mode", "--mass-name", "M"]) == 1
    assert "are in the scene; leave them out" in capsys.readouterr().err


def test_a_scene_names_its_matrices(folder):
    structure = parse_scene(SCENE, folder).structure.build()
    np.testing.assert_array_equal(structure.stiffness.toarray(), 4.0 * STIFFNESS)
