"""Studies from file to results: the numbers, what fails, what the command says."""

import numpy as np
import pytest
from oracles.system import System, Tone, jenkins
from oracles.time_integration import steady_harmonics
from rates.saved_models import TWO_SHAPES, steady_sizes, two_modes, two_rates

from slipmode import runner
from slipmode.__main__ import main
from slipmode.runner import run_study, shipped_scenes

ONE_MODE = shipped_scenes()["one-mode"].read_text()
COULOMB = ONE_MODE.replace('law = "tanh"', 'law = "coulomb"').replace("alpha = 0.02", "")
VARY = '[[vary]]\nkey = "{}"\nvalues = {}\n'
STEADY = "[outputs]\nsteady = true\n"


def computed(path, folder):
    return run_study(path, folder, workers=2).dataset().load()


@pytest.mark.oracle
def test_samples_of_a_saved_model_have_their_closed_form(study_file, tmp_path):
    two_modes().save(tmp_path / "two.npz")
    frequency = 2.0 * np.pi * np.array([121.6, 242.6])
    scene = (
        '[model]\nfile = "two.npz"\n'
        f"[forcing.A]\ndof = 0\namplitude = 4.0\nfrequency = {frequency[0]}\n"
        f"[forcing.B]\ndof = 1\namplitude = 5.0\nfrequency = {frequency[1]}\n"
        "[run]\nduration = 9.0\nstep = 0.01\n"
    )
    vary = VARY.format("forcing.A.amplitude", "[2.0, 4.0, 400.0]")
    path = study_file(vary + STEADY + "times = [9.0]\n", scene)
    data = computed(path, tmp_path)
    assert data["status"].values.tolist() == [1, 1, 2]
    assert "outside the friction table" in data["reason"].values[2]
    for k, force in enumerate((2.0, 4.0)):
        modal = [force * TWO_SHAPES[0, 0], 5.0 * abs(TWO_SHAPES[1, 1])]
        exact = steady_sizes(two_rates, modal, frequency)
        np.testing.assert_allclose(data["steady"][k], exact, rtol=1e-4)
        np.testing.assert_allclose(data["at"][k, :, 0], exact, rtol=1e-3)


@pytest.mark.oracle
def test_displacements_of_dofs_are_those_of_time_integration(study_file, tmp_path):
    """A force at the first mass of a chain moves it mostly besides the first mode."""
    K = 1e4 * (2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1))
    C, W = 3e-5 * K, np.eye(4)[:, [1]]
    np.savez(tmp_path / "chain.npz", mass=np.eye(4), stiffness=K, damping=C, contact=W)
    system = System(np.eye(4), C, K, W, [jenkins(1.0, 3e3)])
    frequency = 0.99 * float(np.sqrt(np.linalg.eigvalsh(system.stuck())[0]))
    scene = f"""
        structure.matrices = "chain.npz"
        modes.A = 0
        contacts = [{{law = "jenkins", limit = 1.0, stiffness = 3e3}}]
        forcing.A = {{dof = 0, amplitude = 2.0, frequency = {frequency}}}
        run = {{duration = 40.0, step = 0.1}}
    """
    curve = f'curve = {{mode = "A", from = {frequency}, to = {1.01 * frequency}, points = 2}}\n'
    wanted = STEADY + "peak = true\ntimes = [40.0]\ndofs = [0, 3]\n" + curve
    path = study_file(VARY.format("forcing.A.amplitude", "[1.0, 2.0]") + wanted, scene)
    data = computed(path, tmp_path)
    for k, force in enumerate((1.0, 2.0)):
        tone = Tone(frequency, force * np.eye(4, dtype=complex)[0])
        exact = np.abs(steady_harmonics(system, [tone], [[1]], steps=512).amplitude[0, [0, 3]])
        found = data.isel(sample=k).sel(mode="A")
        shown = found["steady_displacement"], found["curve_displacement"][0]
        for each in (*shown, found["at_displacement"][0]):
            np.testing.assert_allclose(each, exact, rtol=1e-2)  # tolerance of the scene
        assert (found["peak_displacement"] > 0.99 * exact).all()


