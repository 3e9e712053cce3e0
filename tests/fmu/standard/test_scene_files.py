"""What an exported scene carries for importers: its script, terminals, whose it is."""

import csv
import shutil
import zipfile
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_fixtures import instance
from lxml import etree

from slipmode import fmu
from slipmode.__main__ import main
from slipmode.fmu.description.options import Origin
from slipmode.rom import SlipmodeError
from slipmode.runner import export_fmu, load_scene

REFERENCES = "extra/org.fmi-standard.fmi-ls-ref"


@pytest.fixture(scope="module")
def scene_fmu(tmp_path_factory):
    """The shipped scene in which a force jumps, unpacked."""
    folder = tmp_path_factory.mktemp("scene")
    path = export_fmu("two-mode", folder / "scene.fmu")
    shutil.unpack_archive(path, folder / "scene", format="zip")
    return folder / "scene"


def columns(path):
    with path.open() as file:
        names, *rows = csv.reader(file)
    return names, np.array(rows, dtype=float)


def at(time, rows):
    """What stimuli say at a time: their last row there, or what is between rows."""
    there = rows[rows[:, 0] == time]
    if len(there):
        return there[-1, 1:]
    k = np.searchsorted(rows[:, 0], time)
    share = (time - rows[k - 1, 0]) / (rows[k, 0] - rows[k - 1, 0])
    return (1.0 - share) * rows[k - 1, 1:] + share * rows[k, 1:]


def test_the_experiment_can_be_run_from_the_file_alone(scene_fmu):
    """Without the scene: stimuli in, reference results out."""
    folder = scene_fmu / REFERENCES
    (experiment,) = etree.parse(folder / "fmi-ls-manifest.xml").getroot()
    stimuli, references = (folder / child.get("source") for child in experiment)
    names, given = columns(stimuli)
    results, expected = columns(references)
    assert 3 <= len(given) < 10  # breakpoints alone
    assert np.ptp(given[:, names.index("force_B")]) == 0.25
    assert expected[-1, 0] == float(experiment.get("stopTime"))
    slow = [name for name in results[1:] if not name.startswith(("contact", "x_"))]
    found = []
    with instance(scene_fmu, 3) as made:
        made.start(**dict(zip(names[1:], at(0.0, given), strict=True)))
        for start, end in zip(expected[:-1, 0], expected[1:, 0], strict=True):
            made.set(**dict(zip(names[1:], at(start, given), strict=True)))
            made.step(start, end - start)
            found.append(made.get(*slow))
    chosen = expected[1:, [results.index(name) for name in slow]]
    np.testing.assert_allclose(found, chosen, rtol=1e-9, atol=1e-12)


def test_a_sweep_is_two_rows_of_stimuli(tmp_path):
    """And FMPy, which knows nothing of scenes, comes to its reference results."""
    scene = load_scene("sweep")
    scene = replace(scene, contact=(), run=replace(scene.run, duration=400.0))
    path = export_fmu(scene, tmp_path / "sweep.fmu")
    folder = tmp_path / "unpacked"
    shutil.unpack_archive(path, folder, format="zip")
    names, given = columns(folder / REFERENCES / "stimuli.csv")
    results, expected = columns(folder / REFERENCES / "reference.csv")
    assert given[:, 0].tolist() == [0.0, 400.0]
    signals = np.array([tuple(row) for row in given], dtype=[(name, float) for name in names])
    outputs = ["A_re", "A_im", "B_re", "B_im"]
    through = fmpy.simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=400.0,
        step_size=2.0,
        output_interval=2.0,
        input=signals,
        output=outputs,
    )
    for name in outputs:
        reference = expected[:, results.index(name)]
        assert np.abs(through[name] - reference).max() < 1e-6 * np.abs(reference).max()


def test_every_force_and_contact_has_a_terminal(scene_fmu):
    root = etree.parse(scene_fmu / "terminalsAndIcons" / "terminalsAndIcons.xml").getroot()
    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    schema = etree.XMLSchema(etree.parse(schemas / "fmi3TerminalsAndIcons.xsd"))
    schema.assertValid(root)
    members = {
        terminal.get("name"): [member.get("variableName") for member in terminal]
        for terminal in root.iter("Terminal")
    }
    variables = {v.name for v in fmpy.read_model_description(scene_fmu).modelVariables}
    assert set(members) == {"excitation_A", "excitation_B", "contact_0", "contact_1"}
    assert "frequency_rate_B" in members["excitation_B"] and len(members["excitation_B"]) == 6
    assert members["contact_1"] == ["contact_1_x", "contact_1_v", "contact_1_f"]
    assert {name for listed in members.values() for name in listed} <= variables


@pytest.mark.parametrize("fmi", [2, 3])
def test_whose_model_it_is(fmi, tmp_path, capsys):
    path = tmp_path / "mine.fmu"
    said = ["--author", "Ada & Co", "--copyright", "(C) Ada", "--license", "none", "--dated"]
    assert main(["fmu", "one-mode", "-o", str(path), "--fmi", str(fmi), *said]) == 0
    assert validate_fmu(str(path)) == []
    found = fmpy.read_model_description(path)
    assert (found.author, found.copyright, found.license) == ("Ada & Co", "(C) Ada", "none")
    made = datetime.fromisoformat(found.generationDateAndTime)
    assert abs((datetime.now(UTC) - made).total_seconds()) < 600.0


def test_unless_somebody_says_so_nothing_is_said(one_mode_model, tmp_path):
    """The model is not ours to license, and equal models give equal files."""
    paths = [fmu.export(one_mode_model, tmp_path / name) for name in ("a.fmu", "b.fmu")]
    found = fmpy.read_model_description(paths[0])
    assert (found.author, found.copyright, found.license) == (None, None, None)
    assert found.generationDateAndTime is None
    assert paths[0].read_bytes() == paths[1].read_bytes()
    names = zipfile.ZipFile(paths[0]).namelist()
    assert "documentation/licenses/slipmode.txt" in names  # of the library inside


def test_what_xml_cannot_hold_is_refused():
    with pytest.raises(SlipmodeError, match="author: must be one line"):
        Origin(author="two\nlines")
    with pytest.raises(SlipmodeError, match="generated: must be a time with a time zone"):
        Origin(generated=datetime(2026, 1, 1))


def test_contacts_are_outputs_without_a_window(tmp_path):
    scene = replace(load_scene("one-mode"), contact=())
    without = export_fmu(scene, tmp_path / "without.fmu")
    path = export_fmu(scene, tmp_path / "with.fmu", contacts=True)
    names = [
        {v.name for v in fmpy.read_model_description(p).modelVariables} for p in (without, path)
    ]
    assert "contact_0_v" not in names[0] and "contact_0_v" in names[1]
    folder = tmp_path / "with"
    shutil.unpack_archive(path, folder, format="zip")
    with instance(folder, 3) as made:
        made.start()
        made.step(0.0, 700.0)
        assert np.abs(made.get("contact_0_x", "contact_0_v")).min() > 0.0
