"""A part of a recording replayed, and how it is played."""

import re
import subprocess
import time

import numpy as np
import pytest
from recordings import COUNT, STEP, samples, write
from rrd import RERUN, verified

from slipmode.__main__ import main
from slipmode.runner import read
from slipmode.runner.recording.load import Selection


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return write(tmp_path_factory.mktemp("whole") / "run.mcap")


def contents(path):
    """What `rerun` prints of an .rrd file."""
    print_it = [RERUN, "rrd", "print", "-vvv", path]
    return subprocess.run(print_it, capture_output=True, check=True, text=True).stdout


@pytest.mark.parametrize(
    ("start", "end", "first", "last"),
    [
        (1000.0, 2000.0, 4000, 8000),
        (-np.inf, 100.0, 0, 400),
        (4000.1, np.inf, 16001, COUNT - 1),
        (7.5, 7.5, 30, 30),
    ],
)
def test_samples_between_two_times_ends_included(whole, start, end, first, last):
    part = Selection(start=start, end=end).of(read(whole))
    for topic, (time_, values) in samples().items():
        np.testing.assert_array_equal(part.channels[topic].time, time_[first : last + 1])
        np.testing.assert_array_equal(part.channels[topic].values, values[first : last + 1])
    assert len(part.events) == (first == 0)
    assert part.end_time == last * STEP


def test_only_the_chosen_channels_are_shown(whole, tmp_path, capsys):
    out = tmp_path / "part.rrd"
    assert main(["replay", str(whole), "--topics", "/contact/0", "--save", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\nnext:  rerun {out}\n"
    assert verified(out)
    found = contents(out)
    assert "/contact/0/friction_force" in found
    assert "/modes" not in found
    assert list(Selection(["/modes"]).of(read(whole)).channels) == ["/modes"]


def test_topics_with_commas_or_spaces(whole, tmp_path):
    for words in (["/modes,/contact/0"], ["/modes", "/contact/0"]):
        out = tmp_path / "part.npz"
        assert main(["export", str(whole), "-o", str(out), "--topics", *words]) == 0
        with np.load(out) as arrays:
            assert {"/modes.time", "/contact/0.time"} <= set(arrays)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--start", "5", "--end", "3"], "--start 5 s: must not be after end = 3 s"),
        (["--start", "nan"], "--start nan s: must not be after"),
        (
            ["--start", "6000"],
            "run.mcap: there are no samples from 6000 to inf s; .* ends at 4999.75 s",
        ),
        (
            ["--topics", "/mode,/modes"],
            "run.mcap: /mode: no such channel; the recording has /",
        ),
        (["--speed", "0"], "speed must be > 0 and finite, got 0"),
        (["--speed", "inf"], "speed must be > 0 and finite, got inf"),
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


def test_without_a_window_there_must_be_something_to_write(whole, capsys):
    assert main(["replay", str(whole), "--headless"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "give --save or --screenshot" in line


def test_a_replay_without_a_display_says_what_to_do(whole, capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    assert main(["replay", str(whole)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "the viewer does not start here" in line
    assert "--save and --screenshot need no window" in line


@pytest.mark.parametrize("loop", [pytest.param(False, marks=pytest.mark.slow), True])
def test_the_viewer_plays_at_the_speed_asked_for(whole, tmp_path, viewer, loop):
    """Without a window a frame is 0.1 s of the viewer's time, however long the machine takes.

    So the frames tell the speed; a busy machine reads some of them twice and others never.
    """
    frame = 0.1 * 200.0
    out = tmp_path / "part.rrd"
    options = ["--speed", "200", *(["--loop"] if loop else []), "--start", "100", "--end", "300"]
    assert main(["replay", str(whole), *options, "--save", str(out)]) == 0
    viewer.open(str(out))
    shown = []  # (time of the machine, time in the recording)
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline and not _told(shown, frame, loop):
        for recording in viewer.get_state().recordings:
            if recording.current_time is not None:
                shown.append((time.monotonic(), recording.current_time / 1e9))
    times = np.array(shown)[:, 1]
    frames = (times - 100.0) / frame
    np.testing.assert_allclose(frames, np.round(frames), atol=1e-6)
    assert _told(shown, frame, loop)
    assert (np.diff(times).min() < 0.0) == loop


def _told(shown, frame, loop):
    """Whether enough is known: all frames, and the first again; or the last one for a second."""
    if not loop:
        at_end = [at for at, time_ in shown if time_ == 300.0]
        return len(at_end) > 1 and at_end[-1] - at_end[0] > 1.0
    times = [time_ for _, time_ in shown]
    again = len(times) > 1 and min(np.diff(times)) < 0.0
    return again and {round((t - 100.0) / frame) for t in times} >= set(range(1, 11))
