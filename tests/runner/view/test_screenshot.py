"""Pictures by a viewer that is slow: a good one, or a line that says what to do."""

from contextlib import contextmanager
from io import BytesIO
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image, ImageDraw

from slipmode.rom import SlipmodeError
from slipmode.runner.view import viewer as module
from slipmode.runner.view.viewer import photograph

SIZE = (192, 108)


def png(draw=lambda canvas: None):
    image = Image.new("RGB", SIZE, (13, 13, 13))
    draw(ImageDraw.Draw(image))
    made = BytesIO()
    image.save(made, "PNG")
    return made.getvalue()


def views(canvas):
    canvas.line((0, 0, *SIZE), fill=(76, 159, 230))


def notice(canvas):
    canvas.rectangle((160, 4, 190, 12), fill=(40, 40, 40))


PLAIN, NOTICE, VIEWS = png(), png(notice), png(views)
BOTH = png(lambda canvas: (views(canvas), notice(canvas)))


class Viewer:
    """What a viewer shows, frame after frame: a notice, then nothing, then what it opened."""

    def __init__(self, notices=3, filling=2, loading=0, deadlines=0, restless=False):
        self.notices, self.filling, self.loading = notices, filling, loading
        self.deadlines, self.restless = deadlines, restless
        self.opened, self.frame = False, 0

    def take_screenshot(self):
        if self.deadlines:
            self.deadlines -= 1
            raise RuntimeError("status: DeadlineExceeded, message: Deadline expired before")
        self.frame += 1
        self.notices -= 1
        if not self.opened:
            return NOTICE if self.notices >= 0 else PLAIN
        if self.restless:
            return png(lambda canvas: canvas.point((self.frame, 50), fill=(255, 0, 0)))
        self.filling -= 1
        if self.filling >= 0:
            return PLAIN
        return BOTH if self.notices >= 0 else VIEWS

    def open(self, path):
        self.opened = True

    def run_command(self, name):
        assert name == "ui.toggle_top_panel"

    def set_time(self, timeline, *, duration, play_state):
        assert (duration, play_state) == (1.0, "paused")

    def get_state(self):
        self.loading -= 1
        return SimpleNamespace(loading=["run.rrd"] * (self.loading >= 0))


@pytest.fixture
def take(monkeypatch, tmp_path):
    """A picture by such viewers, one after the other; and how many of them were started."""
    now = iter(np.arange(0.0, 1e6))
    monkeypatch.setattr(module.time, "monotonic", lambda: next(now))
    monkeypatch.setattr(module.time, "sleep", lambda seconds: None)

    def picture(*viewers):
        waiting = list(viewers)

        @contextmanager
        def started():
            yield waiting.pop(0)

        monkeypatch.setattr(module, "windowless_viewer", started)
        try:
            return photograph(tmp_path / "run.rrd", 1.0), len(viewers) - len(waiting)
        finally:
            picture.started = len(viewers) - len(waiting)

    return picture


def pixels(picture):
    return np.asarray(Image.open(BytesIO(picture)).convert("RGB"))


@pytest.mark.parametrize(
    "slow",
    [
        {},
        {"notices": 0},
        {"notices": 25},
        {"filling": 0},
        {"filling": 1},
        {"loading": 9, "filling": 8},
    ],
    ids=str,
)
def test_a_slow_viewer_gives_the_same_picture(take, slow):
    picture, started = take(Viewer(**slow))
    np.testing.assert_allclose(pixels(picture), pixels(VIEWS), atol=8)
    assert started == 1


@pytest.mark.parametrize("deadlines", [1, 2])
def test_a_viewer_that_does_not_answer_is_started_anew(take, deadlines):
    stuck = [Viewer(deadlines=10) for _ in range(deadlines)]
    picture, started = take(*stuck, Viewer())
    np.testing.assert_allclose(pixels(picture), pixels(VIEWS), atol=8)
    assert started == deadlines + 1


@pytest.mark.parametrize(
    ("slow", "reason"),
    [
        ({"deadlines": 10}, "it does not answer in time, 3 times"),
        ({"notices": 10**6}, "it keeps a notice over its views, 3 times"),
        ({"restless": True}, "its views do not stand still, 3 times"),
        ({"loading": 10**6}, "its views do not stand still, 3 times"),
    ],
    ids=str,
)
def test_without_a_good_picture_a_line_says_what_to_do(take, slow, reason):
    with pytest.raises(SlipmodeError, match=r"write an \.rrd file with --save") as refusal:
        take(*(Viewer(**slow) for _ in range(5)))
    assert reason in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert take.started == 3


def test_a_viewer_that_cannot_start_is_not_tried_again(take):
    class Dead(Viewer):
        def take_screenshot(self):
            raise ConnectionError("transport error")

    with pytest.raises(SlipmodeError, match="it needs a graphics driver"):
        take(Dead(), Viewer())
    assert take.started == 1
