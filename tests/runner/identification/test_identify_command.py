"""`slipmode identify` from files of decays to a report, pictures, a scene and an FMU."""

import re

import numpy as np
import pytest
from measured.decays import RATE, TRUE, decay, decays, power_law_amplitude, times

from slipmode import fmu, rom, runner
from slipmode.__main__ import main
from slipmode.runner.fmi.load import open_fmu

pytest.importorskip("matplotlib")

WRITTEN = {"report.txt", "backbone.csv", "backbone.png", "decays.png"}
WRITTEN |= {"model.npz", "scene.toml", "model.fmu"}
BAND_A, BAND_B = ["--band", "100", "140"], ["--band", "225", "260"]
MASSES = [2.0, 0.5]  # [kg]


def write(folder, signals, header="time,velocity"):
    for k, y in enumerate(signals, 1):
        table = np.column_stack([times(), y])
        np.savetxt(folder / f"hit{k}.csv", table, "%.7g", ",", header=header, comments="")
    return str(folder / "hit*.csv")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """(what is printed, folder) of two modes."""
    folder = tmp_path_factory.mktemp("identify")
    files, out = write(folder, decays(1, 5)), folder / "beam"
    options = ["--unit", "m/s", "--hold-out", "2", "hit5", "--law", "power", "-o", str(out)]
    masses = ["--modal-mass", *map(str, MASSES)]
    capture = pytest.MonkeyPatch()
    lines = []
    capture.setattr("builtins.print", lambda *words, **_: lines.append(" ".join(map(str, words))))
    assert main(["identify", files, *BAND_A, *BAND_B, *options, *masses]) == 0
    capture.undo()
    return "\n".join(lines), out


def test_the_report_has_law_intervals_and_records(done):
    printed, out = done
    assert {path.name for path in out.iterdir()} == WRITTEN
    text = (out / "report.txt").read_text(encoding="utf-8")
    assert printed.startswith(text.rstrip())
    assert [printed.count(f"\n{out / name}") for name in sorted(WRITTEN)] == [1] * len(WRITTEN)
    use = {line.split()[0]: line.split()[1] for line in text.splitlines() if line[:3] == "hit"}
    assert use == {"hit1": "fitted", "hit2": "held", "hit3": "fitted", "hit4": "fitted"} | {
        "hit5": "held"
    }
    assert "2 held out: mean error" in text
    assert "law: power" in text and "not identified: none" in text
    rows = (line.split() for line in text.splitlines() if " to " in line)
    values = {row[0]: [float(row[k]) for k in (1, 2, 4)] for row in rows if "_" in row[0]}
    value, low, high = values["delta_0_A"]
    assert value == pytest.approx(0.4, rel=0.02)
    assert low < value < high
    assert "modal mass at velocity: 2, 0.5 kg" in text


def test_backbones_are_those_of_the_decays(done):
    with (done[1] / "backbone.csv").open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        columns = dict(zip(names, np.loadtxt(file, delimiter=",").T, strict=True))
    for mode, (delta_0, omega_0, g, h, p) in zip("AB", TRUE, strict=True):
        r = columns[f"{mode} amplitude [m/s]"]
        omega, zeta = (columns[f"{mode} {name}"] for name in ("frequency [Hz]", "damping [-]"))
        omega = 2.0 * np.pi * omega
        np.testing.assert_allclose(omega, omega_0 - h * r**p, atol=0.02)
        np.testing.assert_allclose(zeta * omega, delta_0 + g * r**p, rtol=0.02)
        assert np.isfinite(columns[f"{mode} damping deviation [-]"]).all()


def test_the_scene_decays_as_the_law(done, tmp_path):
    assert main(["run", str(done[1] / "scene.toml"), "-o", str(tmp_path)]) == 0
    data = runner.load(tmp_path / "scene.mcap")
    for mode, own, mass in zip("AB", TRUE, MASSES, strict=True):
        velocity = data["/modes"].column(f"{mode}_abs") * 2.0 / np.sqrt(mass) * own[1]
        exact = power_law_amplitude(data["/modes"].time, velocity[0], *own)
        np.testing.assert_allclose(velocity, np.abs(exact), atol=0.01 * velocity[0])
    assert np.abs(data["/elastic"].column("x_0")).max() > 0.0


