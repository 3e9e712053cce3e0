"""A study from its file to its results."""

from __future__ import annotations

import logging
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom.arrays import check_count
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.progress import progress_bar
from slipmode.rom.short_repr import frozen
from slipmode.runner.study.design import Design, make_design
from slipmode.runner.study.results import Results, open_results
from slipmode.runner.study.scene_model import Samples
from slipmode.runner.study.study_file import Study, load_study
from slipmode.runner.study.workers.cluster import dask_workers
from slipmode.runner.study.workers.foreman import Foreman, make_tasks
from slipmode.runner.study.workers.processes import processes

_log = logging.getLogger("slipmode.study")


@frozen
class StudyResults:
    """Hold the results of a study.

    Attributes
    ----------
    study : Study
        Study with its scene and its varied keys.
    path : Path
        Zarr group of the results.
    samples, found, failed : int
        Number of all samples, of samples with results from an earlier run, and of samples that
        failed.
    """

    study: Study
    path: Path
    samples: int
    found: int
    failed: int

    def dataset(self) -> Any:
        """Return the results as an xarray Dataset.

        Returns
        -------
        Dataset
            Variables over the dimension "sample", which are read when their values are needed.
        """
        return open_results(self.path)


def run_study(
    path: str | PathLike[str],
    output: str | PathLike[str] = "logs",
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool = False,
) -> StudyResults:
    """Compute all samples of a study that have no results yet, or failed in an earlier run.

    Parameters
    ----------
    path : path
        TOML file of the study.
    output : path, default "logs"
        Folder for the results <study>.zarr, and for recordings in <study>/.
    workers : int, optional
        Number of processes on this machine. Default: one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers compute the samples. They read the files of the
        scene at equal paths. Default: processes on this machine.
    progress : bool, default False
        Show the number of samples with results, and the remaining time.

    Returns
    -------
    StudyResults
        Results of this run and of earlier runs.

    Raises
    ------
    SlipmodeError
        If the study or its scene is refused, the scheduler does not answer, the folder contains
        something else or cannot be written, or no sample has results because workers or the disk
        failed. Samples that were computed are kept.

    Notes
    -----
    New Python processes compute the samples. A script therefore needs to call this function below
    ``if __name__ == "__main__":``.
    """
    if workers is not None:
        check_count("workers", workers)
    study = load_study(path)
    folder = Path(output)
    design = make_design(study)
    recordings = (folder / study.name).resolve() if study.outputs.recording else None
    modes = tuple(study.scene.modes.numbers)
    samples = Samples(study.content, study.folder, modes, study.outputs, recordings)
    _refuse_hopeless(samples, design)
    path_of_results = folder / f"{study.name}.zarr"
    results = Results(path_of_results, study, design)
    found = results.done
    if found < design.samples:
        if recordings is not None:
            recordings.mkdir(parents=True, exist_ok=True)
        tasks = make_tasks(samples, design, results.missing)
        with (
            processes(workers) if scheduler is None else dask_workers(scheduler) as team,
            progress_bar(
                desc=study.name,
                total=design.samples,
                initial=found,
                unit=" samples",
                shown=progress,
            ) as bar,
        ):
            foreman = Foreman(team, samples, design)
            try:
                for numbers, batch in foreman.work_on(tasks):
                    results.write(numbers, batch)
                    bar.update(numbers.size)
            finally:
                results.flush()
        for line, count in foreman.warnings:
            more = f" ({count} samples have such a warning; this is the first)"
            _log.warning("%s", line + more if count > 1 else line)
        if foreman.lost:
            lost = design.samples - results.done - results.failed
            words = f"{lost} samples have no results: {foreman.lost}"
            words += "; repeat the command to compute them"
            if not results.done:
                raise SlipmodeError(words)
            _log.warning("%s", words)
    return StudyResults(study, path_of_results, design.samples, found, results.failed)


def _refuse_hopeless(samples: Samples, design: Design) -> None:
    """Refuse a study if its first, middle and last scene are all refused."""
    last = design.samples - 1
    for place in (0, last // 2, last):
        (found,) = samples.scenes(design.part(np.array([place])))
        if not isinstance(found, str):
            return
    raise SlipmodeError(found)
