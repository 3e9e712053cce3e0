"""Recordings whose writer is killed, or runs out of disk: what is lost is bounded."""

import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from endless_recording import rows
from recordings import CHANNELS, HEADER, McapSink

from slipmode.runner import doctor, load, recover

CHUNK_BYTES, FLUSH_SECONDS = 1024 * 1024, 1.0  # what a kill may cost, as the guide says
SCRIPT = Path(__file__).parents[2] / "support" / "endless_recording.py"
RECORD_BYTES = 31 + 27  # of a contact sample: the prefix of its record, and three tagged doubles
FAST, SLOW = (2000, 0.005), (10, 0.002)  # rows at once and pause [s]


def killed(folder, seed, batch, pause):
    """A recording whose writer was killed at a random moment, and how many rows it had taken."""
    path, counts = folder / "run.mcap", folder / "counts"
    command = [sys.executable, SCRIPT, path, counts, str(batch), str(pause)]
    lasting = np.random.default_rng(seed).uniform(0.0, 1.5 * FLUSH_SECONDS)
    with subprocess.Popen(command) as writing:
        try:
            deadline = time.monotonic() + 60.0
            while taken(counts) == 0:
                assert time.monotonic() < deadline
                time.sleep(0.01)
            time.sleep(lasting)
        finally:
            writing.kill()
    return path, taken(counts), lasting


def taken(counts):
    """How many rows the writer has handed over; the file is there before its content is."""
    written = counts.read_bytes() if counts.exists() else b""
    return int.from_bytes(written, "little")


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 54))]
)
def test_a_kill_costs_no_more_than_a_chunk_or_a_second(tmp_path, seed):
    batch, pause = (FAST, SLOW)[seed % 2]
    path, handed, lasting = killed(tmp_path, seed, batch, pause)
    before = path.read_bytes()
    found = recover(path, tmp_path / "whole.mcap")
    assert path.read_bytes() == before
    assert doctor(tmp_path / "whole.mcap") == []
    signals = load(tmp_path / "whole.mcap")["/contact/0"]
    time_, values = rows(0, found.kept)
    np.testing.assert_array_equal(signals.time, np.rint(time_ * 1e9) / 1e9)
    np.testing.assert_array_equal(signals.values, values)
    missing = handed - found.kept
    assert missing * RECORD_BYTES <= CHUNK_BYTES + batch * RECORD_BYTES
    # A pause of the whole machine may fall between the last flush and the kill, hence the 2.
    assert batch == FAST[0] or missing <= 2 * FLUSH_SECONDS / pause * batch
    assert batch == FAST[0] or lasting < 1.2 * FLUSH_SECONDS or found.kept


def test_a_full_disk_costs_no_more_than_two_chunks(tmp_path):
    path = tmp_path / "run.mcap"
    sink = McapSink(path, HEADER, CHANNELS)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, hard))
    taken = 0
    try:
        with pytest.raises(OSError, match=str(path)):
            while taken < 10**7:
                sink.write("/contact/0", *rows(taken, 1000))
                taken += 1000
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    sink.close()
    found = recover(path, tmp_path / "whole.mcap")
    assert (taken - found.kept) * RECORD_BYTES <= 2 * CHUNK_BYTES
    assert found.kept > 0
    assert doctor(tmp_path / "whole.mcap") == []
