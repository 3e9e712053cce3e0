"""Files that are written whole or not at all, and files that claim more than they contain."""

import errno
import tracemalloc

import pytest
from damage.hostile import MIB, claiming, rewritten, zeros

from slipmode import rom
from slipmode.rom.storage.files import replacing


def test_a_file_is_replaced_only_when_it_is_whole(tmp_path):
    path = tmp_path / "kept"
    path.write_bytes(b"before")
    with replacing(path) as one, replacing(path) as other:
        one.write(b"one")
        other.write(b"other")
        assert path.read_bytes() == b"before"
    assert path.read_bytes() == b"one"  # whose context ends last
    for error in (RuntimeError, KeyboardInterrupt):
        with pytest.raises(error), replacing(path) as file:
            file.write(b"half")
            raise error
    (tmp_path / "plain").touch()
    assert path.read_bytes() == b"one"
    assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode
    assert sorted(each.name for each in tmp_path.iterdir()) == ["kept", "plain"]


def test_an_error_names_the_file_that_was_asked_for(tmp_path):
    with pytest.raises(OSError) as failure, replacing(tmp_path / "file"):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert failure.value.filename == str(tmp_path / "file")
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A structure and a model, each with the function that reads it and one of its arrays."""
    folder = tmp_path_factory.mktemp("saved")
    rom.two_mass().save(folder / "structure.npz")
    model = rom.model_of_rates(lambda r: (0.5 + 0 * r, 100.0 + 0 * r), amplitude=[0.1])
    model.save(folder / "model.npz")
    return {
        "structure": (folder / "structure.npz", rom.load_structure, "mass"),
        "model": (folder / "model.npz", rom.Model.load, "node_a"),
    }


@pytest.mark.parametrize("kind", ["structure", "model"])
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (claiming((10**9,)), r"{}.npy: an array of shape (1000000000,) is not in"),
        (claiming((2**31, 2**31)), "{}.npy: an array of shape"),  # beyond any address space
        (claiming((-(10**9), -8)), "{}.npy: an array of shape (-1000000000, -8) is not in"),
        (300, "unpacks to 300 MiB, more than 256 MiB"),
    ],
    ids=["8 GB", "2^62", "negative", "bomb"],
)
def test_arrays_that_a_file_does_not_justify_take_no_memory(
    saved, tmp_path, kind, content, message
):
    path, load, name = saved[kind]
    load(path)
    content = zeros(content) if isinstance(content, int) else content
    target = rewritten(path, tmp_path / "claims.npz", **{name: content})
    tracemalloc.start()
    try:
        with pytest.raises(rom.SlipmodeError) as refusal:
            load(target)
        assert tracemalloc.get_traced_memory()[1] < 4 * MIB
    finally:
        tracemalloc.stop()
    assert message.format(name) in str(refusal.value)
    assert str(target) in str(refusal.value) and "\n" not in str(refusal.value)


def test_the_memory_of_a_file_can_be_set(saved, monkeypatch):
    path, load, _ = saved["structure"]
    monkeypatch.setenv("SLIPMODE_MEMORY_MIB", "0")
    with pytest.raises(rom.SlipmodeError, match="SLIPMODE_MEMORY_MIB=1"):
        load(path)
