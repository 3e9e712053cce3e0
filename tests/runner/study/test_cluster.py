"""Processes that work on a study: some are killed, or all of it, and it comes to the same."""

import os
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from slipmode.rom import SlipmodeError
from slipmode.runner import open_results, run_study
from slipmode.runner.study import study as of_study
from slipmode.runner.study.design import Design, make_design
from slipmode.runner.study.results import Results
from slipmode.runner.study.sample_outputs import Batch, Outputs
from slipmode.runner.study.scene_model import Samples
from slipmode.runner.study.study_file import load_study
from slipmode.runner.study.workers import cluster
from slipmode.runner.study.workers.foreman import Foreman, make_tasks

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


@pytest.mark.skipif(sys.platform == "win32", reason="each worker imports it by itself")
def test_workers_are_copies_of_a_process_that_has_what_they_need_and_no_more():
    cluster.prepare_workers()
    with cluster.cluster(2, None) as client:
        found = client.run(lambda: (os.getppid(), sorted(sys.modules))).values()
    parents, modules = zip(*found, strict=True)
    assert len(set(parents)) == 1
    assert parents[0] != os.getpid()
    for loaded in map(set, modules):
        assert "slipmode.runner.study.workers.foreman" in loaded
        assert not loaded & {"pandas", "zarr", "xarray", "matplotlib", "rerun", "scipy.stats"}


def test_workers_have_the_settings_of_a_study():
    with cluster.cluster(1, None) as client:
        (found,) = client.run(_settings).values()
    assert found == cluster.SETTINGS


def _settings():
    from dask import config

    return {name: config.get(name) for name in cluster.SETTINGS}


class NoWork:
    """A client whose futures are finished at once; samples need a table above `outside` others."""

    class Future:
        status = "finished"

        def __init__(self, key, value):
            self.key, self._value = key, value

        def result(self):
            return self._value

    def __init__(self, outside=0):
        self.loop, self.tasks, self.steps, self.outside = None, 0, 0, outside

    def nthreads(self):
        return {"a": 1, "b": 1}

    def submit(self, _noted, function, *arguments, pure):
        if function.__name__ == "model":
            self.steps += 1
            return self.Future("model", arguments[1])
        if function.__name__ != "_compute":
            return arguments
        self.tasks += 1
        (samples, _), model, _, numbers = arguments
        batch = Batch.empty(samples.outputs, samples.modes, numbers.size)
        batch.outside[:] = model.result() < self.outside
        return self.Future(self.tasks, SimpleNamespace(value=(batch, True), warnings=()))


class Completed:
    """The waiting room of NoWork."""

    waiting, most = [], 0

    def __init__(self, loop):
        pass

    def add(self, future):
        self.waiting.append(future)
        Completed.most = max(Completed.most, len(self.waiting))

    def __next__(self):
        return self.waiting.pop()


