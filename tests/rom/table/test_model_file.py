"""Models on disk: nothing is lost, no damage goes unnoticed, the cache repairs itself."""

import dataclasses
import json
import struct
import threading
import zipfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from elastic import cantilever as elastic_contacts

from slipmode.rom import (
    Coulomb,
    Model,
    SlipmodeError,
    Tanh,
    model_of_rates,
    reduce,
    tabulate,
    two_mass,
)
from slipmode.rom.table import disk_cache
from slipmode.rom.table.cache import cached_model
from slipmode.rom.table.model import digest

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


@pytest.fixture
def empty_cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("SLIPMODE_CACHE", str(folder))
    return folder


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
    "law", [LAW, Tanh((2.0, 1.0), 0.1), Coulomb(2.0), Coulomb((2.0, 0.5))], ids=str
)
@pytest.mark.parametrize("formulation", ["paper", "consistent"])
def test_what_is_saved_loads_to_the_last_bit(law, formulation, tmp_path):
    reduced = reduce(two_mass(), modes=(1,), formulation=formulation)
    model = tabulate(reduced, law, (2.0,), tolerance=1e-2)
    model.save(tmp_path / "model.rom")
    loaded = Model.load(tmp_path / "model.rom")
    assert_same_model(loaded, model)
    assert type(loaded.law) is type(law)
    assert loaded.law.alpha == law.alpha
    np.testing.assert_array_equal(np.broadcast_to(law.limit, 2), loaded.law.limit)
    amplitudes = np.linspace(0, 2, 101)[:, np.newaxis]
    np.testing.assert_array_equal(loaded.table(amplitudes), model.table(amplitudes))


@pytest.mark.parametrize("name", elastic_contacts.LAWS)
def test_models_with_elastic_contacts_load_to_the_last_bit(name, tmp_path):
    model = elastic_contacts.model(name, (0,))
    model.save(tmp_path / "model.rom")
    loaded = Model.load(tmp_path / "model.rom")
    assert_same_part(loaded.table, model.table)
    assert loaded.law == model.law
    assert loaded.hash == model.hash
    for field in dataclasses.fields(model.reduced.contacts):
        values = [getattr(m.reduced.contacts, field.name) for m in (loaded, model)]
        np.testing.assert_array_equal(*values)


def test_two_mode_models_load_to_the_last_bit(two_mode_model, tmp_path):
    two_mode_model.save(tmp_path / "both.rom")
    assert_same_model(Model.load(tmp_path / "both.rom"), two_mode_model)


def test_the_same_model_has_the_same_hash_and_file(small_model, tmp_path):
    again = tabulate(*ARGUMENTS)
    assert again.hash == small_model.hash
    paths = tmp_path / "first.rom", tmp_path / "second.rom"
    for model, path in zip((small_model, again), paths, strict=True):
        model.save(path)
    contents = []
    for path in paths:
        with zipfile.ZipFile(path) as archive:
            contents.append({name: archive.read(name) for name in archive.namelist()})
    assert contents[0] == contents[1]


@pytest.mark.parametrize(
    "other",
    [
        (reduce(two_mass(beta=0.011), modes=(0,)), LAW, (4.0,), 1e-2),
        (ALONE, Tanh(2.0, 0.11), (4.0,), 1e-2),
        (ALONE, Tanh(2.1, 0.1), (4.0,), 1e-2),
        (ALONE, LAW, (4.1,), 1e-2),
        (ALONE, LAW, (4.0,), 1.1e-2),
    ],
    ids=["damping", "alpha", "limit", "amplitude", "tolerance"],
)
def test_another_model_has_another_hash(small_model, other):
    assert tabulate(*other).hash != small_model.hash


# Damage


def positions_of_content(path):
    """Positions of the bytes of the entries, without the archive's bookkeeping."""
    content, positions = path.read_bytes(), set()
    with zipfile.ZipFile(path) as archive:
        for entry in archive.infolist():
            name, extra = struct.unpack_from("<HH", content, entry.header_offset + 26)
            start = entry.header_offset + 30 + name + extra
            positions.update(range(start, start + entry.compress_size))
    return positions


