"""Hz and micrometres where the scene says so: in what it gives, and in what is shown of it."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import SlipmodeError
from slipmode.runner.cli import main
from slipmode.runner.scene.scene import parse_scene, shipped_scenes

ONE_MODE = shipped_scenes()["one-mode"].read_text(encoding="utf-8")


def in_hertz():
    """The shipped scene with its frequency in Hz."""
    lines = []
    for line in ONE_MODE.splitlines():
        if line.startswith("frequency = "):
            omega = float(line.split("=")[1].split("#")[0])
            line = f"frequency = {omega / (2 * np.pi)!r}"
        lines.append(line)
    return "\n".join(lines) + '\n[units]\nfrequency = "Hz"\ndisplacement = "um"\n'


def read(path):
    with path.open() as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",").T, strict=True))


def test_frequencies_are_read_in_hertz():
    plain, hertz = (parse_scene(text, ".") for text in (ONE_MODE, in_hertz()))
    expected = plain.forcing["A"].frequency
    assert hertz.forcing["A"].frequency.times == expected.times
    assert hertz.forcing["A"].frequency.values == pytest.approx(expected.values, rel=1e-14)


def test_curves_are_written_in_units_of_the_scene(tmp_path):
    pytest.importorskip("matplotlib")
    (tmp_path / "hertz.toml").write_text(in_hertz(), encoding="utf-8")
    (tmp_path / "plain.toml").write_text(ONE_MODE, encoding="utf-8")
    for name in ("plain", "hertz"):
        span = np.array([0.96, 1.0]) / (2 * np.pi if name == "hertz" else 1.0)
        scene, out = str(tmp_path / f"{name}.toml"), ["--dof", "0", "-o", str(tmp_path)]
        assert main(["curve", scene, "--span", *map(repr, span.tolist()), *out]) == 0
        assert main(["backbone", scene, *out]) == 0
    for kind, of_frequency, size in (
        ("curve", "frequency_A", "A"),
        ("backbone", "frequency", "amplitude"),
    ):
        plain, hertz = (read(tmp_path / f"{name}.{kind}.csv") for name in ("plain", "hertz"))
        shown = 2 * np.pi * hertz[f"{of_frequency} [Hz]"]
        assert shown == pytest.approx(plain[of_frequency], rel=1e-6)
        metres = plain[f"{size} at DOF 0 [m]"]
        assert hertz[f"{size} at DOF 0 [um]"] == pytest.approx(1e6 * metres, rel=1e-5)
        assert metres.max() > 0.1


def test_other_units_are_refused():
    with pytest.raises(SlipmodeError, match=r'units\.frequency: must be "rad/s" or "Hz"|one of'):
        parse_scene(in_hertz().replace('"Hz"', '"rpm"'), ".")
    with pytest.raises(SlipmodeError, match=r"^units\.displacement: must be one of m, mm, um"):
        rom.Units(displacement="inch")
