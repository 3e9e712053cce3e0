"""Results on disk: a Zarr group that xarray reads as a Dataset, filled batch by batch."""

from __future__ import annotations

import shutil
import time
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipmode.rom import __version__
from slipmode.rom.arrays import Flags
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.storage.files import PART
from slipmode.runner.study.design import Design
from slipmode.runner.study.sample_outputs import Batch
from slipmode.runner.study.scene_keys import declared
from slipmode.runner.study.study_file import Study
from slipmode.runner.study.workers.foreman import AT_ONCE

DONE, FAILED = 1, 2  # status of a sample; 0: not computed yet
_EVERY = 1.0  # [s] between writings: a machine that stops loses results of about a second


class Results:
    """The results of a study on disk; results that were written stay, whatever happens.

    The Zarr group at `path` is made if missing, and continued if it is of the same study. Raises
    SlipmodeError if it holds something else, or cannot be written.
    """

    def __init__(self, path: Path, study: Study, design: Design) -> None:
        self._path = path
        zarr = extra("zarr", "study")
        digest = None
        with self._writing():
            if not path.exists():
                _create(zarr, path, study, design)
            with suppress(FileNotFoundError, ValueError):
                group = zarr.open_group(path, mode="r+")
                digest = group.attrs.get("study_digest")
        if digest is None:
            raise SlipmodeError(f"{path}: has no results of a study; give another --output")
        if digest != study.digest:
            raise SlipmodeError(
                f"{path}: has results of another study, or of other values, files or code; "
                "give another --output, or remove it"
            )
        self._arrays = dict(group.arrays())  # group[name] would open the array each time
        self._status = self._arrays["status"][:]
        self._waiting: list[tuple[NDArray[np.intp], Batch]] = []
        self._flushed = time.monotonic()

    @property
    def missing(self) -> Flags:
        """(samples,): Whether a sample has no results, because it failed or was not computed."""
        return np.asarray(self._status != DONE)

    @property
    def done(self) -> int:
        """Number of samples with results."""
        return int(np.count_nonzero(self._status == DONE))

    @property
    def failed(self) -> int:
        """Number of samples that were computed without success."""
        return int(np.count_nonzero(self._status == FAILED))

    def write(self, numbers: NDArray[np.intp], batch: Batch) -> None:
        """Take a batch; it is on disk within a second if others follow, or after `flush`."""
        self._waiting.append((numbers, batch))
        if time.monotonic() > self._flushed + _EVERY:
            self.flush()

    def flush(self) -> None:
        """Write all batches at once: each writing costs some ms of any size."""
        waiting, self._waiting = self._waiting, []
        if waiting:
            numbers = np.concatenate([each for each, _ in waiting])
            batches = [batch for _, batch in waiting]
            reason = np.array([why for batch in batches for why in batch.reason], dtype=object)
            status = np.where(reason == "", DONE, FAILED).astype(np.int8)
            with self._writing():
                for name in batches[0].values:
                    values = np.concatenate([batch.values[name] for batch in batches])
                    self._arrays[name].oindex[numbers] = values
                if reason.any() or FAILED in self._status[numbers]:
                    self._arrays["reason"].oindex[numbers] = reason
                self._arrays["status"].oindex[numbers] = status  # marks the others as there
            self._status[numbers] = status
        self._flushed = time.monotonic()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise SlipmodeError(
                f"{self._path}: cannot be written: {error.strerror or error}; repeat the "
                "command to continue; the samples computed so far are kept"
            ) from error


def _create(zarr: Any, path: Path, study: Study, design: Design) -> None:
    """Create results without values; the group appears at its path when it is complete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(f".{path.name}{PART}")
    shutil.rmtree(unfinished, ignore_errors=True)
    group = zarr.create_group(unfinished)
    group.attrs.update(
        {
            "study_digest": study.digest,
            "title": study.title,
            "study": study.text,
            "scene": study.scene.text,
            "slipmode": __version__,
            "kg^1/2 m": "unit of modal amplitudes, x = 2 Re sum mode_shape a exp(i theta)",
        }
    )
    modes = tuple(study.scene.modes.numbers)
    results = study.outputs.results(modes)
    rows, largest = design.samples, max((8 * prod(r.shape) for r in results), default=8)
    # at most 1 MiB: a chunk that is not full is written anew each time
    chunk = min(rows, 8 * AT_ONCE, max(2**20 // largest, 1))

    def add(name: str, sizes: Mapping[str, int], dtype: Any, fill: Any, **words: str) -> Any:
        array = group.create_array(
            name,
            shape=tuple(sizes.values()),
            chunks=tuple(chunk if dim == "sample" else size for dim, size in sizes.items()),
            dimension_names=list(sizes),
            dtype=dtype,
            fill_value=fill,
        )
        array.attrs.update(words)
        return array

    units, outputs, sample = study.scene.units, study.outputs, {"sample": rows}
    coordinates = {"mode": np.array(modes, dtype=object), "dof": np.array(outputs.dofs)}
    coordinates["time"] = np.array(outputs.times)
    if outputs.curve:
        coordinates["frequency"] = units.of_frequency(outputs.curve.frequency)
    for name, values in coordinates.items():
        if values.size:
            dtype = str if values.dtype == object else values.dtype
            add(name, {name: values.size}, dtype, None)[:] = values
    for key, values in zip(design.keys, design.columns, strict=True):
        dtype, unit = values.dtype, declared(key).unit
        if dtype.kind == "O":
            dtype, values = str, np.array([str(value) for value in values], dtype=object)
        unit = units.frequency if unit == "rad/s" else unit
        add(key, sample, dtype, None, units=unit)[:] = values
    for result in results:
        words = {"units": result.unit, "long_name": result.meaning}
        add(result.name, sample | result.sizes, float, np.nan, **words)
    numbers = "0: not computed yet, 1: computed, 2: failed, see reason"
    add("status", sample, "int8", 0, long_name=numbers)
    add("reason", sample, str, None, long_name="why it failed")
    group.attrs["coordinates"] = " ".join(design.keys)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that other programs may not read consolidated metadata
        zarr.consolidate_metadata(unfinished)
    unfinished.rename(path)


def open_results(path: Path) -> Any:
    """Return the results of a study as an xarray Dataset, read when values are needed.

    Parameters
    ----------
    path : Path
        The .zarr folder that `run_study` wrote.
    """
    return extra("xarray", "study").open_zarr(path)