def test_the_fmu_takes_the_steps_of_the_component(done):
    plan = runner.make_plan(runner.load_scene(done[1] / "scene.toml"))
    model = rom.Model.load(done[1] / "model.npz")
    component = fmu.Component(
        model, plan.excited.force_patterns, tolerance=plan.scene.run.tolerance, warned=False
    )
    component.reset(amplitude=plan.excited.amplitude)
    frequencies = {f"frequency_{m}": plan.scene.forcing[m].frequency.value(0.0) for m in "AB"}
    component.set_inputs(**{name: float(value) for name, value in frequencies.items()})
    with open_fmu(done[1] / "model.fmu", plan, model) as imported:
        for k in range(3):
            component.do_step(0.1 * k, 0.1)
            imported.do_step(0.1 * k, 0.1)
            for name in ("A_re", "A_im", "B_re", "B_im", "theta_B"):
                assert imported.outputs()[name] == component.outputs()[name] != 0.0


@pytest.mark.parametrize("cross", ["yes", "no"])
def test_cross_effects_may_be_given(tmp_path, cross, capsys):
    files, out = write(tmp_path, decays(1, 3)), str(tmp_path / "out")
    options = ["--unit", "m/s", "--law", "power", "--cross", cross, "-o", out]
    assert main(["identify", files, *BAND_A, *BAND_B, *options]) == 0
    printed = capsys.readouterr().out
    assert ("law: power with cross effects" in printed) == (cross == "yes")
    assert ("kappa_A" in printed) == (cross == "yes")


def test_a_law_with_quadratic_coupling_has_a_report_and_no_model(tmp_path, capsys):
    files, out = write(tmp_path, decays(1, 3)), tmp_path / "out"
    options = ["--unit", "m/s", "--law", "quadratic", "--cross", "no", "-o", str(out)]
    assert main(["identify", files, *BAND_A, *BAND_B, *options]) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()[-1:]
    assert line.startswith("slipmode: --law: a model cannot contain quadratic coupling")
    assert "identify with --law power to fit" in line
    assert {path.name for path in out.iterdir()} == WRITTEN - {
        "model.npz",
        "scene.toml",
        "model.fmu",
    }


def test_one_mode_without_a_modal_mass_says_that_forces_are_relative(tmp_path, capsys):
    one = decays(3, 3, modes=TRUE[:1])
    files = write(tmp_path, one, header="time,acc")
    options = ["--unit", "mm/s^2", "--law", "power", "-o", str(tmp_path / "out")]
    assert main(["identify", files, *BAND_A, *options]) == 0
    printed = capsys.readouterr().out
    assert "modal mass at acc: 1 kg, not measured: forces on the model are relative" in printed
    assert {path.name for path in (tmp_path / "out").iterdir()} == WRITTEN


def signals(case):
    rng = np.random.default_rng(7)
    if case == "noise":
        return [rng.standard_normal(times().size) for _ in range(3)]
    made = [decay(rng, TRUE[:1]) for _ in range(3)]
    return [np.clip(y, -0.2, 0.2) for y in made] if case == "clipped" else made


