"""`slipmode identify` from files to a report, pictures, a scene and an FMU."""

import re
import tomllib

import numpy as np
import pytest
from measured.decays import TRUE, decay, decays, measurement, power_law_amplitude, times
from measured.sine_tests import Oscillator, response_controlled

from slipmode import rom, runner
from slipmode.__main__ import main

pytest.importorskip("matplotlib")

WRITTEN = {"report.txt", "backbone.csv", "backbone.png", "model.npz", "scene.toml", "model.fmu"}
BAND_A, BAND_B, MS = ["--band", "100", "140"], ["--band", "225", "260"], ["--unit", "m/s"]
MASSES = [2.0, 0.5]  # [kg]
MASS = Oscillator(c3=1.5e8)
LEVELS = (10, 25, 40, 55, 70)
SINE, UNITS = ["--sine", "--band", "78", "82"], ["--unit", "m/s^2", "--force-unit", "N"]


def write(folder, signals, header="time,velocity"):
    for k, y in enumerate(signals, 1):
        table = np.column_stack([times(), y])
        np.savetxt(folder / f"hit{k}.csv", table, "%.7g", ",", header=header, comments="")
    return str(folder / "hit*.csv")


def write_sine(folder, levels=LEVELS):
    for a in levels:
        test = response_controlled(MASS, a, np.linspace(79.0, 81.0, 41), 0.1)
        columns = [test.frequency, np.abs(test.force), np.abs(test.response)]
        table = np.column_stack([*columns, np.angle(test.response / test.force)])
        header = "frequency,force,amplitude,phase"
        np.savetxt(folder / f"a{a}.csv", table, "%.9g", ",", header=header, comments="")
    return str(folder / "a*.csv")


