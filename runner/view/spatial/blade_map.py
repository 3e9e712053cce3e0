"""Amplitudes of all blades of a mistuned disk: a map over time and the number of the blade."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import BLADES, NANOSECONDS, Channel
from slipmode.runner.view.charts import Axis, Box, box_view
from slipmode.runner.view.drawing import Drawing
from slipmode.runner.view.plots import BLUE, DARK, ORANGE, Color
from slipmode.runner.view.samples import Thinned

_TITLE = "Blade amplitudes over time"
_ENTITY = f"{BLADES}/map"
_ASPECT, _ROW = 2.4, 0.12
_COLUMNS = 240  # instants that are drawn
_COLORS = np.array([DARK, BLUE, ORANGE, (255, 244, 214)], dtype=float)  # from 0 to the largest


def _view() -> rrb.View:
    """Return the view of the map."""
    return box_view(_ENTITY, _TITLE, _ASPECT + 0.3, _ROW)


def _draw(stream: rr.RecordingStream, channels: Sequence[Channel], rows: Sequence[Floats]) -> None:
    """Draw samples of ``/blades``, rows of time [ns] and amplitudes."""
    time, amplitude = rows[0][:, 0] / NANOSECONDS, rows[0][:, 1:]
    unit = channels[0].fields[0].unit
    ends = np.linspace(time[0], time[-1], _COLUMNS + 1)
    middle = 0.5 * (ends[1:] + ends[:-1])
    found = np.array([np.interp(middle, time, column) for column in amplitude.T])
    largest = float(amplitude.max()) or 1.0
    blades = len(found)
    box = Box(
        Axis("time [s]"), Axis("blade"), (ends[0], ends[-1]), (-0.5, blades - 0.5), _ASPECT, _ROW
    )
    starts, stops = (
        box.place(np.tile(part, blades), np.repeat(np.arange(blades, dtype=float), _COLUMNS))
        for part in (ends[:-1], ends[1:])
    )
    colors = [_color(share) for share in (found / largest).ravel().tolist()]
    strips = np.stack((starts, stops), axis=1).astype(np.float32)
    marks = rr.LineStrips2D(strips, colors=colors, radii=0.46 / blades)
    stream.log(f"{_ENTITY}/amplitudes", marks, static=True)
    key = [(f"{part * largest:.3g} {unit}", _color(part)) for part in (1.0, 0.75, 0.5, 0.25, 0.0)]
    box.draw(stream, _ENTITY, key)


def _color(share: float) -> Color:
    """Return the colour of an amplitude relative to the largest one."""
    at = np.linspace(0.0, 1.0, len(_COLORS))
    red, green, blue = (round(float(np.interp(share, at, part))) for part in _COLORS.T)
    return red, green, blue


DRAWING = Drawing(_TITLE, (BLADES,), Thinned, _view, _draw, slow=True)