MS = ["--unit", "m/s"]
REFUSED = {
    "no file": ("absent", [*BAND_A, *MS], "there is no file"),
    "unit": ("sound", BAND_A, "unit: .*hit1.csv does not state one; give --unit, such as"),
    "volt": ("sound", [*BAND_A, "--unit", "V"], r"--unit 'V': must be m, m/s, m/s\^2"),
    "noise": ("noise", [*BAND_A, *MS], "--band: 100 to 140 Hz has no decay of a mode"),
    "clipped": ("clipped", [*BAND_A, *MS], "data: no record can be fitted .*clipp"),
    "sampling": ("sound", ["--band", "700", "900", *MS], "--band: 900 Hz needs a sampling rate"),
    "empty band": ("sound", ["--band", "140", "100", *MS], "--band .*: must be 0 < lower < upper"),
    "three": ("sound", [*BAND_A, *BAND_B, *BAND_B, *MS], "such as --band 100 140 --band 225 260$"),
    "overlap": ("sound", [*BAND_A, "--band", "130", "260", *MS], "--band .*: must not overlap"),
    "record": ("sound", [*BAND_A, *MS, "--hold-out", "9"], "record 9 is not in the measurement"),
    "all": ("sound", [*BAND_A, *MS, "--hold-out", "1", "2", "3"], "data: no record .*held out"),
    "mass": ("sound", [*BAND_A, *MS, "--modal-mass", "1", "2"], r"--modal-mass \[1.0, 2.0\]: mus"),
    "rate": ("sound", [*BAND_A, *MS, "--sample-rate", "-1"], r"--sample-rate -1.0: must be > 0"),
    "quadratic": ("sound", [*BAND_A, *MS, "--law", "quadratic"], "--band: .*need two modes"),
    "cross": (
        "sound",
        [*BAND_A, *MS, "--cross", "yes"],
        "--band: cross effects .* need two modes",
    ),
    "linear": (
        "sound",
        [*BAND_A, *BAND_B, *MS, "--cross", "yes", "--law", "linear"],
        "--cross: a linear law has no cross effects",
    ),
    "channel": (
        "sound",
        [*BAND_A, *MS, "--channels", "force"],
        "--channels: .* has velocity, not",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_ends_in_one_line(case, tmp_path, capsys):
    kind, options, words = REFUSED[case]
    files = str(tmp_path / "hit*.csv") if kind == "absent" else write(tmp_path, signals(kind))
    assert main(["identify", files, *options, "-o", str(tmp_path / "out")]) == 1
    printed = capsys.readouterr()
    (line,) = (each for each in printed.err.splitlines() if each.startswith("slipmode: "))
    assert not printed.out and not (tmp_path / "out").exists()
    assert re.search(words, line), line
    assert "bands" not in line.split(":")[1]
    assert not re.search(r"\w=(?!\w)", line)


def test_excluded_records_and_missing_intervals_are_named(tmp_path, capsys):
    clipped, *sound = signals("clipped")[:1] + signals("sound")[1:]
    files = write(tmp_path, [clipped, *sound])
    assert main(["identify", files, *BAND_A, *MS, "-o", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"hit1 +excluded\n    it is clipped", printed)
    assert "2 fitted" in printed and "needs three records" in printed
    assert "not identified: unknown with fewer than three fitted records" in printed


def test_the_sampling_rate_may_be_given(tmp_path):
    np.savez(tmp_path / "hits.npz", **{f"v_{k}": y for k, y in enumerate(signals("sound"), 1)})
    options = ["--sample-rate", str(RATE), "--law", "linear", *MS, "-o", str(tmp_path / "out")]
    assert main(["identify", str(tmp_path / "hits.npz"), *BAND_A, *options]) == 0


def test_the_fmu_runs_in_model_exchange_from_its_start(done):
    """By CVode, whose first evaluations are around the start values."""
    fmpy = pytest.importorskip("fmpy")
    names = ["A_abs", "B_abs"]
    result = fmpy.simulate_fmu(
        str(done[1] / "model.fmu"),
        fmi_type="ModelExchange",
        solver="CVode",
        stop_time=1.0,
        output_interval=0.1,
        relative_tolerance=1e-6,
        output=names,
    )
    for name, own in zip(names, TRUE, strict=True):
        size = result[name]
        # In sensor units: the velocity is 2 omega phi |a|, with phi = 1 / sqrt(modal mass).
        unit = 2.0 * own[1] / np.sqrt(MASSES[names.index(name)])
        exact = np.abs(power_law_amplitude(result["time"], size[0] * unit, *own))
        np.testing.assert_allclose(size * unit, exact, rtol=0.02)
