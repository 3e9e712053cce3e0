"""What an FMU contains: descriptions, resources, sources, documentation."""

import importlib.util
import io
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu
from fmu_fixtures import FORCE_PATTERNS, START, VERSIONS, component, instance
from lxml import etree

from slipmode import fmu, rom
from slipmode.fmu.archive.binaries import fmi_headers, source_files
from slipmode.fmu.variables.variable import UNITS
from slipmode.rom import SlipmodeError

ONE_MODE = ({1: 1.0},)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """{2: path, 3: path}: one mode, called B, exact Coulomb, modal force, no contact motion."""
    reduced = rom.reduce(rom.two_mass(), modes=(1,))
    model = rom.tabulate(reduced, rom.Coulomb(2.0), amplitude=(2.0,), tolerance=1e-2)
    folder = tmp_path_factory.mktemp("small")
    return {
        fmi: fmu.export(model, folder / f"small{fmi}.fmu", fmi=fmi, mode_names=("B",))
        for fmi in VERSIONS
    }


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def test_fmpy_finds_no_fault(fmus, small, fmi):
    for made in (fmus, small):
        assert validate_fmu(str(made[fmi])) == []
        description = fmpy.read_model_description(made[fmi], validate=True)
        assert description.fmiVersion == f"{fmi}.0"
        assert description.coSimulation and description.modelExchange
        # A structured name would have dots and brackets
        assert description.variableNamingConvention == "flat"


def test_the_layered_standard_manifest_names_its_file(unzipped):
    folder = unzipped[3] / "extra" / "org.fmi-standard.fmi-ls-ref"
    manifest = etree.parse(folder / "fmi-ls-manifest.xml").getroot()
    attributes = {etree.QName(name).localname for name in manifest.attrib}
    assert attributes == {"fmi-ls-name", "fmi-ls-version", "fmi-ls-description"}
    (experiment,) = manifest
    assert experiment.tag == "Experiment" and experiment.get("name")
    assert [child.tag for child in experiment] == ["Stimuli", "References"]
    for child in experiment:
        assert (folder / child.get("source")).is_file()


def test_every_real_has_a_unit_and_a_declared_type(fmus, fmi):
    description = fmpy.read_model_description(fmus[fmi])
    for variable in description.modelVariables:
        assert variable.description
        if variable.type in ("Real", "Float64"):
            assert variable.declaredType.unit in UNITS
    defined = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    assert (defined["W"].kg, defined["W"].m, defined["W"].s) == (1, 2, -3)


def test_start_values_are_those_given(fmus, fmi, two_mode_model):
    variables = {v.name: v for v in fmpy.read_model_description(fmus[fmi]).modelVariables}
    for name, value in START.items():
        assert float(variables[name].start) == value
    assert float(variables["damping_A"].start) == two_mode_model.reduced.modal_damping[0]
    assert variables["theta_A"].start is None


def test_forcing_frequencies_declare_the_range_that_is_allowed(unzipped, fmi):
    variables = fmpy.read_model_description(unzipped[fmi]).modelVariables
    for variable in (v for v in variables if v.name in ("frequency_A", "frequency_B")):
        lowest, highest = float(variable.min), float(variable.max)
        for value, allowed in (
            *((lowest, True), (highest, True)),
            *((0.999 * lowest, False), (1.001 * highest, False)),
        ):
            with instance(unzipped[fmi], fmi) as made:
                other = {"frequency_A": 1.3, "frequency_B": 1.4} | {variable.name: value}
                made.set(**other)
                if allowed:
                    made.start()
                else:
                    with pytest.raises(fmpy.fmi1.FMICallException):
                        made.start()
                    assert f"{variable.name}: must be" in made.messages[-1][1]


def test_dependencies_tell_what_moves_what(unzipped, fmi):
    """A derivative depends on nothing that is not listed, and on what is listed."""
    description = fmpy.read_model_description(unzipped[fmi])
    states = [d.variable.derivative.name for d in description.derivatives]
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        made.start(A_re=0.7, A_im=-0.2, B_re=0.3, B_im=0.4, force_rate_A=0.01)
        base = np.array([made.get(f"der({s})")[0] for s in states])
        inputs = [v.name for v in description.modelVariables if v.causality == "input"]
        moved = {}
        for name in inputs:
            before = made.get(name)[0]
            made.set(**{name: before + 0.01})
            moved[name] = np.array([made.get(f"der({s})")[0] for s in states]) != base
            made.set(**{name: before})
    for k, derivative in enumerate(description.derivatives):
        listed = {v.name for v in derivative.dependencies}
        for name in inputs:
            assert name in listed or not moved[name][k], (states[k], name)
        assert any(moved[name][k] for name in listed & set(inputs))


