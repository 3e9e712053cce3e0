"""Recordings read back, whole and damaged, and replayed in whole or in part."""

import re
import subprocess

import numpy as np
import pytest
from recordings import COUNT, HEADER, damaged, samples, write
from rrd import RERUN, verified

from slipmode.__main__ import main
from slipmode.rom import SlipmodeError
from slipmode.runner import read, replay


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return write(tmp_path_factory.mktemp("whole") / "run.mcap")


def contents(path):
    """What `rerun` prints of an .rrd file."""
    print_it = [RERUN, "rrd", "print", "-vvv", path]
    return subprocess.run(print_it, capture_output=True, check=True, text=True).stdout


def test_what_was_written_is_read(whole):
    data = read(whole)
    assert data.complete and data.damage == ""
    assert data.header == HEADER
    for topic, (time_, values) in samples().items():
        np.testing.assert_array_equal(data.channels[topic].time, time_)
        np.testing.assert_array_equal(data.channels[topic].values, values)
    assert [(e.time, e.level, e.message) for e in data.events] == [(0.0, "info", "started")]


def test_a_truncated_recording_is_replayed_with_a_warning_in_it(tmp_path):
    whole = write(tmp_path / "run.mcap", 1000)
    replay(damaged(whole, tmp_path, lambda data: data[:-100]), save=tmp_path / "cut.rrd")
    assert verified(tmp_path / "cut.rrd")
    assert "cut short" in contents(tmp_path / "cut.rrd")


@pytest.mark.parametrize(
    ("start", "end", "first", "last"),
    [
        *(("7.5", "7.5", 30, 30), ("4000.1", "inf", 16001, COUNT - 1)),
        pytest.param("1000", "2000", 4000, 8000, marks=pytest.mark.slow),
    ],
)
def test_a_part_has_the_samples_between_two_times_ends_included(
    whole, tmp_path, start, end, first, last
):
    out = tmp_path / "part.rrd"
    part = ["--start", start, "--end", end, "--topics", "/contact/0"]
    assert main(["replay", str(whole), *part, "--save", str(out)]) == 0
    assert verified(out)
    shown = contents(out)
    assert "/contact/0/friction_force" in shown and "/modes" not in shown
    force = samples()["/contact/0"][1][:, 2]
    for row, there in ((first, True), (last, True), (first - 1, False)):
        assert (f"{force[row]}" in shown) == there
    assert last == COUNT - 1 or f"{force[last + 1]}" not in shown


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--start", "5", "--end", "3"], "--start 5 s: must not be after end = 3 s"),
        (["--start", "6000"], "there are no samples from 6000 to inf s; .* ends at 4999.75 s"),
        (["--topics", "/mode,/modes"], "/mode: no such channel; the recording has /"),
        (["--speed", "0"], "speed must be > 0 and finite, got 0"),
    ],
)
def test_parts_that_are_not_there_are_refused_in_one_line(
    whole, tmp_path, capsys, options, complaint
):
    out = tmp_path / "part.rrd"
    assert main(["replay", str(whole), *options, "--save", str(out)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(complaint, line)
    assert not out.exists()


@pytest.mark.slow
def test_a_replay_without_a_display_says_what_to_do(whole, capsys, monkeypatch, tmp_path):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    assert main(["replay", str(whole)]) == 1
    assert "--save and --screenshot need no window" in capsys.readouterr().err
    assert main(["replay", str(whole), "--headless"]) == 1
    assert "give --save or --screenshot" in capsys.readouterr().err
    for name in ("VK_ICD_FILENAMES", "VK_DRIVER_FILES", "LIBGL_DRIVERS_PATH"):
        monkeypatch.setenv(name, str(tmp_path / "none.json"))
    with pytest.raises(SlipmodeError, match=r"apt-get install .*mesa-vulkan-drivers"):
        replay(whole, screenshot=tmp_path / "views.png")
    assert not (tmp_path / "views.png").exists()
