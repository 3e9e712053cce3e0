"""Memory of writers of long recordings, and of readers of small ones that unpack to gigabytes."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from damage.bombs import bombs
from recordings import CHANNELS, rewritten

from slipmode.rom import SlipmodeError
from slipmode.runner import DamagedRecordingWarning, doctor, info, load

SCRIPT = Path(__file__).parents[2] / "support" / "damage" / "reader_memory.py"
BOMBS = bombs(CHANNELS[0].encode(np.ones((1, 6)))[0].tobytes())
# Measured: 204 MiB at most, by 48 MiB of the shortest messages in `recover`.
LIMIT = 256  # [MiB]
LONG = """
import resource, sys
from slipmode.runner import load_scene, parse_scene, run

end = 30_000.0
text = load_scene("one-mode").text
text = text[: text.index("[[contact]]")].replace("duration = ", "duration = 30000.0 # ")
text += f"[[contact]]\\nwindow = [0.0, {end}]\\nsamples_per_period = 256\\n"
run("one-mode", sys.argv[1])  # what a run takes anyway
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
recording = run(parse_scene(text, "."), sys.argv[1])
print(recording.samples, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""


def written(folder, name, units=True):
    """A recording of slipmode, or of another program, with a bomb in it."""
    sound = rewritten(folder / "sound.mcap", units=units).read_bytes()
    path = folder / f"{name}.mcap"
    path.write_bytes(BOMBS[name](bytearray(sound)))
    return path


def memory(folder, paths):
    """Memory of each command on each file, as far as it exceeds all before [MiB]."""
    sound = rewritten(folder / "sound.mcap")
    command = [sys.executable, SCRIPT, sound, *paths]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(line.split("\t") for line in done.stdout.splitlines())


def test_no_command_unpacks_gigabytes(tmp_path):
    names = ("zstd, 8 GB", "zstd, 8 GB, says nothing", "lz4, 1 GB, says nothing")
    paths = [written(tmp_path, name) for name in names]
    found = memory(tmp_path, paths)
    assert len(found) == 5 * len(paths)
    assert all(float(size) < 32 for size in found.values()), found  # 12 for a file of 4 MB


@pytest.mark.slow
@pytest.mark.parametrize("units", [True, False])
@pytest.mark.parametrize("name", BOMBS)
def test_no_command_takes_more_than_the_limit(tmp_path, name, units):
    found = memory(tmp_path, [written(tmp_path, name, units)])
    assert len(found) == 5
    assert all(float(size) < LIMIT for size in found.values()), found


def test_the_rest_of_a_recording_with_a_bomb_is_read(tmp_path):
    path = written(tmp_path, "zstd, 8 GB")
    words = "a chunk unpacks to 8192 MiB, more than the 51 MiB that the limit of memory allows"
    assert words in info(path).damage
    assert any(words in line for line in doctor(path))
    with pytest.warns(DamagedRecordingWarning, match=words):
        np.testing.assert_array_equal(load(path)["/modes"].values, np.ones((50, 6)))


def test_more_samples_than_memory_are_refused_with_what_to_do(tmp_path, monkeypatch):
    path = rewritten(tmp_path / "sound.mcap")
    path.write_bytes(BOMBS["samples in chunks"](bytearray(path.read_bytes())))
    monkeypatch.setenv("SLIPMODE_MEMORY_MIB", "16")
    with pytest.raises(SlipmodeError, match=r"sound\.mcap: needs more than 16 MiB of memory"):
        load(path)
    monkeypatch.setenv("SLIPMODE_MEMORY_MIB", "64")
    with pytest.warns(DamagedRecordingWarning):
        assert load(path)["/modes"].time.size > 100_000


@pytest.mark.slow
def test_a_million_contact_samples_in_bounded_memory(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", LONG, tmp_path], capture_output=True, text=True, check=True
    )
    samples, mebibytes = map(float, done.stdout.split()[-2:])
    assert samples > 1e6
    assert mebibytes < 200.0  # two contacts with three doubles a sample would be 70 MiB