def test_events_may_change_the_amplitudes(unzipped, fmi):
    """And no other state: a force that jumps leaves the carriers and the energy as they are."""
    root = etree.parse(unzipped[fmi] / "modelDescription.xml").getroot()
    changed = [
        typed.get("name") or typed.getparent().get("name")
        for typed in root.iter()
        if typed.get("reinit") == "true"
    ]
    assert changed == ["A_re", "A_im", "B_re", "B_im"]


def test_the_tables_are_numpys(unzipped, two_mode_model):
    resources = unzipped[3] / "resources"
    np.testing.assert_array_equal(np.load(resources / "table.npy"), two_mode_model.table.values)
    np.testing.assert_array_equal(np.load(resources / "node_a.npy"), two_mode_model.table.node_a)
    for path in resources.glob("*.npy"):
        assert np.load(path).dtype.str in ("<f8", "<i4")


def test_the_same_model_gives_the_same_file(fmus, fmi, two_mode_model, tmp_path):
    again = fmu.export(
        two_mode_model,
        tmp_path / "again.fmu",
        FORCE_PATTERNS,
        fmi=fmi,
        contact=True,
        elastic=(0, 1),
        start=START,
    )
    assert again.read_bytes() == fmus[fmi].read_bytes()


def test_another_start_is_another_token(fmus, two_mode_model, tmp_path):
    other = fmu.export(
        two_mode_model, tmp_path / "other.fmu", FORCE_PATTERNS, start={"force_A": 0.2}
    )
    tokens = {fmpy.read_model_description(path).guid for path in (other, *fmus.values())}
    assert len(tokens) == 2  # both versions of the same resources share theirs


def test_the_archive_has_all_parts(fmus, fmi):
    names = set(zipfile.ZipFile(fmus[fmi]).namelist())
    icon = "model.png" if fmi == 2 else "terminalsAndIcons/icon.png"
    assert {
        *("modelDescription.xml", "documentation/index.html", icon),
        *(
            "documentation/licenses/slipmode.txt",
            "sources/slow/component/component.c",
            "sources/slipmode.h",
        ),
        "extra/org.fmi-standard.fmi-ls-ref/reference.csv",
    } <= names
    assert ("sources/buildDescription.xml" in names) == (fmi == 3)
    assert not [name for name in names if name.startswith("sources/fmi") and "Functions" in name]


def test_the_documentation_lists_every_variable(fmus, small, fmi):
    for made in (fmus, small):
        page = zipfile.ZipFile(made[fmi]).read("documentation/index.html")
        parsed = etree.parse(io.BytesIO(page), etree.HTMLParser(recover=False))
        cells = {cell.text for cell in parsed.iter("td")}
        names = {v.name for v in fmpy.read_model_description(made[fmi]).modelVariables}
        assert names <= cells


def test_the_reference_result_is_the_components(unzipped, two_mode_model):
    path = unzipped[3] / "extra" / "org.fmi-standard.fmi-ls-ref" / "reference.csv"
    result = np.genfromtxt(path, delimiter=",", names=True)
    stepped = component(two_mode_model)
    for k in range(100):
        stepped.do_step(float(k), 1.0)
        last = stepped.outputs()  # contacts are marched as they are read
    for name in result.dtype.names:
        assert result[name][-1] == last[name]


def listed_sources(folder, fmi):
    if fmi == 3:
        description = etree.parse(folder / "sources" / "buildDescription.xml")
        return [{file.get("name") for file in description.iter("SourceFile")}]
    description = etree.parse(folder / "modelDescription.xml")
    return [
        {file.get("name") for file in files.iter("File")}
        for files in description.iter("SourceFiles")
    ]


def test_sources_need_the_headers_of_their_version_alone(unzipped, fmi, tmp_path):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler (cc)")
    folder = unzipped[fmi] / "sources"
    present = {path.relative_to(folder).as_posix() for path in folder.rglob("*.c")}
    lists = listed_sources(unzipped[fmi], fmi)
    assert lists and all(listed == present for listed in lists)
    for header in fmi_headers().glob(f"fmi{fmi}*.h"):
        shutil.copy(header, tmp_path)
    faces = [name for name in present if name.startswith("faces/")]
    assert faces
    command = [compiler, "-std=c99", "-fsyntax-only", f"-I{folder}", f"-I{tmp_path}", *faces]
    subprocess.run(command, cwd=folder, check=True)


