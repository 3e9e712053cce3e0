"""A study that is killed, loses its scheduler or cannot write goes on later."""

import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from slipmode.rom import SlipmodeError
from slipmode.runner import open_results, run_study

zarr = pytest.importorskip("zarr")

FORCES = '[[vary]]\nkey = "forcing.A.amplitude"\nvalues = [0.1, 0.12, 0.14, 0.16, 0.18, 0.2]\n'
PEAKS = """
[[vary]]
key = "forcing.A.amplitude"
distribution = "uniform"
low = 0.05
high = 0.25
[sampling]
samples = 600
[outputs]
peak = true
"""


def started(results):
    """Wait until a study has results of some samples."""
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline:
        if results.exists() and (open_results(results)["status"].values > 0).any():
            return
        time.sleep(0.01)
    raise TimeoutError


def command(path, folder):
    code = "import sys; from slipmode.__main__ import main; sys.exit(main(sys.argv[1:]))"
    return [sys.executable, "-c", code, "study", path, "-o", folder, "--workers", "1"]


@pytest.mark.slow
def test_a_study_that_is_killed_goes_on(study_file, tmp_path, scheduler):
    path = study_file(PEAKS)
    running = subprocess.Popen(
        command(path, tmp_path), start_new_session=True, stderr=subprocess.DEVNULL
    )
    started(tmp_path / "study.zarr")
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    before = open_results(tmp_path / "study.zarr").load()
    kept = before["status"].values > 0
    assert 0 < np.count_nonzero(kept) < 600
    done = run_study(path, tmp_path, workers=2)
    assert done.found == np.count_nonzero(kept)
    after = done.dataset().load()
    assert (after["status"].values == 1).all()
    np.testing.assert_array_equal(after["peak"][kept], before["peak"][kept])
    again = run_study(path, tmp_path / "whole", scheduler=scheduler).dataset().load()
    assert again.identical(after)  # whoever computes the samples, in whatever batches


@pytest.mark.slow
def test_a_killed_worker_loses_no_sample(study_file, tmp_path):
    path = study_file(PEAKS.replace("600", "200"))

    def kill_when_started():
        started(tmp_path / "study.zarr")
        multiprocessing.active_children()[0].kill()

    threading.Thread(target=kill_when_started).start()
    done = run_study(path, tmp_path, workers=2)
    assert (done.dataset()["status"].values == 1).all()
    assert not multiprocessing.active_children()


def test_a_failed_sample_is_computed_again(study_file, tmp_path):
    path = study_file(FORCES + "[outputs]\nsteady = true\n")
    before = run_study(path, tmp_path, workers=1).dataset().load()
    group = zarr.open_group(tmp_path / "study.zarr", mode="r+")
    group["status"][1], group["reason"][1], group["steady"][1] = 2, "a bad day", np.nan
    assert open_results(tmp_path / "study.zarr")["reason"].values[1] == "a bad day"
    done = run_study(path, tmp_path, workers=1)
    assert (done.found, done.failed) == (5, 0)
    assert done.dataset().load().identical(before)


@pytest.mark.slow
def test_after_a_lost_scheduler_the_computed_samples_stay(study_file, tmp_path):
    distributed = pytest.importorskip("distributed")
    path, found = study_file(PEAKS), tmp_path / "scheduler.json"
    dask, file = [sys.executable, "-m", "dask"], ["--scheduler-file", str(found)]
    quiet = {"stderr": subprocess.DEVNULL}
    ports = ["--port", "0", "--dashboard-address", ":0"]
    scheduler = subprocess.Popen([*dask, "scheduler", *file, *ports], **quiet)
    one = ["--nthreads", "1", "--no-nanny", "--no-dashboard"]
    worker = subprocess.Popen([*dask, "worker", *file, *one], **quiet)

    def kill_when_started():
        started(tmp_path / "study.zarr")
        scheduler.kill()

    try:
        with distributed.Client(scheduler_file=str(found), timeout=60) as client:
            client.wait_for_workers(1, timeout=60)
            address = client.scheduler.address
        threading.Thread(target=kill_when_started).start()
        with pytest.raises(SlipmodeError, match=r"^scheduler: the connection is lost"):
            run_study(path, tmp_path, scheduler=address)
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()
    kept = np.count_nonzero(open_results(tmp_path / "study.zarr")["status"].values)
    assert 0 < kept < 600
    done = run_study(path, tmp_path, workers=1)
    assert (done.found, done.failed) == (kept, 0)


@pytest.mark.slow
def test_a_recording_that_cannot_be_written_is_written_by_the_next_run(
    study_file, tmp_path, scheduler, caplog
):
    path = study_file(FORCES + "[outputs]\nsteady = true\nrecording = true\n")
    # Folders take the places of layout files. Tasks have five samples, the last one has one.
    folders = [tmp_path / "study" / f"sample-00000{k}.foxglove.json" for k in (0, 5)]
    for folder in folders:
        folder.mkdir(parents=True)
    with pytest.raises(SlipmodeError, match=r"^6 samples have no results: .*; repeat the command"):
        run_study(path, tmp_path, scheduler=scheduler)
    shutil.rmtree(folders[0])
    done = run_study(path, tmp_path, scheduler=scheduler)
    np.testing.assert_array_equal(done.dataset()["status"].values, [1, 1, 1, 1, 1, 0])
    assert "1 samples have no results: " in caplog.text
    shutil.rmtree(folders[1])
    done = run_study(path, tmp_path, scheduler=scheduler)
    assert (done.found, done.failed) == (5, 0)
    assert (done.dataset()["status"].values == 1).all()


def test_results_of_another_study_are_left_alone(study_file, tmp_path, scheduler):
    steady = "[outputs]\nsteady = true\n"
    run_study(study_file(FORCES + steady), tmp_path, scheduler=scheduler)
    path = study_file(FORCES.replace("0.1,", "0.11,") + steady)
    with pytest.raises(SlipmodeError, match=r"study\.zarr: has results of another study"):
        run_study(path, tmp_path, scheduler=scheduler)
    (tmp_path / "other" / "study.zarr").mkdir(parents=True)
    with pytest.raises(SlipmodeError, match=r"study\.zarr: has no results of a study"):
        run_study(path, tmp_path / "other", scheduler=scheduler)