def test_a_flipped_byte_anywhere_is_noticed_or_harmless(small_model, saved):
    content, of_entries = saved.read_bytes(), positions_of_content(saved)
    positions = np.unique(np.linspace(0, len(content) - 1, 400).astype(int)).tolist()
    assert 100 < len(of_entries & set(positions)) < 400
    for position in positions:
        damaged = bytearray(content)
        damaged[position] ^= 0xFF
        saved.write_bytes(damaged)
        try:
            loaded = Model.load(saved)
        except SlipmodeError as refusal:
            assert "\n" not in str(refusal)
        else:  # a byte of the archive's bookkeeping that nothing depends on
            assert position not in of_entries
            assert_same_model(loaded, small_model)


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused(saved, part):
    content = saved.read_bytes()
    saved.write_bytes(content[: int(part * len(content))])
    assert "not a readable model file" in refusal_of(saved)


@pytest.mark.parametrize("content", [b"", b"no archive\nat all", b"PK\x03\x04", b"\x93NUMPY"])
def test_what_is_no_archive_is_refused(saved, content):
    saved.write_bytes(content)
    assert "not a readable model file" in refusal_of(saved)


def test_a_single_array_is_refused(tmp_path):
    path = tmp_path / "array.npy"
    np.save(path, np.eye(3))
    assert "not a readable model file" in refusal_of(path)


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


def test_another_format_is_refused_with_what_to_do(saved):
    with np.load(saved) as archive:
        header = str(archive["header"])
    number = header.split('"format": ')[1].split(",")[0]
    with_header(saved, f'"format": {number}', '"format": 999')
    assert "tabulate the model again" in refusal_of(saved)


def test_a_changed_header_is_refused(saved):
    with_header(saved, '"alpha": 0.1', '"alpha": 0.2')
    assert "damaged" in refusal_of(saved)


@pytest.mark.parametrize("entry", ["header", "node_a", "values", "stiffness"])
def test_a_missing_entry_is_refused(saved, entry):
    rewritten(saved, **{entry: None})
    refusal_of(saved)


@pytest.mark.parametrize("header", ["", "{}", "[]", "null", '{"hash": 1}', "not json"])
def test_a_header_that_is_none_is_refused(saved, header):
    rewritten(saved, header=np.array(header))
    refusal_of(saved)


def test_a_changed_array_is_refused(saved):
    with np.load(saved) as archive:
        values = archive["values"].copy()
    values.flat[7] = np.nextafter(values.flat[7], 1.0)
    rewritten(saved, values=values)
    assert "damaged" in refusal_of(saved)


JENKINS = {"law": "jenkins", "limit": 2.0, "stiffness": 3.0}
SURFACE = {
    **{"law": "frictional", "mu": 0.3, "preload": 1.0, "tangential_stiffness": 3.0},
    **{"normal_stiffness": 4.0, "gap": 0.0, "tangents": 1},
}


def with_law(path, law):
    """The file with another law, and the hash of that; None leaves it out."""
    with np.load(path) as archive:
        content = {name: archive[name] for name in archive.files}
    header = json.loads(str(content.pop("header")))
    del header["hash"], header["law"]
    if law is not None:
        header["law"] = law
    stored = json.dumps(header | {"hash": digest(header, content)})
    rewritten(path, header=np.array(stored))


