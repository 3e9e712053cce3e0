"""Files kept on disk: the bound, what goes first, and places where nothing can be changed."""

import logging
import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cases import Chain
from slipmode.__main__ import main
from slipmode.rom import Coulomb, SlipmodeError, Structure, Tanh, reduce, two_mass
from slipmode.rom.storage.files import replacing
from slipmode.rom.table import disk_cache
from slipmode.rom.table.cache import cached_model

ARGUMENTS = (reduce(two_mass(), modes=(0,)), Tanh(2.0, 0.1), (4.0,), 1e-2)
SIZE = 300_000  # of an entry [bytes]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache, in a folder that has a file of the user's."""
    kept = tmp_path / "cache"
    kept.mkdir()
    (kept / "thesis.rom").write_bytes(b"not ours")
    monkeypatch.setenv("SLIPMODE_CACHE", str(kept))
    return kept


def save(path):
    with replacing(path) as file:
        file.write(bytes(SIZE))


def add(number, used):
    """Keep an entry that was used at a time [s]."""
    name = f"{number:032x}.rom"
    disk_cache.keep(name, save)
    path = disk_cache.folder() / name
    if path.exists():
        os.utime(path, (used, used))
    return path


def warnings_of(caplog):
    return [record.message for record in caplog.records if record.levelno >= logging.WARNING]


def forbid(monkeypatch, *operations):
    """Path operations that end as where permissions do not allow them."""

    def refused(self, *arguments, **options):
        raise PermissionError(13, "Permission denied", str(self))

    for operation in operations:
        monkeypatch.setattr(Path, operation, refused)


@pytest.mark.parametrize("damage", [b"", b"no archive"])
def test_a_damaged_entry_that_cannot_be_replaced_costs_only_time(
    folder, monkeypatch, caplog, damage
):
    expected, _ = cached_model(*ARGUMENTS)
    (entry,) = disk_cache.entries()
    entry.write_bytes(damage)
    forbid(monkeypatch, "unlink", "replace")
    with caplog.at_level(logging.WARNING, "slipmode"):
        found, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached
    assert found.hash == expected.hash
    (line,) = warnings_of(caplog)
    assert str(entry) in line
    assert "\n" not in line
    assert entry.read_bytes() == damage


def test_modes_of_equal_frequency_keep_their_own_shapes(folder):
    """With the contact, DOF 0, at rest, DOFs 2 and 3 vibrate at 7.3 rad/s; 2 hardly responds."""
    coupling, ground = np.array([0.5, 1e-6, 5.0]), np.array([0.5, 53.29 - 1e-6, 48.29])
    stiffness = np.diag(np.append(coupling.sum() + 3.0, coupling + ground))
    stiffness[0, 1:] = stiffness[1:, 0] = -coupling
    structure = Structure(np.eye(4), stiffness, damping=0.05 * stiffness, contact=[0])
    reduced = reduce(structure, modes=(0,), smallest_response=0.0)
    assert reduced.nonresonant_frequency[0] == reduced.nonresonant_frequency[1]
    for cached in (False, True):
        model, was_cached = cached_model(reduced, Coulomb(1.0), (4.0,), 1e-2)
        assert was_cached == cached
        shapes = model.reduced.nonresonant_shapes
        np.testing.assert_array_equal(np.abs(shapes), [[0.0], [0.0], [0.0], [1.0]])


def test_an_entry_that_cannot_be_read_costs_only_time(folder, monkeypatch, caplog):
    expected, _ = cached_model(*ARGUMENTS)
    forbid(monkeypatch, "is_file", "open")
    found, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached
    assert found.hash == expected.hash
    (line,) = warnings_of(caplog)
    assert str(folder) in line


def test_what_was_not_used_for_longest_goes_first(folder, monkeypatch):
    monkeypatch.setenv("SLIPMODE_CACHE_MIB", "1")  # three entries
    paths = [add(number, used=1000.0 + number) for number in range(3)]
    assert all(path.exists() for path in paths)
    assert disk_cache.find(paths[0].name, Path.read_bytes) == bytes(SIZE)  # now the newest
    paths.append(add(3, used=2000.0))
    assert [path.exists() for path in paths] == [True, False, True, True]
    assert (folder / "thesis.rom").exists()


def test_the_bound_holds_for_models(folder, monkeypatch):
    monkeypatch.setenv("SLIPMODE_CACHE_MIB", "0")
    _, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached
    assert disk_cache.entries() == {}
    assert (folder / "thesis.rom").exists()


def test_an_entry_that_cannot_be_removed_is_told_of(folder, monkeypatch, caplog):
    monkeypatch.setenv("SLIPMODE_CACHE_MIB", "1")
    paths = [add(number, used=1000.0 + number) for number in range(3)]
    forbid(monkeypatch, "unlink")
    add(3, used=2000.0)
    assert any(str(paths[0]) in line for line in warnings_of(caplog))


def test_what_a_killed_process_left_is_removed(folder):
    left, at_work = (folder / f".slipmode-{name}.part" for name in ("left", "at-work"))
    for path in (left, at_work):
        path.write_bytes(b"half")
    os.utime(left, (1000.0, 1000.0))
    add(0, used=1000.0)
    assert not left.exists()
    assert at_work.exists()


@pytest.mark.parametrize("value", ["much", "-1", "nan", "inf"])
def test_a_bound_that_is_none_is_refused(folder, monkeypatch, value):
    monkeypatch.setenv("SLIPMODE_CACHE_MIB", value)
    with pytest.raises(SlipmodeError, match=r"SLIPMODE_CACHE_MIB: must be a number >= 0 \[MiB\]"):
        disk_cache.bound()


def test_the_command_shows_and_clears_the_cache(folder, capsys):
    for number in range(3):
        add(number, used=1000.0)
    assert main(["cache"]) == 0
    printed = capsys.readouterr().out
    assert str(folder) in printed
    assert "3 files" in printed
    assert "0.9 of at most 1024 MiB" in printed
    assert main(["cache", "--clear"]) == 0
    assert "removed 3 files" in capsys.readouterr().out
    assert [path.name for path in folder.iterdir()] == ["thesis.rom"]


def test_a_cache_that_is_not_there_is_empty(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("SLIPMODE_CACHE", str(tmp_path / "none"))
    assert main(["cache"]) == 0
    assert "0 files" in capsys.readouterr().out
    assert main(["cache", "--clear"]) == 0


def test_entries_do_not_grow_with_the_structure(folder):
    """Its shapes are left out, and are there again in the model that is found."""
    law, size, models = Tanh(2.0, 0.1), [], []
    for masses in (20, 400):
        structure = Chain(masses).structure(modal_damping=False)
        reduced = reduce(structure, (0,), force_patterns=[np.ones(masses)])
        computed, _ = cached_model(reduced, law, (0.5,), 1e-1)
        found, was_cached = cached_model(reduced, law, (0.5,), 1e-1)
        assert was_cached
        assert found.hash == computed.hash
        for name in ("mode_shapes", "contact_shapes", "nonresonant_shapes", "force_patterns"):
            np.testing.assert_array_equal(
                getattr(found.reduced, name), getattr(computed.reduced, name)
            )
        models.append(found)
        size.append(max(disk_cache.entries().values()))
    assert [model.reduced.n_dofs for model in models] == [20, 400]
    assert size[1] < 1.2 * size[0]
