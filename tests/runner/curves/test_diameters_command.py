"""`slipmode diameters`: its files, its lines, what it refuses."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.__main__ import main

pytest.importorskip("matplotlib")


def test_the_command_writes_the_diagrams(tmp_path, capsys):
    arguments = ["diameters", "bladed-disk", "-o", str(tmp_path)]
    assert main(arguments) == 0
    *paths, line, _ = capsys.readouterr().out.splitlines()
    assert [path.rpartition(".")[2] for path in paths] == ["csv", "png", "rrd"]
    assert line == ("engine order 3 excites nodal diameter 3, mode 0 (196.963 Hz), at 3939.3 rpm")
    numbers = np.loadtxt(paths[0], delimiter=",", skiprows=1)
    diagram = rom.nodal_diameter_diagram(rom.lumped_disk(24, 1e-5), rom.Jenkins(1.0, 5e4))
    np.testing.assert_allclose(2.0 * np.pi * numbers[:, 1:], diagram.frequency, rtol=1e-12)
    more = ["--orders", "3", "21", "--speed", "500", "4000"]
    assert main([*arguments, *more]) == 0
    orders = [text.split()[2] for text in capsys.readouterr().out.splitlines()[3:-1]]
    assert orders == ["3", "21", "21", "21"]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["one-mode"], "structure.sectors: is missing: nodal diameters are those of a bladed"),
        (["bladed-disk", "-n", "9"], "--families: must be 1 to 3, got 9"),
        (["bladed-disk", "--speed", "9", "3"], "rotor_speed: must be two numbers >= 0, ascending"),
    ],
)
def test_refuses_in_one_line(arguments, line, tmp_path, capsys):
    assert main(["diameters", *arguments, "-o", str(tmp_path)]) == 1
    assert capsys.readouterr().err.startswith(f"slipmode: {line}")
