"""What a study file may say, what it draws, sensitivities, and the refusal of the rest."""

import numpy as np
import pytest

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner.study.design import make_design
from slipmode.runner.study.study_file import load_study
from slipmode.runner.study.summary.statistics import sensitivity

VARY = '[[vary]]\nkey = "forcing.A.amplitude"\n'
ONE = VARY + "values = [0.1]\n"
STEADY = "[outputs]\nsteady = true\n"
CHOOSE = '[choose]\nkey = "run.step"\noutput = "steady"\n'
UNIFORM = VARY + 'distribution = "uniform"\nlow = 0.1\nhigh = 0.2\n'


def of_key(key):
    return f'[[vary]]\nkey = "{key}"\nvalues = [1.0]\n{STEADY}'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (STEADY, "vary: nothing varies"),
        (VARY + STEADY, "vary[0].values: give one of values, from"),
        (VARY + "values = [1.0]\nlow = 0\n" + STEADY, "vary[0].low: must be left out with values"),
        (UNIFORM + STEADY, "sampling.samples: is missing"),
        (UNIFORM + '[sampling]\nmethod = "grid"\n' + STEADY, 'sampling.method: "grid" needs'),
        (ONE + ONE + STEADY, "varied twice"),
        (ONE, "outputs: is empty; give one of steady"),
        (ONE + "[outputs]\ntimes = [1e9]\n", "outputs.times: must be at most"),
        (VARY + "values = [-0.1]\n" + STEADY, "forcing.A.amplitude: must be >= 0"),
        (ONE + STEADY + "[set]\nrun.step = 1\n", 'quoted, "run.step"'),
        (UNIFORM + "[sampling]\nsamples = 2\n" + STEADY + CHOOSE, "choose.key: must be"),
        (of_key("forcing.A.amplitud"), "did you mean amplitude?"),
        (of_key("contacts.0.preload"), "of [[contacts]] there are none"),
        (of_key("run.step.3"), "a value has no keys"),
    ],
)
def test_a_refusal_is_one_line_that_names_the_key(study_file, capsys, tmp_path, text, said):
    assert main(["study", str(study_file(text)), "-o", str(tmp_path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("slipmode: ") and said in line
    assert not (tmp_path / "study.zarr").exists()


@pytest.mark.slow
def test_missing_files_and_schedulers_are_one_line(study_file, tmp_path, capsys):
    pytest.importorskip("distributed")
    assert main(["study", "nothing.toml"]) == 1
    assert capsys.readouterr().err == "slipmode: nothing.toml: no such study file\n"
    path = str(study_file(ONE + STEADY))
    assert main(["study", path, "-o", str(tmp_path), "--scheduler", "tcp://127.0.0.1:9"]) == 1
    assert "slipmode: --scheduler: tcp://127.0.0.1:9 does not answer" in capsys.readouterr().err


def test_values_are_crossed_with_what_is_drawn(study_file):
    text = (
        '[[vary]]\nkey = "friction.limit"\ndistribution = "lognormal"\nmedian = 2.0\nsigma = 0.3\n'
        + VARY
        + 'from = 0.01\nto = 1.0\npoints = 3\nspacing = "log"\n'
        + '[[vary]]\nkey = "modes.A"\nvalues = [0, 1]\n[sampling]\nsamples = 4\nseed = 3\n'
    )
    design = make_design(load_study(study_file(text + STEADY)))
    limit, force, mode = design.columns
    np.testing.assert_allclose(force[:3], [0.01, 0.1, 1.0])  # loads vary fastest
    assert mode.tolist() == [0] * 12 + [1] * 12
    assert np.unique(limit).size == 4 and np.all(limit[:12].reshape(4, 3) == limit[:12:3, None])
    again = make_design(load_study(study_file(text + STEADY)))
    np.testing.assert_array_equal(again.columns[0], limit)


@pytest.mark.oracle
@pytest.mark.parametrize("method", ["sobol", "latin-hypercube", "saltelli"])
def test_samples_have_the_moments_of_their_distribution(study_file, method):
    pytest.importorskip("SALib")
    parameters = {
        "uniform": "low = 1.0\nhigh = 3.0",
        "loguniform": "low = 1.0\nhigh = 3.0",
        "normal": "mean = 2.0\ndeviation = 0.5",
        "lognormal": "median = 2.0\nsigma = 0.5",
    }
    keys = ("friction.limit", "friction.alpha", "run.step", "forcing.A.frequency")
    vary = "".join(
        f'[[vary]]\nkey = "{key}"\ndistribution = "{name}"\n{given}\n'
        for key, (name, given) in zip(keys, parameters.items(), strict=True)
    )
    sampling = f'[sampling]\nmethod = "{method}"\nsamples = 512\n'
    columns = make_design(load_study(study_file(vary + sampling + STEADY))).columns
    assert columns[0].size == 512 * (6 if method == "saltelli" else 1)
    expected = [2.0, 2.0 / np.log(3.0), 2.0, 2.0 * np.exp(0.125)]
    np.testing.assert_allclose([column.mean() for column in columns], expected, rtol=0.01)
    assert np.std(columns[2]) == pytest.approx(0.5, rel=0.03)


def test_lists_are_walked_together(study_file):
    vary = VARY + 'values = [0.1, 0.2]\n[[vary]]\nkey = "title"\nvalues = ["a", "b"]\n'
    design = make_design(load_study(study_file(vary + '[sampling]\nmethod = "list"\n' + STEADY)))
    assert design.rows() == [(0.1, "a"), (0.2, "b")]


def test_a_study_is_another_one_once_a_file_of_its_structure_changes(study_file, tmp_path):
    K = np.array([[2.0, -1.0], [-1.0, 2.0]])
    scene = (
        '[structure]\nmatrices = "m.npz"\n[friction]\nlaw = "tanh"\nlimit = 1.0\nalpha = 0.02\n'
        "[modes]\nA = 0\n[forcing.A]\ndof = 0\namplitude = 0.1\nfrequency = 1.0\n"
        "[run]\nduration = 10.0\nstep = 1.0\n"
    )
    np.savez(tmp_path / "m.npz", mass=np.eye(2), stiffness=K, damping=0.01 * K, contact=[1])
    path = study_file(ONE + STEADY, scene)
    before = load_study(path).digest
    assert load_study(path).digest == before
    np.savez(tmp_path / "m.npz", mass=np.eye(2), stiffness=K, damping=0.02 * K, contact=[1])
    assert load_study(path).digest != before


def test_frequencies_are_in_the_units_of_the_scene(study_file):
    study = load_study(
        study_file(
            '[set]\n"units.frequency" = "Hz"\n"forcing.A.frequency" = 0.156\n'
            '[[vary]]\nkey = "forcing.A.frequency"\nvalues = [0.155, 0.156]\n'
            '[outputs]\ncurve = { mode = "A", from = 0.15, to = 0.16, points = 3 }\n'
        )
    )
    assert study.outputs.curve.frequency / (2 * np.pi) == pytest.approx([0.15, 0.155, 0.16])


@pytest.mark.oracle
def test_sensitivities_of_the_ishigami_function():
    sampler = pytest.importorskip("SALib.sample.sobol")
    problem = {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[0.0, 1.0]] * 3}
    unit = sampler.sample(problem, 1024, calc_second_order=False, seed=0)
    a, b, c = (2.0 * np.pi * unit - np.pi).T
    ishigami = np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)
    found = sensitivity("steady_A", ishigami, ("a", "b", "c"), 0)
    np.testing.assert_allclose(found.first, [0.3139, 0.4424, 0.0], atol=0.03)
    np.testing.assert_allclose(found.total, [0.5576, 0.4424, 0.2437], atol=0.03)
    ishigami[5] = np.nan
    with pytest.raises(SlipmodeError, match="no sensitivities, because 1 samples failed"):
        sensitivity("steady_A", ishigami, ("a", "b", "c"), 0)