@pytest.mark.parametrize(
    ("law", "complaint"),
    [
        (None, "must be one of tanh, coulomb, jenkins"),
        ("tanh", "must be one of"),
        ({"law": "glue"}, "must be one of"),
        ({"law": ["tanh"]}, "must be one of"),
        ({"limit": 2.0, "alpha": 0.1}, "must be one of"),
        ({"law": "tanh", "limit": 2.0}, "tanh needs alpha"),
        ({"law": "tanh", "limit": 2.0, "alpha": 0.1, "mu": 1.0}, "tanh has no parameter 'mu'"),
        ({"law": "tanh", "limit": "2", "alpha": 0.1}, "limit of tanh has a wrong type"),
        ({"law": "tanh", "limit": 2.0, "alpha": [0.1]}, "alpha of tanh has a wrong type"),
        ({"law": "tanh", "limit": -2.0, "alpha": 0.1}, "limit: must be 0 or"),
        ({"law": "tanh", "limit": 2.0, "alpha": float("nan")}, "alpha: must be"),
        (
            {"law": "tanh", "limit": [2.0, 1.0, 1.0], "alpha": 0.1},
            "limit: must be one number or 2",
        ),
        ({"law": "coulomb", "limit": 10**400}, "too large"),
        (JENKINS, "does not fit the stiffness of the contacts"),
    ],
)
def test_a_law_that_is_none_is_refused(saved, law, complaint):
    with_law(saved, law)
    assert f"{saved}: law: " in refusal_of(saved)
    assert complaint in refusal_of(saved)


@pytest.mark.parametrize(
    ("law", "complaint"),
    [
        (None, "must be one of"),
        (JENKINS | {"stiffness": 3e9}, "does not fit the stiffness"),
        (JENKINS | {"stiffness": 0.0}, "stiffness: must be"),
        (JENKINS | {"limit": [1.0, 2.0]}, "limit: must be one number or 4 numbers"),
        (JENKINS | {"limit": True}, "limit of jenkins has a wrong type"),
        (SURFACE | {"mu": -0.1}, "mu: must be"),
        (SURFACE | {"tangents": 3}, "tangents: must be 1 or 2"),
        (SURFACE | {"tangents": 2}, "must be a multiple of 3; got 4"),
        (SURFACE | {"tangents": 1.0}, "tangents of frictional has a wrong type"),
        (SURFACE | {"gap": 0.1}, "gap: must be 0 where preload > 0"),
        (
            {"law": "iwan", "force": [1.0], "stiffness": 2.0, "chi": 0.0, "beta": 0.0},
            "force of iwan has a wrong type",
        ),
        (
            {"law": "iwan", "force": 1.0, "stiffness": 2.0, "chi": 1.5, "beta": 0.0},
            "chi: must be above -1",
        ),
        ({"law": "sliders", "limit": [1.0], "stiffness": [1.0, 2.0]}, "stiffness: must be 1"),
        ({"law": "none"}, "NoContacts() is the law of rom.model_of_rates"),
        ({"law": "none", "limit": 1.0}, "must be one of"),
        ({"law": "groups", "groups": [[{"law": "none"}, [0, 1, 2, 3]]]}, "must be one of"),
        ({"law": "groups"}, "must have a list of groups"),
        ({"law": "groups", "groups": [], "mu": 1.0}, "must have a list of groups"),
        ({"law": "groups", "groups": []}, "must have at least one group"),
        ({"law": "groups", "groups": [JENKINS]}, "a group must be a law and its contact DOFs"),
        ({"law": "groups", "groups": [[JENKINS, [0, 1, 2]]]}, "one group; missing: [3]"),
        ({"law": "groups", "groups": [[JENKINS, [0, 1, 2, 3, 3]]]}, "in two groups: [3]"),
        ({"law": "groups", "groups": [[JENKINS, [0, 1, 2, 4]]]}, "unknown: [4]"),
        ({"law": "groups", "groups": [[JENKINS, [0, 1, 2, 0.5]]]}, "must be integers"),
        ({"law": "groups", "groups": [[{"law": "coulomb", "limit": 1.0}, [0]]]}, "elastic"),
        ({"law": "groups", "groups": [[{"law": "groups", "groups": []}, [0]]]}, "must be one of"),
    ],
)
def test_an_elastic_law_that_is_none_is_refused(law, complaint, tmp_path):
    path = tmp_path / "elastic.rom"
    elastic_contacts.model("Jenkins", (0,)).save(path)
    with_law(path, law)
    assert f"{path}: law: " in refusal_of(path)
    assert complaint in refusal_of(path)


