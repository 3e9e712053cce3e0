"""Samples whose recordings could not be written are computed by the next run."""

import shutil

import numpy as np
import pytest

from slipmode.rom import SlipmodeError
from slipmode.runner import run_study

pytest.importorskip("zarr")

RECORDED = """
[[vary]]
key = "forcing.A.amplitude"
values = [0.1, 0.12, 0.14, 0.16, 0.18, 0.2]
[outputs]
steady = true
recording = true
"""


def test_a_recording_that_cannot_be_written_is_written_by_the_next_run(
    study_file, tmp_path, scheduler, caplog
):
    """A folder is in the place of its layout. Tasks have five samples, the last one has one."""
    path, folders = (
        study_file(RECORDED),
        [tmp_path / "study" / f"sample-00000{k}.foxglove.json" for k in (0, 5)],
    )
    for folder in folders:
        folder.mkdir(parents=True)
    with pytest.raises(SlipmodeError, match=r"^6 samples have no results: .*; repeat the command"):
        run_study(path, tmp_path, scheduler=scheduler)
    shutil.rmtree(folders[0])
    done = run_study(path, tmp_path, scheduler=scheduler)
    assert (done.found, done.failed) == (0, 0)
    np.testing.assert_array_equal(done.dataset()["status"].values, [1, 1, 1, 1, 1, 0])
    assert "1 samples have no results: " in caplog.text
    shutil.rmtree(folders[1])
    done = run_study(path, tmp_path, scheduler=scheduler)
    assert (done.found, done.failed) == (5, 0)
    assert (done.dataset()["status"].values == 1).all()
    assert folders[1].is_file()
