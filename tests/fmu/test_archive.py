"""The .fmu file: valid to independent readers, rebuilt from its sources, refused when damaged."""

import io
import re
import shutil
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from damage.hostile import claiming, rewritten, zeros
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu
from fmu_fixtures import FORCE_PATTERNS, START, component, instance
from lxml import etree

from slipmode import fmu, rom, runner
from slipmode.__main__ import main
from slipmode.rom import SlipmodeError

NAME = "振動 & <blade>, μN = 2 N\u00a0\U0001f527"  # of any script


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """{2: path, 3: path}: one mode, called B, no contacts, modal force."""
    model = rom.model_of_rates(lambda r: (0.5 + 0 * r, 100.0 + 0 * r), amplitude=[0.1])
    folder = tmp_path_factory.mktemp("small")
    return {
        fmi: fmu.export(model, folder / f"{fmi}.fmu", fmi=fmi, mode_names=("B",), name=NAME)
        for fmi in (2, 3)
    }


@pytest.mark.oracle
def test_fmpy_and_the_schemas_find_no_fault(fmus, small, fmi):
    """Every variable has a description and every real a unit; start values are those given."""
    for made in (fmus, small):
        assert validate_fmu(str(made[fmi])) == []
        description = fmpy.read_model_description(made[fmi], validate=True)
        assert description.fmiVersion == f"{fmi}.0"
        assert description.coSimulation and description.modelExchange
        for variable in description.modelVariables:
            assert variable.description
            if variable.type in ("Real", "Float64"):
                assert variable.declaredType.unit
    assert description.modelName == NAME
    variables = {v.name: v for v in fmpy.read_model_description(fmus[fmi]).modelVariables}
    assert {name: float(variables[name].start) for name in START} == START
    with zipfile.ZipFile(fmus[fmi]) as archive:
        page = archive.read("documentation/index.html")
        parsed = etree.parse(io.BytesIO(page), etree.HTMLParser(recover=False))
        assert set(variables) <= {cell.text for cell in parsed.iter("td")}
        if fmi == 3:
            schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
            terminals = archive.read("terminalsAndIcons/terminalsAndIcons.xml")
            etree.XMLSchema(etree.parse(schema)).assertValid(etree.fromstring(terminals))


def test_forcing_frequencies_declare_the_range_that_is_allowed(unzipped, fmi):
    variables = fmpy.read_model_description(unzipped[fmi]).modelVariables
    for variable in (v for v in variables if v.name in ("frequency_A", "frequency_B")):
        lowest, highest = float(variable.min), float(variable.max)
        for value in (lowest, highest, 0.999 * lowest, 1.001 * highest):
            with instance(unzipped[fmi], fmi) as made:
                inputs = {"frequency_A": 1.3, "frequency_B": 1.4} | {variable.name: value}
                if lowest <= value <= highest:
                    made.start(**inputs)
                else:
                    assert f"{variable.name}: must be" in made.refused(made.start, **inputs)[1]


def test_equal_models_give_equal_files_and_other_start_values_another_token(
    fmus, fmi, two_mode_model, tmp_path
):
    options = {"fmi": fmi, "contact": True, "elastic": (0, 1)}
    again, other = (
        fmu.export(two_mode_model, tmp_path / f"{k}.fmu", FORCE_PATTERNS, start=start, **options)
        for k, start in enumerate((START, START | {"force_A": 0.2}))
    )
    assert again.read_bytes() == fmus[fmi].read_bytes()
    tokens = {fmpy.read_model_description(path).guid for path in (again, other)}
    assert len(tokens) == 2
    assert fmpy.read_model_description(again).author is None  # the model is not ours to license


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.slow)], indirect=True)
def test_sources_rebuild_the_library(unzipped, fmi, tmp_path, two_mode_model):
    """With the headers of the standard alone, by FMPy."""
    folder = tmp_path / "rebuilt"
    shutil.copytree(unzipped[fmi], folder)
    (library,) = folder.glob("binaries/*/slipmode.*")
    library.unlink()
    build_platform_binary(folder, configuration="Debug")
    assert library.is_file()
    stepped = component(two_mode_model)
    stepped.do_step(0.0, 30.0)
    with instance(folder, fmi) as made:
        made.start().step(0.0, 30.0)
        for name in ("A_re", "B_im"):
            assert made.get(name)[0] == pytest.approx(stepped.outputs()[name], rel=1e-9)


