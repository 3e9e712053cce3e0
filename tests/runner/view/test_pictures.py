"""What the views of a replay look like, by a viewer without a window: none of them is empty."""

import re
import time
from io import BytesIO

import matplotlib.image
import numpy as np
import pytest

from slipmode.__main__ import main
from slipmode.runner import replay, shipped_scenes

WORDS_ALONE = ("How to read this", "Events")
LEGEND = 350  # coloured points that a plot has without its curves, at most
DRAWINGS = ("Mode", "Hysteresis", "Contacts")  # without a legend: short curves alone are coloured
MARK = 50
BEHIND = {"Modal amplitude", "Forcing frequency", "Dissipated energy"}
BEHIND |= {"Normal displacement", "Gap", "Normal force"}
SHOWN = {  # titles of views, by a channel
    "/modes": "Displacement",
    "/energy": "Power balance",
    "/contact/0": "Friction force",
    "/contact/1": "Contacts",
    "/torus": "Contact 0 over the phases of both carriers",
    "/blades": "Blade amplitudes over time",
}


def pictures(viewer, rrd, end):
    """Of each view by its name: what it complains of, and its picture."""
    viewer.open(str(rrd))
    viewer.set_time("time", duration=end, play_state="paused")
    viewer.take_screenshot(max_size=64)
    time.sleep(1.5)  # until it is drawn
    found, behind = {}, set()
    for view in viewer.get_state().views:
        try:
            found[view.name] = view.reports, decoded(viewer.take_screenshot(view.view_id))
        except ConnectionError as error:
            assert "not found" in str(error)
            behind.add(view.name)  # another tab
    tabs = {re.split(": | \\[", name)[0] for name in behind - {"Scene", *found}}
    assert tabs <= BEHIND
    return found


def decoded(png):
    return matplotlib.image.imread(BytesIO(png))[..., :3]


def coloured(picture):
    return int(np.count_nonzero(np.ptp(picture, axis=2) > 0.1))


def written(picture):
    return int(np.count_nonzero(picture.min(axis=2) > 0.6))


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_scenes())
def test_no_view_of_a_scene_is_empty(name, tmp_path, viewer, shipped_scene):
    recording = shipped_scene(name)
    replay(recording.mcap, save=tmp_path / "replayed.rrd")
    found = pictures(viewer, tmp_path / "replayed.rrd", recording.plan.scene.run.duration)
    titles = {re.split(": | \\[", name)[0] for name in found}
    recorded = recording.read().channels
    assert {"Events"} | {SHOWN[topic] for topic in SHOWN.keys() & recorded.keys()} <= titles
    assert (SHOWN["/torus"] in titles) == ("/torus" in recorded)
    for view, (reports, picture) in found.items():
        assert reports == [], view
        assert min(picture.shape[:2]) > 100, view
        shown = (written if view in WORDS_ALONE else coloured)(picture)
        assert shown > (MARK if view.startswith(DRAWINGS) else LEGEND), view


def test_a_screenshot_is_a_small_picture_of_all_views(tmp_path, capsys, shipped_scene):
    recording = shipped_scene("one-mode")
    out = tmp_path / "views.png"
    status = main(["replay", str(recording.mcap), "--screenshot", str(out), "--headless"])
    printed = capsys.readouterr()
    if "it needs a graphics driver" in printed.err:
        pytest.skip("no software renderer on this machine")
    assert status == 0 and printed.out == f"{out}\n"
    picture = decoded(out.read_bytes())
    assert picture.shape == (1080, 1920, 3)
    assert coloured(picture) > 10_000
    assert out.stat().st_size < 150_000