def identify(files, *options):
    return main(["identify", files, *options])


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Folder of what was identified of two modes."""
    folder = tmp_path_factory.mktemp("identify")
    files, out = write(folder, decays(1, 5)), folder / "beam"
    options = ["--hold-out", "2", "hit5", "--law", "power", "--cross", "no", "-o", str(out)]
    masses = ["--modal-mass", *map(str, MASSES)]
    assert identify(files, *BAND_A, *BAND_B, *MS, *options, *masses) == 0
    return out


@pytest.mark.oracle
def test_the_report_has_law_intervals_and_records(done):
    assert {path.name for path in done.iterdir()} == WRITTEN | {"decays.png"}
    text = (done / "report.txt").read_text(encoding="utf-8")
    use = [line.split()[1] for line in text.splitlines() if line[:3] == "hit"]
    assert use == ["fitted", "held", "fitted", "fitted", "held"]
    assert "2 held out: mean error" in text and "modal mass at velocity: 2, 0.5 kg" in text
    assert "law: power" in text and "not identified: none" in text
    assert "40 samples of the parameters in the model" in text
    rows = (line.split() for line in text.splitlines() if " to " in line)
    values = {row[0]: [float(row[k]) for k in (1, 2, 4)] for row in rows if "_" in row[0]}
    value, low, high = values["delta_0_A"]
    assert value == pytest.approx(0.4, rel=0.02)
    assert low < value < high


@pytest.mark.oracle
def test_backbones_are_those_of_the_decays(done):
    with (done / "backbone.csv").open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        columns = dict(zip(names, np.loadtxt(file, delimiter=",").T, strict=True))
    for mode, (delta_0, omega_0, g, h, p) in zip("AB", TRUE, strict=True):
        r = columns[f"{mode} amplitude [m/s]"]
        omega, zeta = (columns[f"{mode} {name}"] for name in ("frequency [Hz]", "damping [-]"))
        omega = 2.0 * np.pi * omega
        np.testing.assert_allclose(omega, omega_0 - h * r**p, atol=0.02)
        np.testing.assert_allclose(zeta * omega, delta_0 + g * r**p, rtol=0.02)
        assert np.isfinite(columns[f"{mode} damping deviation [-]"]).all()


@pytest.mark.oracle
@pytest.mark.parametrize("kind", ["scene", "FMU"])
def test_the_scene_and_the_fmu_decay_as_the_law(kind, done, tmp_path):
    if kind == "scene":
        assert main(["run", str(done / "scene.toml"), "-o", str(tmp_path)]) == 0
        data = runner.load(tmp_path / "scene.mcap")
        time, sizes = data["/modes"].time, [data["/modes"].column(f"{m}_abs") for m in "AB"]
        assert np.abs(data["/elastic"].column("x_0")).max() > 0.0
    else:  # by CVode, whose first evaluations are around the start values
        result = pytest.importorskip("fmpy").simulate_fmu(
            str(done / "model.fmu"),
            fmi_type="ModelExchange",
            solver="CVode",
            stop_time=1.0,
            output_interval=0.1,
            relative_tolerance=1e-6,
            output=["A_abs", "B_abs"],
        )
        time, sizes = result["time"], [result["A_abs"], result["B_abs"]]
    for size, own, mass in zip(sizes, TRUE, MASSES, strict=True):
        velocity = size * 2.0 / np.sqrt(mass) * own[1]  # at the sensor, 2 omega phi |a|
        exact = np.abs(power_law_amplitude(time, velocity[0], *own))
        np.testing.assert_allclose(velocity, exact, atol=0.01 * velocity[0])


@pytest.mark.oracle
@pytest.mark.slow
def test_the_band_of_runs_contains_the_true_decay(tmp_path):
    """The band of 90 % of the samples; in 60 cases it contained 93 to 98 % of the truth."""
    inside, band = [], [(100.0, 140.0)]
    for seed in range(20):
        data = measurement(decays(seed, 5, modes=TRUE[:1], noise=1e-2))
        found = rom.identify(data, bands=band, law="power")
        found.model(samples=40).save(tmp_path / "model.npz")
        per_unit = abs(found.sensor_factors()[0])
        start = f"A = [{0.9 * found.range[0, 1] / per_unit}, 0.0]"
        scene = (
            f'[model]\nfile = "model.npz"\n[initial]\n{start}\n[run]\nduration = 2.0\nstep = 0.1'
        )
        run = runner.run(runner.parse_scene(scene, tmp_path), tmp_path)
        modes = run.read().channels["/modes"]
        size, low, high = (per_unit * modes.column(f"A_abs{x}") for x in ("", "_5", "_95"))
        exact = np.abs(power_law_amplitude(modes.time, size[0], *TRUE[0]))
        inside.append(((low <= exact) & (exact <= high))[1:])
    assert np.mean(inside) > 0.85


def signals(case):
    rng = np.random.default_rng(7)
    if case == "noise":
        return [rng.standard_normal(times().size) for _ in range(3)]
    made = [decay(rng, TRUE[:1]) for _ in range(3)]
    return [np.clip(y, -0.2, 0.2) for y in made] if case == "clipped" else made


def test_excluded_records_and_missing_intervals_and_masses_are_named(tmp_path, capsys):
    clipped, *sound = signals("clipped")[:1] + signals("sound")[1:]
    files = write(tmp_path, [clipped, *sound], header="time,acc")
    options = ["--unit", "mm/s^2", "--law", "power", "-o", str(tmp_path / "out")]
    assert identify(files, *BAND_A, *options) == 0
    printed = capsys.readouterr().out
    assert re.search(r"hit1 +excluded\n    it is clipped", printed)
    assert "2 fitted" in printed and "needs three records" in printed
    assert "not identified: unknown with fewer than three fitted records" in printed
    assert "modal mass at acc: 1 kg, not measured: forces on the model are relative" in printed


@pytest.fixture(scope="module")
def sine(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sine")
    options = ["--hold-out", "a40", "-o", str(folder / "beam")]
    assert identify(write_sine(folder), *SINE, *UNITS, *options) == 0
    return folder / "beam"


@pytest.mark.oracle
def test_the_report_of_sine_tests_has_law_levels_and_predictions(sine):
    assert {path.name for path in sine.iterdir()} == WRITTEN | {"sine_tests.png"}
    text = (sine / "report.txt").read_text(encoding="utf-8")
    rows = {line.split()[0]: line for line in text.splitlines() if line}
    assert {f"a{a}" for a in LEVELS} <= set(rows)
    held = r"held out: error (below )?0\.\d+ % of the peak, peak [-+]0\.\d+ %"
    assert re.search(held, rows["a40"]) and rows["modal_mass"].endswith("kg")
    for name, true in (("modal_mass", 1.8), ("delta_0_A", 0.004 * MASS.omega), ("p_A", 2.0)):
        assert float(rows[name].split()[1]) == pytest.approx(true, rel=0.02)


@pytest.mark.oracle
def test_the_scene_of_sine_tests_decays_as_the_oscillator(sine, tmp_path):
    assert main(["run", str(sine / "scene.toml"), "-o", str(tmp_path)]) == 0
    modes = runner.load(tmp_path / "scene.mcap")["/modes"]
    x = 2.0 * modes.column("A_abs") / np.sqrt(MASS.m)  # at the sensor [m]
    assert x[0] * MASS.omega**2 == pytest.approx(0.95 * 70.0, rel=5e-3)  # inside the table
    rates = MASS.zeta * MASS.omega, MASS.omega, MASS.c3 / (8.0 * MASS.m), 0.0, 2.0
    exact = np.abs(power_law_amplitude(modes.time, x[0], *rates))
    assert x == pytest.approx(exact, abs=0.01 * x[0])
    assert exact[-1] < 0.15 * x[0]


REFUSED = [  # files, options, what the line contains
    ("absent", [*BAND_A, *MS], "there is no file"),
    ("sound", BAND_A, "unit: .*hit1.csv does not state one; give --unit, such as"),
    ("noise", [*BAND_A, *MS], "--band: 100 to 140 Hz has no decay of a mode"),
    ("sound", ["--band", "140", "100", *MS], "--band .*: must be 0 < lower < upper"),
    ("sound", [*BAND_A, *BAND_B, *BAND_B, *MS], "such as --band 100 140 --band 225 260$"),
    ("sound", [*BAND_A, *MS, "--hold-out", "9"], "record 9 is not in the measurement"),
    ("sound", [*BAND_A, *MS, "--law", "quadratic"], "--band: .*need two modes"),
    ("sine", [*SINE, *UNITS, "--band", "90", "99"], "--band: sine tests are of one mode"),
    ("sine", [*SINE, *UNITS, "--modal-mass", "1"], "--modal-mass: is for decays, not"),
    ("sound", ["--loops", *BAND_A], "--band: is not for loops; leave it out"),
    ("sound", ["--loops"], "must have one displacement and one force, got time, velocity"),
    ("sound", MS, "--band: is missing; give the frequencies around each mode"),
    ("sine", [*SINE[1:], *UNITS], "--force-unit: is for sine tests; give --sine"),
]


@pytest.mark.parametrize(("files", "options", "words"), REFUSED)
def test_bad_input_ends_in_one_line(files, options, words, tmp_path, capsys):
    names = str(tmp_path / "hit*.csv")
    if files != "absent":
        names = write_sine(tmp_path) if files == "sine" else write(tmp_path, signals(files))
    assert identify(names, *options, "-o", str(tmp_path / "out")) == 1
    printed = capsys.readouterr()
    (line,) = (each for each in printed.err.splitlines() if each.startswith("slipmode: "))
    assert not printed.out and not (tmp_path / "out").exists()
    assert re.search(words, line), line
    assert "bands" not in line.split(":")[1] and not re.search(r"\w=(?!\w)", line)


def test_loops_give_a_table_of_contacts(tmp_path, capsys):
    """A Jenkins element of 1e7 N/m and 100 N, and a spring of 1e6 N/m."""
    x, d = 5e-5 * np.sin(2.0 * np.pi * np.arange(601) / 100.0), [0.0]
    for step in np.diff(x):
        d.append(min(max(d[-1] + step, -1e-5), 1e-5))
    table = np.column_stack([1e3 * x, 1e7 * np.array(d) + 1e6 * x])
    np.savetxt(tmp_path / "joint.csv", table, "%.9g", ",", header="x [mm],force [N]", comments="")
    assert identify(str(tmp_path / "joint.csv"), "--loops", "-o", str(tmp_path)) == 0
    assert "model: one Jenkins element + spring" in capsys.readouterr().out
    assert (tmp_path / "report.txt").exists() and (tmp_path / "loops.png").exists()
    (group,) = tomllib.loads((tmp_path / "contacts_joint.toml").read_text())["contacts"]
    assert group["law"] == "sliders" and group["limit"][0] == pytest.approx(100.0, rel=1e-3)
    assert group["stiffness"] == pytest.approx([1e7, 1e6], rel=1e-3)
