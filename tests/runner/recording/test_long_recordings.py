"""Recordings of millions of samples: bounded memory, and views that show their extremes."""

import subprocess
import sys

import numpy as np
import pytest

from slipmode.runner.view.samples import Envelope


@pytest.mark.parametrize("batches", [[40_000], [1] * 100 + [3999] * 10, [64, 7, 1000] * 40])
def test_extremes_stand_for_the_samples_of_a_long_series(batches):
    count = sum(batches)
    time = np.arange(count)
    values = np.random.default_rng(1).normal(size=(count, 3))
    envelope = Envelope(dense=1024)
    ends = np.cumsum(batches)
    kept = [
        envelope.extend(time[end - size : end], values[end - size : end])
        for size, end in zip(batches, ends, strict=True)
    ]
    kept.append(envelope.rest())
    times, rows = (np.concatenate(part) for part in zip(*kept, strict=True))
    assert envelope.thinned
    np.testing.assert_array_equal(rows[:1024], values[:1024])
    assert len(rows) <= 1024 * (1 + np.log2(count / 1024) / 2 + 0.5)
    assert np.all(np.diff(times) > 0)
    for start, width in [(1024, 4), (2048, 8), (4096, 16), (8192, 32)]:
        first = np.searchsorted(times, start)
        group = values[start : start + width]
        np.testing.assert_array_equal(rows[first], group.min(axis=0))
        np.testing.assert_array_equal(rows[first + 1], group.max(axis=0))
    np.testing.assert_array_equal(rows.max(axis=0), values.max(axis=0))
    np.testing.assert_array_equal(rows.min(axis=0), values.min(axis=0))


def test_a_short_series_passes_as_it_is():
    envelope = Envelope(dense=1024)
    time, values = np.arange(1024), np.ones((1024, 2))
    assert envelope.extend(time, values)[1].shape == (1024, 2)
    assert not envelope.thinned
    assert envelope.rest() is None


_TEN_MILLION = """
import resource, sys
import numpy as np
from pathlib import Path
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Header, McapSink, Recorder
from slipmode.runner.view.rerun_sink import RerunSink

folder, count = Path(sys.argv[1]), int(sys.argv[2])
listed = [channels.contact(0), channels.contact(1)]
header = Header("long", "")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
kinds = {"mcap": McapSink, "rrd": RerunSink}
sinks = [kind(folder / f"long.{end}", header, listed) for end, kind in kinds.items()]
with Recorder(sinks) as recorder:
    for start in range(0, count // 2, 16384):
        time = 0.01 * np.arange(start, min(start + 16384, count // 2))
        values = np.column_stack([np.sin(time), np.cos(time), np.sign(np.cos(time))])
        for channel in listed:
            recorder.write(channel.topic, time, values)
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print((after - before) / 1024)
"""


@pytest.mark.slow
def test_ten_million_contact_samples_in_bounded_memory(tmp_path):
    command = [sys.executable, "-c", _TEN_MILLION, tmp_path, "10000000"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert float(done.stdout) < 500.0  # [MiB]
    assert (tmp_path / "long.rrd").stat().st_size < 150e6
