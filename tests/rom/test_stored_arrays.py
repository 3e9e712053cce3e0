"""Structures and models whose arrays claim more memory than their files justify."""

import tracemalloc
from contextlib import contextmanager

import numpy as np
import pytest
from damage.hostile import MIB, claiming, rewritten, zeros

from slipmode import rom
from slipmode.rom import SlipmodeError

# What a header may claim: 8 GB, more than any address space, negative extents
CLAIMS = [(10**9,), (2**31, 2**31), (-3,), (-(10**9), -8)]


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A structure and a model, each with the function that reads it and one of its arrays."""
    folder = tmp_path_factory.mktemp("saved")
    structure = rom.two_mass()
    structure.save(folder / "structure.npz")
    model = rom.model_of_rates(lambda r: (0.5 + 0 * r, 100.0 + 0 * r), amplitude=[0.1])
    model.save(folder / "model.npz")
    return {
        "structure": (folder / "structure.npz", rom.load_structure, "mass"),
        "model": (folder / "model.npz", rom.Model.load, "node_a"),
    }


@contextmanager
def refused_without_memory(path):
    """One line that names the file, and less than 4 MiB allocated on the way to it."""
    tracemalloc.start()
    try:
        with pytest.raises(SlipmodeError) as refusal:
            yield refusal
        assert tracemalloc.get_traced_memory()[1] < 4 * MIB
    finally:
        tracemalloc.stop()
    assert str(path) in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize("kind", ["structure", "model"])
@pytest.mark.parametrize("shape", CLAIMS)
def test_an_array_that_is_not_in_the_file_is_refused(saved, tmp_path, kind, shape):
    path, load, name = saved[kind]
    load(path)
    target = rewritten(path, tmp_path / "claims.npz", **{name: claiming(shape)})
    with refused_without_memory(target) as refusal:
        load(target)
    assert f"{name}.npy: an array of shape {shape} is not in" in str(refusal.value)


@pytest.mark.parametrize("kind", ["structure", "model"])
def test_a_small_file_that_unpacks_to_much_is_refused(saved, tmp_path, kind, monkeypatch):
    """The largest share of its size that an archive may unpack to can be set."""
    path, load, name = saved[kind]
    target = rewritten(path, tmp_path / "bomb.npz", **{name: zeros(300)})
    assert target.stat().st_size < 2 * MIB
    with refused_without_memory(target) as refusal:
        load(target)
    assert "unpacks to 300 MiB, more than 256 MiB" in str(refusal.value)
    assert "set the environment variable SLIPMODE_MEMORY_MIB=301" in str(refusal.value)
    monkeypatch.setenv("SLIPMODE_MEMORY_MIB", "0")
    with refused_without_memory(path):
        load(path)


@pytest.mark.slow
def test_a_structure_of_large_matrices_of_zeros_is_read_back(tmp_path):
    """They would be compressed to less than a tenth, which is not read."""
    n = 4200  # 269 MiB for mass and stiffness
    structure = rom.Structure(mass=np.eye(n), stiffness=np.eye(n), contact=[0])
    structure.save(tmp_path / "zeros.npz")
    np.testing.assert_array_equal(rom.load_structure(tmp_path / "zeros.npz").mass, np.eye(n))
