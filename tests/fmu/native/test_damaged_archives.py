"""FMUs whose files claim more than they contain."""

import io
import zipfile
import zlib

import numpy as np
import pytest
from damage.hostile import claiming, npy, rewritten, zeros

from slipmode import fmu, rom
from slipmode.fmu.imported import Archive, Imported
from slipmode.rom import SlipmodeError


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    model = rom.model_of_rates(lambda r: (0.5 + 0 * r, 100.0 + 0 * r), amplitude=[0.1])
    path = tmp_path_factory.mktemp("exported") / "model.fmu"
    return fmu.export(model, path, [{0: 1.0}], mode_names=("A",))


def refusal_of(path):
    with pytest.raises(SlipmodeError) as refusal:
        Archive(path)
    assert str(path) in str(refusal.value) and "\n" not in str(refusal.value)
    return str(refusal.value)


@pytest.mark.parametrize("shape", [(-3,), (10**9,), (2**31, 2**31), (5, 5)])
def test_importing_refuses_nodes_that_are_not_in_their_file(exported, tmp_path, shape):
    assert Archive(exported).amplitude_range == (0.1,)
    target = rewritten(exported, tmp_path / "m.fmu", resources__node_a=claiming(shape))
    assert "its model is damaged: " in refusal_of(target)


def test_importing_refuses_an_archive_that_unpacks_to_much(exported, tmp_path):
    target = rewritten(exported, tmp_path / "bomb.fmu", documentation__picture=zeros(300))
    assert "unpacks to 30" in refusal_of(target)


def test_the_fmu_refuses_an_array_that_is_not_in_its_file(exported, tmp_path):
    """8 TB of contact stiffness, which layout.npy announces; no memory is requested for it."""
    many = 10**6
    with zipfile.ZipFile(exported) as archive:
        files = {n: archive.read(n) for n in archive.namelist() if n.endswith(".npy")}
    layout, checksums = (
        np.load(io.BytesIO(files[f"resources/{name}.npy"])) for name in ("layout", "checksums")
    )
    layout[2] = many  # contacts
    changed = {"layout": npy(layout), "contact_stiffness": claiming((many, many))}
    for name, content in changed.items():
        before = zlib.crc32(files[f"resources/{name}.npy"])
        after = np.uint32(zlib.crc32(content)).view(np.int32)
        checksums[checksums.view(np.uint32) == before] = after
    changed["checksums"] = npy(checksums)
    members = {f"resources__{name}": content for name, content in changed.items()}
    target = rewritten(exported, tmp_path / "announced.fmu", **members)
    with pytest.raises(SlipmodeError, match=r"contact_stiffness\.npy: it is truncated"):
        Imported(target)
