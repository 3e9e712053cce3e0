"""Models kept on disk: the same bits, the bound, and places where nothing can be changed."""

import logging
import os
from pathlib import Path

import numpy as np
import pytest

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError, Tanh, reduce, tabulate, two_mass
from slipmode.rom.storage.files import replacing
from slipmode.rom.table import disk_cache
from slipmode.rom.table.cache import cached_model

pytestmark = pytest.mark.quick

ALONE, LAW = reduce(two_mass(), modes=(0,)), Tanh(2.0, 0.1)
ARGUMENTS = (ALONE, LAW, (4.0,), 1e-2)
SIZE = 300_000  # of an entry [bytes]


@pytest.fixture(scope="module")
def computed():
    return tabulate(*ARGUMENTS)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache, in a folder that has a file of the user's."""
    kept = tmp_path / "cache"
    kept.mkdir()
    (kept / "thesis.rom").write_bytes(b"not ours")
    monkeypatch.setenv("SLIPMODE_CACHE", str(kept))
    return kept


def add(number, used):
    """Keep an entry that was used at a time [s]."""

    def save(path):
        with replacing(path) as file:
            file.write(bytes(SIZE))

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


def test_the_second_time_the_same_bits_come_from_the_cache(computed, folder):
    points = np.linspace(0.0, 4.0, 50)[:, np.newaxis]
    for expected in (False, True):
        model, was_cached = cached_model(*ARGUMENTS)
        assert was_cached == expected
        assert (model.hash, model.accuracy) == (computed.hash, computed.accuracy)
        np.testing.assert_array_equal(model.table.terms(points), computed.table.terms(points))
    longer, was_cached = cached_model(ALONE, LAW, (3.2,), 1e-2, headroom=1.25)
    assert was_cached and longer.hash == computed.hash


@pytest.mark.parametrize("repairable", [True, False])
@pytest.mark.parametrize("damage", [b"", b"no archive"])
def test_a_damaged_entry_costs_only_time(
    computed, folder, monkeypatch, caplog, damage, repairable
):
    cached_model(*ARGUMENTS)
    (entry,) = disk_cache.entries()
    entry.write_bytes(damage)
    with monkeypatch.context() as patch, caplog.at_level(logging.WARNING, "slipmode"):
        if not repairable:
            forbid(patch, "unlink", "replace")
        found, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached and found.hash == computed.hash
    if not repairable:
        (line,) = warnings_of(caplog)
        assert str(entry) in line and "\n" not in line
        assert entry.read_bytes() == damage
    assert cached_model(*ARGUMENTS)[1] == repairable


def test_a_cache_that_cannot_be_read_or_written_costs_only_time(
    computed, folder, tmp_path, monkeypatch, caplog
):
    cached_model(*ARGUMENTS)
    with monkeypatch.context() as patch:
        forbid(patch, "is_file", "open")
        found, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached and found.hash == computed.hash
    assert str(folder) in warnings_of(caplog)[0]
    occupied = tmp_path / "file"
    occupied.write_text("not a folder")
    monkeypatch.setenv("SLIPMODE_CACHE", str(occupied))
    found, was_cached = cached_model(*ARGUMENTS)
    assert not was_cached and found.hash == computed.hash


def test_the_command_shows_and_clears_the_cache(folder, tmp_path, monkeypatch, capsys):
    for number in range(3):
        add(number, used=1000.0)
    assert main(["cache"]) == 0
    printed = capsys.readouterr().out
    assert str(folder) in printed and "3 files" in printed
    assert "0.9 of at most 1024 MiB" in printed
    assert main(["cache", "--clear"]) == 0
    assert "removed 3 files" in capsys.readouterr().out
    assert [path.name for path in folder.iterdir()] == ["thesis.rom"]
    monkeypatch.setenv("SLIPMODE_CACHE", str(tmp_path / "none"))
    assert main(["cache"]) == 0
    assert "0 files" in capsys.readouterr().out
    for value in ("much", "-1", "nan", "inf"):
        monkeypatch.setenv("SLIPMODE_CACHE_MIB", value)
        with pytest.raises(SlipmodeError, match=r"SLIPMODE_CACHE_MIB: must be a number >= 0 \[M"):
            disk_cache.bound()