@pytest.mark.parametrize(
    ("fmi", "configuration"),
    [
        (2, "Debug"),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in ((3, "Debug"), (2, "Release"), (3, "Release"))
        ),
    ],
    indirect=["fmi"],
)
def test_sources_rebuild_the_library(unzipped, fmi, configuration, tmp_path, two_mode_model):
    folder = tmp_path / "rebuilt"
    shutil.copytree(unzipped[fmi], folder)
    (library,) = folder.glob("binaries/*/slipmode.*")
    library.unlink()
    build_platform_binary(folder, configuration=configuration)
    assert library.is_file()
    stepped = component(two_mode_model)
    stepped.do_step(0.0, 30.0)
    with instance(folder, fmi) as made:
        made.start().step(0.0, 30.0)
        expected = stepped.outputs()
        np.testing.assert_allclose(
            made.get("A_re", "B_im"), (expected["A_re"], expected["B_im"]), rtol=1e-9
        )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fmi": 1}, "fmi: must be 2 or 3"),
        ({"elastic": (0,)}, "elastic: needs contact=True"),
        ({"contact": True, "elastic": (7,)}, "elastic: DOFs must be 0 to 3"),
        ({"start": {"A_abs": 1.0}}, "start: A_abs must be one of force_A"),
        ({"start": {"A_re": np.nan}}, "start: A_re must be finite"),
        ({"start": {"A_re": 9.0}}, "amplitude: .* outside the friction table"),
        ({"start": {"frequency_A": -1.0}}, "frequency_A: must be 0.62 to 10 rad/s"),
        ({"step_size": 0.0}, "step_size: must be a finite number > 0"),
        ({"tolerance": 1.0}, "tolerance: must be 1e-13 to 1e-2"),
        ({"mode_names": ("A", "A")}, "mode_names: must have 2 different names"),
        ({"platforms": ("vax",)}, "platforms: vax must be one of x86_64-linux"),
    ],
)
def test_wrong_arguments_are_named(options, message, two_mode_model, tmp_path):
    with pytest.raises(SlipmodeError, match=message):
        fmu.export(two_mode_model, tmp_path / "wrong.fmu", FORCE_PATTERNS, **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a\u0001b", "two\nlines", "\ud800", "\ufffe"])
def test_a_name_that_xml_cannot_hold_is_refused(one_mode_model, tmp_path, name):
    with pytest.raises(SlipmodeError, match="name: must be one line of letters") as refusal:
        fmu.export(one_mode_model, tmp_path / "x.fmu", name=name)
    assert str(refusal.value).isprintable()
    assert not any(tmp_path.iterdir())


def test_a_name_of_any_script_is_kept(one_mode_model, tmp_path, fmi):
    name = "振動 & <blade>, μN = 2 N\u00a0\U0001f527"
    path = fmu.export(one_mode_model, tmp_path / "x.fmu", name=name, fmi=fmi)
    assert validate_fmu(str(path)) == []
    assert fmpy.read_model_description(path).modelName == name


def test_the_library_shows_the_functions_of_fmi_alone():
    found = importlib.util.find_spec("slipmode.fmu._native")
    nm = shutil.which("nm")
    if nm is None or not found.origin.endswith(".so"):
        pytest.skip("no nm for shared objects")
    listed = subprocess.run(
        [nm, "-D", "--defined-only", found.origin], capture_output=True, text=True, check=True
    )
    names = {line.split()[-1] for line in listed.stdout.splitlines()}
    assert {"fmi2DoStep", "fmi3DoStep"} <= names
    assert not {name for name in names if not name.startswith("fmi")}


def test_the_library_loads_on_old_systems():
    """Those with glibc 2.17, of 2013, and newer: what its symbols ask for is no newer."""
    found = importlib.util.find_spec("slipmode.fmu._native")
    needed = re.findall(rb"\0GLIBC_2\.(\d+)[.\0]", Path(found.origin).read_bytes())
    if not needed:
        pytest.skip("no library for glibc")
    assert max(map(int, needed)) <= 17


def test_no_two_sources_have_one_file_name():
    names = [Path(name).name for name in source_files() if name.endswith(".c")]
    assert len(names) == len(set(names)) > 20
