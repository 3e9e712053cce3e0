"""What a study file may say, and the line that refuses the rest."""

import tomllib

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.sparse import csr_array

from slipmode import rom
from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.rom.structure.files import source_files
from slipmode.runner import shipped_scenes
from slipmode.runner.scene.scene import read_scene
from slipmode.runner.scene.toml_table import toml_text
from slipmode.runner.study.design import make_design
from slipmode.runner.study.scene_keys import check_key, declared, get, with_value
from slipmode.runner.study.shared_limits import on_shared_limits
from slipmode.runner.study.study_file import load_study
from slipmode.runner.study.workers import cluster

VARY = '[[vary]]\nkey = "forcing.A.amplitude"\n'
STEADY = "[outputs]\nsteady = true\n"
UNIFORM = VARY + 'distribution = "uniform"\nlow = 0.1\nhigh = 0.2\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (STEADY, "vary: nothing varies"),
        (VARY + "values = []\n" + STEADY, "vary[0].values: must be a list of at least one value"),
        (VARY + "from = 1\nto = 2\npoints = 0\n" + STEADY, "vary[0].points: must be an integer"),
        (VARY + STEADY, "vary[0].values: give one of values, from"),
        (VARY + "values = [1.0]\nfrom = 0\n" + STEADY, "vary[0].values: give one of"),
        (VARY + "values = [1.0]\nlow = 0\n" + STEADY, "vary[0].low: must be left out with values"),
        (UNIFORM.replace("0.2", "0.1") + STEADY, "vary[0].high: must be above low = 0.1"),
        (UNIFORM + STEADY, "sampling.samples: is missing"),
        (UNIFORM + '[sampling]\nmethod = "grid"\n' + STEADY, 'sampling.method: "grid" needs'),
        (VARY + "values = [1.0]\n[sampling]\nsamples = 3\n" + STEADY, "sampling.samples: needs"),
        (VARY + "values = [0.1]\n" * 1 + VARY + "values = [0.2]\n" + STEADY, "varied twice"),
        (VARY + "values = [0.1]\n", "outputs: is empty; give one of steady"),
        (VARY + "values = [0.1]\n[outputs]\nresonance = ['C']\n", "outputs.resonance: must be"),
        (VARY + "values = [0.1]\n[outputs]\ntimes = [1e9]\n", "outputs.times: must be at most"),
        (VARY + "values = [0.1]\n[outputs]\nsteadi = true\n", "did you mean steady?"),
        (VARY + "values = [-0.1]\n" + STEADY, "forcing.A.amplitude: must be >= 0"),
        (VARY + "values = [0.1]\n" + STEADY + "[set]\nrun.step = 1\n", 'quoted, "run.step"'),
        (
            UNIFORM + "[sampling]\nsamples = 2\n" + STEADY + "[choose]\n",
            "choose.key: must be a key",
        ),
        ("[[vary\n", "TOML syntax"),
    ],
)
def test_a_refusal_is_one_line_that_names_the_key(study_file, capsys, tmp_path, text, said):
    assert main(["study", str(study_file(text)), "-o", str(tmp_path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("slipmode: ") and said in line
    assert not (tmp_path / "study.zarr").exists()


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("forcing.A.amplitud", "did you mean amplitude?"),
        ("forcing.amplitude", "'amplitude' must be one of A, B"),
        ("forcings.A.amplitude", "did you mean forcing?"),
        ("contacts.0.preload", "of [[contacts]] there are none"),
        ("contact.1.window", "of [[contact]] there are 1, numbered from 0"),
        ("contact.0.window.2", "there are 2, numbered from 0"),
        ("run.step.3", "a value has no keys"),
        ("title.x", "a value has no keys"),
    ],
)
def test_a_key_that_is_not_there_is_refused_with_what_is(study_file, key, said):
    with pytest.raises(SlipmodeError, match=r"vary\[0\].key: no such key") as refusal:
        load_study(study_file(f'[[vary]]\nkey = "{key}"\nvalues = [1.0]\n{STEADY}'))
    assert said in str(refusal.value)


def test_missing_files_and_schedulers_are_one_line(study_file, tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(cluster, "_ANSWERS", 0.5)
    assert main(["study", "nothing.toml"]) == 1
    assert capsys.readouterr().err == "slipmode: nothing.toml: no such study file\n"
    path = str(study_file(VARY + "values = [0.1]\n" + STEADY))
    nowhere = "tcp://127.0.0.1:9"
    assert main(["study", path, "-o", str(tmp_path), "--scheduler", nowhere]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1].startswith(f"slipmode: --scheduler: {nowhere} does not answer")
    assert main(["study", path, "-o", str(tmp_path), "--scheduler", "x:y"]) == 1
    assert "slipmode: --scheduler: x:y does not answer" in capsys.readouterr().err


def test_values_are_crossed_with_what_is_drawn(study_file):
    text = (
        '[[vary]]\nkey = "friction.limit"\ndistribution = "lognormal"\nmedian = 2.0\nsigma = 0.3\n'
        + VARY
        + 'from = 0.01\nto = 1.0\npoints = 3\nspacing = "log"\n'
        + '[[vary]]\nkey = "modes.A"\nvalues = [0, 1]\n[sampling]\nsamples = 4\nseed = 3\n'
    )
    design = make_design(load_study(study_file(text + STEADY)))
    limit, force, mode = design.columns
    assert design.samples == 24
    np.testing.assert_allclose(force[:3], [0.01, 0.1, 1.0])  # loads run fastest
    assert mode.tolist() == [0] * 12 + [1] * 12
    assert np.unique(limit).size == 4 and np.all(limit[:12].reshape(4, 3) == limit[:12:3, None])
    again = make_design(load_study(study_file(text + STEADY)))
    np.testing.assert_array_equal(again.columns[0], limit)


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube", "saltelli"])
def test_draws_have_their_distribution(study_file, method):
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
    means = [column.mean() for column in columns]
    expected = [2.0, 2.0 / np.log(3.0), 2.0, 2.0 * np.exp(0.125)]
    np.testing.assert_allclose(means, expected, rtol=0.01)
    assert np.std(columns[2]) == pytest.approx(0.5, rel=0.03)


def test_lists_are_walked_together(study_file):
    vary = VARY + 'values = [0.1, 0.2]\n[[vary]]\nkey = "title"\nvalues = ["a", "b"]\n'
    design = make_design(load_study(study_file(vary + '[sampling]\nmethod = "list"\n' + STEADY)))
    assert design.rows() == [(0.1, "a"), (0.2, "b")]


def test_keys_are_found_put_and_known_with_their_units():
    content = original = tomllib.loads(shipped_scenes()["blade"].read_text())
    check_key("key", "contacts.0.preload.1", content)
    assert get(content, "contacts.0.preload.1") == 24.0
    content = with_value(content, "contacts.0.preload.1", 30.0)
    content = with_value(content, "limits.scale", 2.0)
    assert content["contacts"][0]["preload"] == [16.0, 30.0]
    assert (get(content, "limits.scale"), get(content, "initial.A")) == (2.0, None)
    assert original == tomllib.loads(shipped_scenes()["blade"].read_text())
    keys = ("contacts.0.preload.1", "forcing.B.amplitude", "run.step", "title")
    assert [declared(key).unit for key in keys] == ["N", "N", "s", "-"]


def test_limits_in_one_ratio_are_a_scale_of_the_same_scene():
    content = tomllib.loads(shipped_scenes()["blade"].read_text())
    other = tomllib.loads(shipped_scenes()["blade"].read_text())
    other["contacts"][0]["preload"] = [48.0, 72.0]
    shared = on_shared_limits(other, content)
    assert shared["limits"]["scale"] == 3.0
    assert shared["contacts"] == content["contacts"]
    assert other["contacts"][0]["preload"] == [48.0, 72.0]
    other["limits"] = {"scale": [[0.0, 1.0], [1.0, 2.0]]}
    assert on_shared_limits(other, content)["limits"]["scale"] == [[0.0, 3.0], [1.0, 6.0]]
    for key, value in (("gap", [0.0, 1e-6]), ("preload", [0.0, 0.0]), ("preload", "much")):
        other["contacts"][0][key] = value
        assert on_shared_limits(other, content) is other


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_scene_written_as_text_is_the_same(name):
    path = shipped_scenes()[name]
    content = tomllib.loads(path.read_text())
    assert tomllib.loads(toml_text(content)) == content
    read_scene(tomllib.loads(toml_text(content)), path.parent)


def test_frequencies_are_in_the_units_of_the_scene(study_file):
    study = load_study(
        study_file(
            '[set]\n"units.frequency" = "Hz"\n"forcing.A.frequency" = 0.156\n'
            '[[vary]]\nkey = "forcing.A.frequency"\nvalues = [0.155, 0.156]\n'
            '[outputs]\ncurve = { mode = "A", from = 0.15, to = 0.16, points = 3 }\n'
        )
    )
    assert study.outputs.curve.frequency == pytest.approx(
        2 * np.pi * np.array([0.15, 0.155, 0.16])
    )


def matrix_folder(folder):
    """A two-mass structure as a folder of Matrix Market files."""
    folder.mkdir()
    structure = rom.two_mass()
    for name in ("mass", "stiffness", "damping"):
        mmwrite(folder / f"{name}.mtx", csr_array(getattr(structure, name)))
    (folder / "contact.txt").write_text("2\n3\n", encoding="utf-8")
    return folder


MATRICES = (
    shipped_scenes()["one-mode"]
    .read_text(encoding="utf-8")
    .replace('model = "two-mass"', 'matrices = "beam"')
    .replace("damping = 0.01", "")
)
OTHER_BEAM = '[[vary]]\nkey = "structure.matrices"\nvalues = ["beam", "other"]\n'
ONE_FORCE = '[[vary]]\nkey = "forcing.A.amplitude"\nvalues = [0.1]\n'


@pytest.mark.parametrize("file", ["mass.mtx", "stiffness.mtx", "damping.mtx", "contact.txt"])
@pytest.mark.parametrize(("vary", "folder"), [(ONE_FORCE, "beam"), (OTHER_BEAM, "other")])
def test_a_study_is_another_one_once_a_file_of_its_structure_changes(
    study_file, tmp_path, file, vary, folder
):
    for name in ("beam", "other"):
        matrix_folder(tmp_path / name)
    path = study_file(f"{vary}[outputs]\nsteady = true\n", MATRICES)
    before = load_study(path).digest
    assert load_study(path).digest == before
    changed = tmp_path / folder / file
    changed.write_text(changed.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert load_study(path).digest != before


def test_files_beside_a_matrix_file_are_files_of_the_structure(tmp_path):
    for name in ("job.sti", "job.mas", "job.dof", "job.inp", "a_STIF2.mtx", "a_MASS2.mtx"):
        (tmp_path / name).touch()
    found = [path.name for path in source_files(tmp_path / "job.sti")]
    assert found == ["job.dof", "job.mas", "job.sti"]
    found = [path.name for path in source_files(tmp_path / "a_STIF2.mtx")]
    assert found == ["a_MASS2.mtx", "a_STIF2.mtx"]