def test_a_sample_that_fails_says_why_and_the_others_are_there(study_file, tmp_path):
    path = study_file(
        VARY.format("forcing.A.amplitude", "[0.1, -0.1]")
        + VARY.format("forcing.A.frequency", "[0.98, 30.0]")
        + VARY.format("modes.A", "[0, 7]")
        + STEADY
    )
    data = computed(path, tmp_path)
    assert data["status"].values.tolist() == [1] + [2] * 7
    assert np.isfinite(data["steady"].sel(mode="A").values).tolist() == [True] + [False] * 7
    reasons = data["reason"].values.tolist()
    assert reasons[1].startswith("frequency: must be 0.62")
    assert reasons[2].startswith("forcing.A.amplitude: must be >= 0")
    assert all("mode" in each for each in reasons[4:6])


@pytest.mark.oracle
def test_coulomb_samples_scale_with_their_limit(study_file, tmp_path):
    """The friction of a Coulomb contact is homogeneous: a(F; limit) = limit a(F / limit; 1)."""
    amplitude, limit = [0.1, 0.15, 0.2], [1.0, 1.5, 2.0]
    path = study_file(
        VARY.format("forcing.A.amplitude", amplitude)
        + VARY.format("friction.limit", limit)
        + '[sampling]\nmethod = "list"\n'
        + STEADY,
        COULOMB,
    )
    steady = computed(path, tmp_path)["steady"].sel(mode="A").values
    np.testing.assert_allclose(steady / limit, steady[0], rtol=2e-3)


def test_runs_are_those_of_the_scene(study_file, tmp_path):
    wanted = "[outputs]\npeak = true\ntimes = [0.0, 33.5, 200.0]\nrecording = true\n"
    path = study_file(VARY.format("forcing.A.amplitude", "[0.1, 0.2]") + wanted)
    data = computed(path, tmp_path)
    for k in range(2):
        found = runner.load(tmp_path / "study" / f"sample-{k:06d}.mcap")
        size, time = found["/modes"].column("A_abs"), found["/modes"].time
        assert data["peak"].sel(mode="A")[k] == pytest.approx(size.max(), rel=2e-3)
        at = data["at"].sel(mode="A")[k].values
        assert at == pytest.approx(np.interp([0.0, 33.5, 200.0], time, size), rel=5e-3, abs=1e-9)
    assert (data["run_error"].sel(mode="A").values > 0.0).all()


def test_a_run_that_reaches_the_edge_of_its_table_has_a_larger_one(study_file, tmp_path):
    vary = VARY.format("forcing.A.amplitude", "[0.05, 0.1223, 0.1225, 0.1227, 0.25]")
    data = computed(study_file(vary + "[outputs]\npeak = true\n"), tmp_path)
    assert data["reason"].values.tolist() == [""] * 5
    assert (np.diff(data["peak"].sel(mode="A")) > 0.0).all()


@pytest.mark.slow
def test_peaks_are_those_of_curves(study_file, tmp_path):
    wanted = '[outputs]\nresonance = ["A"]\ndofs = [0]\n'
    curve = 'curve = { mode = "A", from = 0.93, to = 1.03, points = 301 }\n'
    path = study_file(VARY.format("friction.limit", "[1.0, 4.0]") + wanted + curve, COULOMB)
    data = computed(path, tmp_path)
    highest = data["curve"].sel(mode="A").max("frequency")
    np.testing.assert_allclose(data["resonance"].sel(mode="A"), highest, rtol=3e-3)
    highest = data["curve_displacement"].sel(mode="A", dof=0).max("frequency")
    found = data["resonance_displacement"].sel(mode="A", dof=0)
    np.testing.assert_allclose(found, highest, rtol=3e-3)


def test_sensitivity_is_to_the_force_and_not_to_its_phase(study_file, tmp_path, capsys):
    pytest.importorskip("SALib")
    vary = '[[vary]]\nkey = "{}"\ndistribution = "uniform"\nlow = {}\nhigh = {}\n'
    path = study_file(
        vary.format("forcing.A.amplitude", 0.1, 0.2)
        + vary.format("forcing.A.phase", 0.0, 1.0)
        + '[sampling]\nmethod = "saltelli"\nsamples = 32\n'
        + STEADY
    )
    assert main(["study", str(path), "-o", str(tmp_path), "--workers", "2"]) == 0
    of_force, of_phase = (
        line for line in capsys.readouterr().out.splitlines() if line.startswith("steady_A")
    )
    assert float(of_force.split("first")[1].split()[0]) == pytest.approx(1.0, abs=0.1)
    assert float(of_phase.split("total")[1].split()[0]) == pytest.approx(0.0, abs=1e-3)