def without_cluster(monkeypatch, tmp_path, count):
    """Samples of a study whose tasks are taken as `Completed` has them."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(distributed, "as_completed", Completed)
    content = {"forcing": {"A": {"amplitude": 1.0}}}
    samples = Samples(content, tmp_path, ("A",), Outputs(steady=True))
    return samples, Design(("forcing.A.phase",), (np.linspace(0.0, 1.0, count),))


def test_only_some_tasks_are_out_however_many_there_are(monkeypatch, tmp_path):
    samples, design = without_cluster(monkeypatch, tmp_path, 50_000)
    client, tasks = NoWork(), make_tasks(samples, design)
    finished = [task for task, _ in Foreman(client, samples, design).work_on(tasks)]
    assert client.tasks == len(finished) == 100
    assert Completed.most <= 6
    assert sorted((t.start, t.stop) for t in finished)[-1] == (49_500, 50_000)


def test_samples_outside_a_table_are_computed_on_the_next_one(monkeypatch, tmp_path):
    samples, design = without_cluster(monkeypatch, tmp_path, 10_000)
    client, tasks = NoWork(outside=2), make_tasks(samples, design)
    finished = [batch for _, batch in Foreman(client, samples, design).work_on(tasks)]
    assert (len(finished), client.steps) == (20, 3)
    assert not any(batch.outside.any() for batch in finished)
    assert client.tasks == 3 * 20


def test_neighbours_are_written_at_once_and_nothing_is_left(study_file, tmp_path, monkeypatch):
    pytest.importorskip("zarr")
    study = load_study(study_file(PEAKS))
    design = make_design(study)
    samples = Samples(study.content, study.folder, tuple(study.scene.modes.numbers), study.outputs)
    results = Results(tmp_path / "study.zarr", study, design)
    written, write = [], Results._write

    def counted(self, row):
        written.append([task.start for task, _ in row])
        write(self, row)

    monkeypatch.setattr(Results, "_write", counted)
    tasks = [task for task in make_tasks(samples, design) if task.start != 250]
    for task in reversed(tasks):
        batch = Batch.empty(samples.outputs, samples.modes, task.stop - task.start)
        batch.values["peak"][:, 0] = np.arange(task.start, task.stop)
        batch.reason[0] = "none" if task.start == 500 else ""
        results.write(task, batch)
    results.flush()
    assert written == [list(range(0, 250, 50)), list(range(300, 600, 50))]
    data = open_results(tmp_path / "study.zarr").load()
    found = data["status"].values
    assert (found[250:300] == 0).all() and found[500] == 2 and data["reason"][500] == "none"
    kept = found == 1
    assert np.count_nonzero(kept) == 549
    np.testing.assert_array_equal(data["peak"].values[kept, 0], np.flatnonzero(kept))
    results.flush()
    assert len(written) == 2


@pytest.mark.slow
def test_a_killed_worker_loses_nothing(study_file, tmp_path, monkeypatch):
    path = study_file(PEAKS)
    whole = run_study(path, tmp_path / "whole", workers=1).dataset().load()
    killed = []

    class Murderous(Foreman):
        def work_on(self, tasks):
            victim = next(iter(self._client.run(os.getpid).values()))
            for done in super().work_on(tasks):
                if not killed:
                    killed.append(victim)
                    os.kill(victim, signal.SIGKILL)
                yield done

    monkeypatch.setattr(of_study, "Foreman", Murderous)
    done = run_study(path, tmp_path, workers=2)
    assert (len(killed), done.failed) == (1, 0)
    assert done.dataset().load().identical(whole)


@pytest.mark.slow
def test_a_study_that_is_killed_goes_on(study_file, tmp_path):
    path = study_file(PEAKS)
    code = "import sys; from slipmode.runner.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "study", path, "-o", tmp_path, "--workers", "1"]
    running = subprocess.Popen(command, start_new_session=True, stderr=subprocess.DEVNULL)
    results = tmp_path / "study.zarr"
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline and running.poll() is None:
        if results.exists() and (open_results(results)["status"].values > 0).any():
            break
        time.sleep(0.01)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    before = open_results(results).load()
    kept = before["status"].values > 0
    assert 0 < np.count_nonzero(kept) < 600
    done = run_study(path, tmp_path, workers=2)
    assert done.found == np.count_nonzero(kept)
    after = done.dataset().load()
    assert (after["status"].values == 1).all()
    np.testing.assert_array_equal(after["peak"][kept], before["peak"][kept])


@pytest.mark.slow
def test_a_scheduler_that_is_lost_is_said_and_what_was_computed_stays(
    study_file, tmp_path, monkeypatch
):
    path, found = study_file(PEAKS), tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    file = ["--scheduler-file", str(found)]
    scheduler = subprocess.Popen(
        [*dask, "scheduler", *file, "--port", "0", "--dashboard-address", ":0"],
        stderr=subprocess.DEVNULL,
    )
    worker = subprocess.Popen(
        [*dask, "worker", *file, "--nthreads", "1", "--no-nanny", "--no-dashboard"],
        stderr=subprocess.DEVNULL,
    )

    class Murderous(Foreman):
        def work_on(self, tasks):
            for done in super().work_on(tasks):
                yield done
                scheduler.kill()
                scheduler.wait()

    try:
        distributed = pytest.importorskip("distributed")
        with distributed.Client(scheduler_file=str(found), timeout=60) as client:
            client.wait_for_workers(1, timeout=60)
            address = client.scheduler.address
        with monkeypatch.context() as patched:
            patched.setattr(of_study, "Foreman", Murderous)
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


def test_workers_that_are_still_connecting_are_waited_for(monkeypatch, caplog):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=0, processes=False, dashboard_address=":0", silence_logs=40
    ) as local:
        address = local.scheduler_address
        monkeypatch.setattr(cluster, "_ANSWERS", 0.5)
        refused = rf"^scheduler: {address} has no workers; start one with `dask worker {address}`$"
        with pytest.raises(SlipmodeError, match=refused), cluster.cluster(None, address):
            pass
        monkeypatch.setattr(cluster, "_ANSWERS", 60.0)
        caplog.clear()
        late = threading.Timer(0.5, local.scale, [1])
        late.start()
        with cluster.cluster(None, address) as client:
            assert len(client.nthreads()) == 1
        late.join()
        assert caplog.messages == [f"waiting 60 s for workers at {address}"]
