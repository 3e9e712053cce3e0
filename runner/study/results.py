"""Results on disk: a Zarr group that xarray reads as a Dataset, filled batch by batch."""

from __future__ import annotations

import shutil
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.rom import __version__
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.files import PART
from slipmode.runner.recording.channels import MODES
from slipmode.runner.study.design import Design
from slipmode.runner.study.outputs.batch import Batch
from slipmode.runner.study.scene_keys import unit
from slipmode.runner.study.study_file import Study
from slipmode.runner.study.tasks import AT_ONCE, Task

DONE, FAILED = 1, 2  # status of a sample; 0: not computed yet
_DIGEST = "study_digest"
_EVERY = 1.0  # [s] between writings: no more is lost with the machine, beside what is at work
_CHUNK, _CHUNK_BYTES = 8 * AT_ONCE, 2**20  # a chunk that is not full is written anew


class Results:
    """The results of a study; those there are stay, whatever happens.

    Parameters
    ----------
    path : Path
        Of the Zarr group: made if missing, gone on with if it is of the same study.
    study : Study
    design : Design

    Raises
    ------
    SlipmodeError
        If it holds something else, or cannot be written.
    """

    def __init__(self, path: Path, study: Study, design: Design) -> None:
        self._path = path
        zarr = extra("zarr", "study")
        with self._written():
            if not path.exists():
                self._make(zarr, study, design)
            try:
                group = zarr.open_group(path, mode="r+")
                digest = group.attrs.get(_DIGEST)
            except (FileNotFoundError, ValueError):
                digest = None
        if digest is None:
            raise SlipmodeError(f"{path}: holds no results of a study; give another --output")
        if digest != study.digest:
            raise SlipmodeError(
                f"{path}: holds results of another study, or of other values, files or version; "
                "give another --output, or remove it"
            )
        self._arrays = dict(group.arrays())  # to look one up by its name opens it anew
        self._status = self._arrays["status"][:]
        self._kept: list[tuple[Task, Batch]] = []
        self._flushed = time.monotonic()

    @property
    def done(self) -> int:
        """Samples that have been computed, failures among them."""
        return int(np.count_nonzero(self._status))

    @property
    def failed(self) -> int:
        """Samples without results."""
        return int(np.count_nonzero(self._status == FAILED))

    def has(self, task: Task) -> bool:
        """Whether all of a task is there."""
        return bool(self._status[task.start : task.stop].all())

    def write(self, task: Task, batch: Batch) -> None:
        """Keep a batch: on disk within a second while others come, or after `flush`."""
        self._kept.append((task, batch))
        if time.monotonic() > self._flushed + _EVERY:
            self.flush()

    def flush(self) -> None:
        """Write what is kept, neighbours at once: each writing costs some ms, whatever it has."""
        kept = sorted(self._kept, key=lambda pair: pair[0].start)
        self._kept.clear()
        while kept:
            row = [kept.pop(0)]
            while kept and kept[0][0].start == row[-1][0].stop:
                row.append(kept.pop(0))
            self._write(row)
        self._flushed = time.monotonic()

    def _write(self, row: Sequence[tuple[Task, Batch]]) -> None:
        """Batches that follow each other; status last, so that what is marked is there."""
        at = slice(row[0][0].start, row[-1][0].stop)
        batches = [batch for _, batch in row]
        reason = [why for batch in batches for why in batch.reason]
        status = np.where([bool(why) for why in reason], FAILED, DONE).astype(np.int8)
        with self._written():
            for name in batches[0].values:
                self._arrays[name][at] = np.concatenate([batch.values[name] for batch in batches])
            if any(reason):
                self._arrays["reason"][at] = np.array(reason, dtype=object)
            self._arrays["status"][at] = status
        self._status[at] = status

    @contextmanager
    def _written(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            reason = error.strerror or str(error)
            raise SlipmodeError(
                f"{self._path}: cannot be written: {reason}; what was computed stays, and the "
                "same command goes on from there"
            ) from error

    def _make(self, zarr: Any, study: Study, design: Design) -> None:
        """An empty one, which is there whole or not at all."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = self._path.with_name(f".{self._path.name}{PART}")
        shutil.rmtree(unfinished, ignore_errors=True)
        group = zarr.create_group(unfinished)
        group.attrs.update(
            {
                _DIGEST: study.digest,
                "title": study.title,
                "study": study.text,
                "scene": study.scene.text,
                "slipmode": __version__,
                "kg^1/2 m": "unit of modal amplitudes, x = 2 Re sum mode_shape a exp(i theta)",
            }
        )
        modes = MODES[: len(study.scene.modes.numbers)]
        asked = study.asked.results(modes)
        rows, largest = design.samples, max((8 * prod(r.shape) for r in asked), default=8)
        chunk = min(rows, _CHUNK, max(_CHUNK_BYTES // largest, 1))

        def add(name: str, dims: Sequence[str], shape: Sequence[int], **given: Any) -> Any:
            attributes = given.pop("attributes", {})
            chunks = tuple(chunk if dim == "sample" else size for dim, size in _sized(dims, shape))
            array = group.create_array(
                name, shape=tuple(shape), chunks=chunks, dimension_names=list(dims), **given
            )
            array.attrs.update(attributes)
            return array

        coordinates = {"mode": np.array(modes, dtype=object)}
        if study.asked.dofs:
            coordinates["dof"] = np.array(study.asked.dofs)
        if study.asked.times:
            coordinates["time"] = np.array(study.asked.times)
        if study.asked.curve:
            coordinates["frequency"] = study.scene.units.of_frequency(study.asked.curve.frequency)
        for name, values in coordinates.items():
            dtype = str if values.dtype == object else values.dtype
            add(name, [name], values.shape, dtype=dtype)[:] = values
        for key, column in zip(design.keys, design.columns, strict=True):
            dtype, values = column.dtype, column
            if column.dtype == object:
                dtype, values = str, np.array([str(value) for value in column], dtype=object)
            of_frequency = unit(key) == "rad/s"
            words = {"units": study.scene.units.frequency if of_frequency else unit(key)}
            add(key, ["sample"], [rows], dtype=dtype, attributes=words)[:] = values
        for result in asked:
            words = {"units": result.unit, "long_name": result.meaning}
            dims, shape = ["sample", *result.dims], [rows, *result.shape]
            add(result.name, dims, shape, dtype=float, fill_value=np.nan, attributes=words)
        meaning = {"long_name": "0: not computed yet, 1: computed, 2: failed, see reason"}
        add("status", ["sample"], [rows], dtype="int8", fill_value=0, attributes=meaning)
        add("reason", ["sample"], [rows], dtype=str, attributes={"long_name": "why it failed"})
        group.attrs["coordinates"] = " ".join(design.keys)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that other programs may not read it at once
            zarr.consolidate_metadata(unfinished)
        unfinished.rename(self._path)


def open_results(path: Path) -> Any:
    """The results as an xarray Dataset, read when they are looked at."""
    return extra("xarray", "study").open_zarr(path)


def _sized(dims: Sequence[str], shape: Sequence[int]) -> list[tuple[str, int]]:
    return list(zip(dims, shape, strict=True))