REFUSED = [
    ({"fmi": 1}, "fmi: must be 2 or 3"),
    ({"contact": True, "elastic": (7,)}, "elastic: DOFs must be 0 to 3"),
    ({"start": {"A_abs": 1.0}}, "start: A_abs must be one of force_A"),
    ({"start": {"A_re": np.nan}}, "start: A_re must be finite"),
    ({"start": {"A_re": 9.0}}, "amplitude: .* outside the friction table"),
    ({"start": {"frequency_A": -1.0}}, "frequency_A: must be 0.62 to 10 rad/s"),
    ({"step_size": 0.0}, "step_size: must be a finite number > 0"),
    ({"platforms": ("vax",)}, "platforms: vax must be one of x86_64-linux"),
    ({"name": "two\nlines"}, "name: must be one line of letters"),
    ({"name": "\ufffe"}, "name: must be one line of letters"),
]


@pytest.mark.parametrize(("options", "message"), REFUSED)
def test_arguments_of_export_that_are_refused_leave_no_file(
    options, message, two_mode_model, tmp_path
):
    with pytest.raises(SlipmodeError, match=message) as refusal:
        fmu.export(two_mode_model, tmp_path / "wrong.fmu", FORCE_PATTERNS, **options)
    assert str(refusal.value).isprintable() and not list(tmp_path.iterdir())


# Damage: random damage to resources is in native/


def refusal_of(path, tmp_path):
    """The line by which a run through an FMU is refused; nothing is recorded."""
    with pytest.raises(SlipmodeError) as refusal:
        runner.run("one-mode", tmp_path / "run", fmu=path)
    assert path.name in str(refusal.value) and "\n" not in str(refusal.value)
    assert not list(tmp_path.rglob("*.mcap"))
    return str(refusal.value)


@pytest.fixture(scope="module")
def scene_fmu(tmp_path_factory):
    return runner.export_fmu("one-mode", tmp_path_factory.mktemp("scene") / "whole.fmu")


DAMAGE = {  # entries that begin so, and their new content; None: they are left out
    "is not among its outputs": (
        "modelDescription",
        lambda xml: xml.replace(b'"dissipated_energy"', b'"heat"'),
    ),
    "table.npy: damaged, its checksum": ("resources/table.npy", lambda b: b[:-8] + b"damaged!"),
    "must be an FMU for Co-Simulation": (
        "modelDescription",
        lambda xml: re.sub(rb"<CoSimulation.*?(?=<UnitDef)", b"", xml, flags=re.DOTALL),
    ),
    "not a readable FMU": ("modelDescription", None),
    "has no library for ": ("binaries/", None),
}


@pytest.mark.parametrize("reason", DAMAGE)
def test_a_damaged_fmu_is_refused_with_a_reason(scene_fmu, tmp_path, reason):
    path = tmp_path / "damaged.fmu"
    part, change = DAMAGE[reason]
    with zipfile.ZipFile(scene_fmu) as source, zipfile.ZipFile(path, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if not name.startswith(part):
                target.writestr(name, content)
            elif change:
                target.writestr(name, change(content))
    assert reason in refusal_of(path, tmp_path)


@pytest.mark.parametrize("shape", [(-3,), (10**9,), (2**31, 2**31), (5, 5)])
def test_arrays_that_claim_more_than_their_file_has_are_refused(scene_fmu, tmp_path, shape):
    target = rewritten(scene_fmu, tmp_path / "m.fmu", resources__node_a=claiming(shape))
    assert "its model is damaged: " in refusal_of(target, tmp_path)


def test_an_archive_that_unpacks_to_much_is_refused(scene_fmu, tmp_path):
    target = rewritten(scene_fmu, tmp_path / "bomb.fmu", documentation__picture=zeros(300))
    assert "unpacks to 30" in refusal_of(target, tmp_path)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("none.fmu", "none.fmu: no such FMU"),
        ("text.fmu", "text.fmu: is not an FMU, because"),
        ("other.fmu", "other.fmu: has a different model than the scene; export the model of the "),
    ],
)
def test_files_of_other_kinds_are_refused(tmp_path, capsys, monkeypatch, fmus, name, message):
    monkeypatch.chdir(tmp_path)
    Path("text.fmu").write_text("no zip")
    shutil.copy(fmus[3], "other.fmu")
    assert main(["run", "one-mode", "--fmu", name]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"slipmode: {message}")
