"""Models on disk: nothing is lost, and no damage goes unnoticed."""

import dataclasses
import zipfile

import numpy as np
import pytest
from elastic import cantilever as elastic_contacts

from slipmode.rom import Coulomb, Model, SlipmodeError, Tanh, reduce, tabulate, two_mass

pytestmark = pytest.mark.quick

ALONE = reduce(two_mass(), modes=(0,))
LAW = Tanh(2.0, 0.1)
ARGUMENTS = (ALONE, LAW, (4.0,), 1e-2)


@pytest.fixture(scope="module")
def small_model():
    return tabulate(*ARGUMENTS)


@pytest.fixture
def saved(small_model, tmp_path):
    path = tmp_path / "model.rom"
    small_model.save(path)
    return path


def assert_same_part(first, second):
    for field in dataclasses.fields(first):
        values = [getattr(part, field.name) for part in (first, second)]
        np.testing.assert_array_equal(*values)
        assert np.asarray(values[0]).dtype == np.asarray(values[1]).dtype


def assert_same_model(first, second):
    # the structure is not part of a file
    reduced = [dataclasses.replace(model.reduced, structure=None) for model in (first, second)]
    assert_same_part(*reduced)
    assert_same_part(first.table, second.table)
    assert first.accuracy == second.accuracy
    assert first.hash == second.hash


def refusal_of(path):
    with pytest.raises(SlipmodeError) as refusal:
        Model.load(path)
    message = str(refusal.value)
    assert "\n" not in message
    assert str(path) in message
    return message


@pytest.mark.parametrize(
    ("law", "formulation"),
    [
        (LAW, "paper"),
        (Tanh((2.0, 1.0), 0.1), "consistent"),
        (Coulomb(2.0), "consistent"),
        (Coulomb((2.0, 0.5)), "paper"),
    ],
    ids=str,
)
def test_what_is_saved_loads_to_the_last_bit(law, formulation, tmp_path):
    """Of one mode and, in the paper's formulation, of two with harmonics."""
    both = formulation == "paper"
    reduced = reduce(two_mass(), modes=(0, 1) if both else (1,), formulation=formulation)
    reach, harmonics = ((2.0, 1.0), 5) if both else ((2.0,), 0)
    model = tabulate(reduced, law, reach, tolerance=3e-2, harmonics=harmonics)
    model.save(tmp_path / "model.rom")
    loaded = Model.load(tmp_path / "model.rom")
    assert_same_model(loaded, model)
    assert type(loaded.law) is type(law)
    np.testing.assert_array_equal(np.broadcast_to(law.limit, 2), loaded.law.limit)
    amplitudes = np.linspace(0, 1, 101)[:, np.newaxis] * reach
    np.testing.assert_array_equal(loaded.table(amplitudes), model.table(amplitudes))
    if both:
        np.testing.assert_array_equal(loaded.harmonics.P, model.harmonics.P)


@pytest.mark.parametrize("name", elastic_contacts.LAWS)
def test_models_with_elastic_contacts_load_to_the_last_bit(name, tmp_path):
    model = elastic_contacts.model(name, (0,))
    model.save(tmp_path / "model.rom")
    loaded = Model.load(tmp_path / "model.rom")
    assert_same_part(loaded.table, model.table)
    assert_same_part(loaded.reduced.contacts, model.reduced.contacts)
    assert (loaded.law, loaded.hash) == (model.law, model.hash)


def test_the_same_model_has_the_same_hash_and_content_and_others_another(small_model, tmp_path):
    again, contents = tabulate(*ARGUMENTS), []
    assert again.hash == small_model.hash
    for model in (small_model, again):
        model.save(tmp_path / "model.rom")
        with zipfile.ZipFile(tmp_path / "model.rom") as archive:
            contents.append({name: archive.read(name) for name in archive.namelist()})
    assert contents[0] == contents[1]
    for other in (
        (reduce(two_mass(beta=0.011), modes=(0,)), LAW, (4.0,), 1e-2),
        (ALONE, Tanh(2.0, 0.11), (4.0,), 1e-2),
        (ALONE, LAW, (4.1,), 1e-2),
        (ALONE, LAW, (4.0,), 1.1e-2),
    ):
        assert tabulate(*other).hash != small_model.hash


# Damage


def rewritten(path, **changed):
    """The same archive with other entries; None leaves one out."""
    with np.load(path) as archive:
        entries = {name: archive[name] for name in archive.files} | changed
    with path.open("wb") as file:
        np.savez(file, **{name: entry for name, entry in entries.items() if entry is not None})


def with_header(path, old, new):
    with np.load(path) as archive:
        header = str(archive["header"])
    assert old in header
    rewritten(path, header=np.array(header.replace(old, new)))


def test_another_format_and_changed_entries_are_refused(saved):
    content = saved.read_bytes()
    with np.load(saved) as archive:
        number = str(archive["header"]).split('"format": ')[1].split(",")[0]
    with_header(saved, f'"format": {number}', '"format": 999')
    assert "tabulate the model again" in refusal_of(saved)
    saved.write_bytes(content)
    with_header(saved, '"alpha": 0.1', '"alpha": 0.2')
    assert "damaged" in refusal_of(saved)
    saved.write_bytes(content)
    with np.load(saved) as archive:
        values = archive["values"].copy()
    values.flat[7] = np.nextafter(values.flat[7], 1.0)
    rewritten(saved, values=values)
    assert "damaged" in refusal_of(saved)


BROKEN = [b"", b"no archive\nat all", b"PK\x03\x04", b"\x93NUMPY", 0.1, 0.5, 0.9, 0.999]
MISSING = [{entry: None} for entry in ("header", "node_a", "values", "stiffness")]
HEADERS = [{"header": np.array(text)} for text in ("", "{}", "null", "not json")]


@pytest.mark.parametrize("damage", [*BROKEN, *MISSING, *HEADERS])
def test_what_is_no_archive_a_part_of_one_or_without_an_entry_is_refused(saved, damage):
    if isinstance(damage, dict):
        rewritten(saved, **damage)
        refusal_of(saved)
        return
    whole = saved.read_bytes()
    saved.write_bytes(whole[: int(damage * len(whole))] if isinstance(damage, float) else damage)
    assert "not a readable model file" in refusal_of(saved)


def test_files_that_are_not_there_or_cannot_be_written_are_refused(small_model, tmp_path):
    assert "no such model file" in refusal_of(tmp_path / "absent.rom")
    refusal_of(tmp_path)
    with pytest.raises(OSError):
        small_model.save(tmp_path / "absent" / "model.rom")
    assert not any(tmp_path.iterdir())
