"""Hz and micrometres where the scene says so: in what it gives, and in what is shown of it."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from slipmode import rom
from slipmode.__main__ import main
from slipmode.rom import SlipmodeError, SpecialPoint
from slipmode.rom.slow.branches.oscillation import SlowCycles
from slipmode.rom.slow.units import Shown
from slipmode.runner import load, parse_scene, run, shipped_scenes
from slipmode.runner.curves.curve_charts import curve_charts
from slipmode.runner.view import views

MODAL = "kg^0.5 m"
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
        assert (tmp_path / f"{name}.curve.rrd").stat().st_size > 5_000
        assert (tmp_path / f"{name}.backbone.rrd").stat().st_size > 5_000
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


def test_recordings_of_curves_are_in_units_of_the_scene(two_mode_model):
    units = rom.Units("Hz", "mm")
    force = ({0: 0.15}, {1: 0.25})
    curve = rom.response_curve(two_mode_model, (0.98, 1.65), force, "frequency_A", (0.96, 1.0))
    ((A, B),) = curve_charts(curve, Shown(0, units, MODAL))
    assert (A.x.label, A.y.label) == ("frequency A [Hz]", "|A| at DOF 0 [mm]")
    (layer,) = A.layers  # one branch, all of it stable
    assert layer.name == "stable"
    np.testing.assert_allclose(2 * np.pi * layer.x, curve.parameter)
    np.testing.assert_allclose(layer.y, 1e3 * curve.displacement(0)[:, 0])
    assert B.y.label == "|B| at DOF 0 [mm]"
    ((frequency, damping),) = curve_charts(rom.backbone(two_mode_model), Shown(None, units, MODAL))
    assert (frequency.y.label, damping.y.label) == ("frequency [Hz]", "damping [-]")
    assert frequency.x.label == "amplitude [kg^0.5 m]"


def test_folds_and_branches_are_told_apart_in_recordings():
    """Two branches, one of which turns back; amplitudes oscillate at one of its points."""
    cycles = SlowCycles(np.array([1.5]), np.array([[0.5]]), np.array([[0.8]]))
    fold = SpecialPoint("fold", 2.0, np.array([1.0 + 0j]))
    size, growth = np.array([[0.1], [1.0], [2.0], [3.0], [3.5]]), np.array([-1, -1, 1, -1, -1.0])
    parameter, branch = np.array([1.0, 2.0, 1.5, 1.0, 2.0]), np.array([0, 0, 0, 1, 1])
    shapes = np.ones((1, 1))
    motion = SimpleNamespace(amplitude=np.vstack((size, [[1.0], [0.5], [0.8]])))
    curve = rom.ResponseCurve(
        *("limit", parameter, size + 0j, 0.01 * size, growth, branch, (fold,), shapes),
        *(cycles, np.zeros(0), motion),
    )
    (((chart),),) = curve_charts(curve, Shown(None, rom.Units("Hz"), MODAL))
    stable, unstable, at_fold, band = chart.layers
    assert [each.name for each in chart.layers] == [
        "stable",
        "unstable",
        "fold",
        "slow limit cycles",
    ]
    assert np.isnan(stable.y).tolist() == [False, False, True, True, False, False]
    assert np.isnan(unstable.y).tolist() == [True, True, False, True, True, True]
    assert (at_fold.x.tolist(), at_fold.y.tolist()) == ([2.0], [1.0])
    np.testing.assert_array_equal(band.y, [0.5, 0.8, np.nan])
    assert chart.x.label == "limit [-]"


def test_views_show_units_of_the_scene_and_files_keep_theirs(tmp_path, monkeypatch):
    """The same run with and without [units]: all that is sent to Rerun differs by factors."""
    sent, labels = {}, {}

    def collect(stream, channel, time_ns, values):
        sent.setdefault(channel.topic, []).append(values)
        labels[channel.topic] = [field.unit for field in channel.fields]

    monkeypatch.setattr(views, "send_series", collect)
    shown, recorded = [], []
    for text in (ONE_MODE, in_hertz()):
        recording = run(parse_scene(text, "."), tmp_path)
        shown.append(({k: np.concatenate(v) for k, v in sent.items()}, dict(labels)))
        recorded.append(load(recording.mcap))
        sent.clear()
    (plain, _), (hertz, units) = shown
    frequency = plain["/forcing"][:, units["/forcing"].index("Hz")]
    in_hz = hertz["/forcing"][:, units["/forcing"].index("Hz")]
    np.testing.assert_allclose(2 * np.pi * in_hz, frequency, rtol=1e-12)
    at = units["/contact/0"].index("um")
    np.testing.assert_allclose(
        hertz["/contact/0"][:, at], 1e6 * plain["/contact/0"][:, at], rtol=1e-6
    )
    np.testing.assert_allclose(hertz["/modes"], plain["/modes"], rtol=1e-9)
    for topic in recorded[0]:
        assert recorded[0][topic].units == recorded[1][topic].units
    layout = json.loads(recording.mcap.with_suffix(".foxglove.json").read_text(encoding="utf-8"))
    (path,) = layout["configById"]["Plot!Forcing-frequency"]["paths"]
    assert path["label"] == "Frequency A [Hz]"
    topic, _, factor = path["value"].partition(".@mul(")
    assert topic == "/forcing.A_frequency"
    assert float(factor.rstrip(")")) == pytest.approx(1 / (2 * np.pi), rel=1e-15)


def test_other_units_are_refused():
    with pytest.raises(SlipmodeError, match=r'units\.frequency: must be "rad/s" or "Hz"|one of'):
        parse_scene(in_hertz().replace('"Hz"', '"rpm"'), ".")
    with pytest.raises(SlipmodeError, match=r"^units\.displacement: must be one of m, mm, um"):
        rom.Units(displacement="inch")
