"""All sectors of a bladed disk: a ring that deforms, and the states of its contacts."""

from __future__ import annotations

from collections.abc import Sequence
from math import tau

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import DISK, Channel
from slipmode.runner.view.drawing import Drawing, draw_labels, draw_lines, time_column
from slipmode.runner.view.plots import BLUE, DARK, STATE_COLORS
from slipmode.runner.view.samples import Latest, window_starts

_TITLE = "Disk: every sector"
_REST, _SWING, _CONTACTS = 1.0, 0.3, 0.55  # radii


def _view() -> rrb.Spatial2DView:
    """Return the view of the disk."""
    reach = (-1.5, 1.5)
    bounds = rrb.VisualBounds2D(x_range=reach, y_range=reach)
    return rrb.Spatial2DView(origin=DISK, name=_TITLE, visual_bounds=bounds)


def ring(displacement: Floats) -> Floats:
    """Return the places (n, sectors, 2) of blades by their displacements (n, sectors).

    They move outwards, the largest displacement by 0.3 radii. Sectors are counted
    counter-clockwise; the second coordinate points down.
    """
    largest = float(np.abs(displacement).max()) or 1.0
    radius = _REST + _SWING * displacement / largest
    return radius[..., np.newaxis] * _directions(np.arange(displacement.shape[1]), radius.shape[1])


def _draw(stream: rr.RecordingStream, channels: Sequence[Channel], rows: Sequence[Floats]) -> None:
    """Draw samples of ``/disk``, rows of time [ns] and values, of the last window."""
    time_ns, values = rows[0][:, 0].astype(np.int64), rows[0][:, 1:]
    last, unit = window_starts(time_ns)[-1], channels[0].fields[0].unit
    time_ns, values = time_ns[last:], values[last:]
    sectors = values.shape[1] // 2
    blades, index = ring(values[:, :sectors]), [time_column(time_ns)]
    round_ = _directions(np.linspace(0.0, sectors, 181), sectors)
    draw_lines(stream, f"{DISK}/rest", [_REST * round_, _CONTACTS * round_], DARK, 0.5)
    line = rr.LineStrips2D.from_fields(colors=BLUE, radii=rr.Radius.ui_points(1.5))
    stream.log(f"{DISK}/blades", line, static=True)
    closed = np.concatenate((blades, blades[:, :1]), axis=1)
    stream.send_columns(
        f"{DISK}/blades", index, rr.LineStrips2D.columns(strips=list(closed.astype(np.float32)))
    )
    places = _CONTACTS * _directions(np.arange(sectors) + 0.5, sectors)
    points = rr.Points2D.from_fields(positions=places, radii=rr.Radius.ui_points(4.0))
    stream.log(f"{DISK}/contacts", points, static=True)
    packed = [(r << 24) | (g << 16) | (b << 8) | 255 for r, g, b in STATE_COLORS.values()]
    colors = np.array(packed, dtype=np.uint32)[values[:, sectors:].astype(int)]
    columns = rr.Points2D.columns(colors=colors.ravel()).partition([sectors] * len(values))
    stream.send_columns(f"{DISK}/contacts", index, columns)
    largest = f"{np.abs(values[:, :sectors]).max():.3g} {unit}"
    labels = {(0.0, -1.45): f"largest displacement {largest}", (1.4, 0.0): "sector 0"}
    draw_labels(stream, DISK, labels)


def _directions(sector: Floats | NDArray[np.int64], sectors: int) -> Floats:
    """Return unit vectors (n, 2) at sectors, in Rerun's coordinates."""
    angle = tau * sector / sectors
    return np.stack((np.cos(angle), -np.sin(angle)), axis=-1)


DRAWING = Drawing(_TITLE, (DISK,), Latest, _view, _draw)