def test_a_rigid_law_of_elastic_contacts_is_refused(tmp_path):
    path = tmp_path / "elastic.rom"
    elastic_contacts.model("Jenkins", (0,)).save(path)
    with_law(path, {"law": "coulomb", "limit": 2.0})
    assert "law: does not fit the stiffness of the contacts" in refusal_of(path)


def test_a_contact_law_without_contacts_is_refused(tmp_path):
    path = tmp_path / "rates.rom"
    model_of_rates(lambda a: (1.0 + a, 700.0 - a), (1.0,)).save(path)
    assert Model.load(path).reduced.n_contacts == 0
    with_law(path, JENKINS)
    assert "law: does not fit the stiffness of the contacts" in refusal_of(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    assert "no such model file" in refusal_of(tmp_path / "absent.rom")
    refusal_of(tmp_path)


def test_saving_where_nothing_can_be_written_leaves_nothing_behind(small_model, tmp_path):
    with pytest.raises(OSError):
        small_model.save(tmp_path / "absent" / "model.rom")
    assert not any(tmp_path.iterdir())


def test_saving_replaces_a_file_at_once(small_model, saved):
    saved.write_bytes(b"older")
    small_model.save(saved)
    assert_same_model(Model.load(saved), small_model)
    assert list(saved.parent.iterdir()) == [saved]


def test_threads_save_the_same_file_at_once(small_model, tmp_path):
    writers = 8
    path, start = tmp_path / "model.rom", threading.Barrier(writers)

    def save():
        start.wait()
        for _ in range(20):
            small_model.save(path)

    with ThreadPoolExecutor(writers) as pool:
        for done in [pool.submit(save) for _ in range(writers)]:
            done.result()
    assert_same_model(Model.load(path), small_model)
    assert list(tmp_path.iterdir()) == [path]


# The cache


def test_the_second_time_the_model_comes_from_the_cache(small_model, empty_cache):
    assert disk_cache.folder() == empty_cache
    computed, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached
    found, was_cached = cached_model(*ARGUMENTS)
    assert was_cached
    assert_same_model(found, computed)
    assert_same_model(found, small_model)


@pytest.mark.parametrize("damage", [b"", b"no archive"])
def test_a_damaged_entry_is_replaced(small_model, empty_cache, damage):
    cached_model(*ARGUMENTS)
    (entry,) = empty_cache.iterdir()
    entry.write_bytes(damage)
    repaired, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached
    assert_same_model(repaired, small_model)
    again, was_cached = cached_model(*ARGUMENTS)
    assert was_cached
    assert_same_model(again, small_model)


@pytest.mark.parametrize(
    "other",
    [
        (ALONE, Tanh(2.0, 0.11), (4.0,), 1e-2),
        (ALONE, Tanh((2.0, 2.1), 0.1), (4.0,), 1e-2),
        (ALONE, Coulomb(2.0), (4.0,), 1e-2),
        (ALONE, LAW, (4.1,), 1e-2),
        (ALONE, LAW, (4.0,), 2e-2),
        (reduce(two_mass(beta=0.02), modes=(0,)), LAW, (4.0,), 1e-2),
        (reduce(two_mass(), modes=(0,), formulation="paper"), LAW, (4.0,), 1e-2),
    ],
    ids=["alpha", "limit", "law", "amplitude", "tolerance", "structure", "formulation"],
)
def test_another_model_is_not_mistaken_for_a_cached_one(empty_cache, other):
    cached_model(*ARGUMENTS)
    assert not cached_model(*other)[1]


def test_a_cache_that_cannot_be_written_costs_only_time(small_model, tmp_path, monkeypatch):
    occupied = tmp_path / "file"
    occupied.write_text("not a folder")
    monkeypatch.setenv("SLIPMODE_CACHE", str(occupied))
    computed, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached
    assert_same_model(computed, small_model)
