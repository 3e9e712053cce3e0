"""Motion of a contact over the phases of both carriers: a surface and a moving point on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import PHASES, TORUS, Channel
from slipmode.runner.view.labels import BLUE, DARK, GREY, ORANGE, readable

TITLE = "Contact 0 over the phases of both carriers"
_TURN = 2 * np.pi
_HEIGHT = 1.6  # of the largest displacement, where a period is 2 pi wide
_WHITE = (230, 230, 230)


def has_torus(channels: Sequence[Channel]) -> bool:
    """Return whether motion over both phases is recorded."""
    return {TORUS, PHASES} <= {channel.topic for channel in channels}


def view() -> rrb.Spatial3DView:
    """Return the view of the surface, from above a corner."""
    middle = 0.5 * _TURN
    return rrb.Spatial3DView(
        origin=TORUS,
        name=TITLE,
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            position=(middle - 3.0, middle - 6.0, 6.4),
            look_target=(middle, middle, -0.4),
            eye_up=(0, 0, 1),
        ),
    )


def surface(torus: Floats) -> tuple[Floats, Floats, NDArray[np.int32]]:
    """Return the surface over one whole period of both carriers.

    From samples (n, 5) of ``/torus`` at one instant, with any phases of B at each phase of A:
    vertices (m, 3), two phases and a displacement; friction forces (m,); triangles (k, 3).
    """
    rounded = np.round(torus[:, 0], 9)  # equal phases of A
    rounded[rounded == np.round(_TURN, 9)] = 0.0
    columns, which = np.unique(rounded, return_inverse=True)
    phase = np.linspace(0.0, _TURN, 64 + 1)
    profiles = []
    for number in range(len(columns)):
        _, b, x, _, f = torus[which == number].T
        profiles.append([np.interp(phase, b, values, period=_TURN) for values in (x, f)])
    x, f = np.moveaxis(np.array([*profiles, profiles[0]]), 1, 0)
    grid = np.meshgrid(np.append(columns, columns[0] + _TURN), phase, indexing="ij")
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        part.ravel()
        for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:])
    )
    triangles = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    vertices = np.column_stack([each.ravel() for each in (*grid, x)])
    return vertices, f.ravel(), triangles.astype(np.int32)


def draw(
    stream: rr.RecordingStream,
    torus: Floats,
    phases: Floats,
    x: Floats,
    unit: str,
    index: Sequence[rr.TimeColumn],
    shown: NDArray[np.int64],
    tail: int,
) -> None:
    """Draw the surface, and a point that moves on it through samples of x at phases (n, 2).

    Parameters
    ----------
    unit : str
        Of displacements, as they are given and shown.
    index : sequence of TimeColumn
        Times of the samples `shown`.
    tail : int
        Length of the moving point's tail, in samples.
    """
    vertices, f, triangles = surface(torus)
    scale = float(np.abs(vertices[:, 2]).max()) or 1.0
    upright = (1.0, 1.0, _HEIGHT / scale)
    limit = np.abs(f).max() or 1.0
    share = (f / limit)[:, np.newaxis]
    stuck, positive, negative = np.array((DARK, ORANGE, BLUE))
    colors = stuck + np.maximum(share, 0) * (positive - stuck)
    colors = (colors + np.maximum(-share, 0) * (negative - stuck)).astype(np.uint8)
    mesh = rr.Mesh3D(
        vertex_positions=vertices * upright, triangle_indices=triangles, vertex_colors=colors
    )
    stream.log(f"{TORUS}/surface", mesh, static=True)
    _draw_frame(stream, scale, unit, limit)
    points = np.column_stack((phases, x)) * upright + (
        0.0,
        0.0,
        0.06,
    )  # the surface would hide half of the point
    strips = tails(points, _turn_starts(phases), shown, tail)
    style = rr.LineStrips3D.from_fields(colors=_WHITE, radii=rr.Radius.ui_points(1.5))
    stream.log(f"{TORUS}/tail", style, static=True)
    stream.send_columns(f"{TORUS}/tail", index, rr.LineStrips3D.columns(strips=strips))
    mark = rr.Points3D.from_fields(colors=_WHITE, radii=rr.Radius.ui_points(6.0))
    stream.log(f"{TORUS}/now", mark, static=True)
    stream.send_columns(f"{TORUS}/now", index, rr.Points3D.columns(positions=points[shown]))


def tails(
    points: Floats, starts: NDArray[np.int64], shown: NDArray[np.int64], length: int
) -> pa.ListArray:
    """Return for each of the samples `shown` the strip of up to `length` points that ends there.

    No strip of points (n, 2 or 3) begins before the sample `starts` (n,) of its last point. Rerun
    would make the same array of a list of strips one by one, which adds 7 % to a run.
    """
    first = np.maximum(starts[shown], shown + 1 - length)
    count = shown + 1 - first
    offsets = np.append(0, np.cumsum(count)).astype(np.int32)
    taken = np.arange(offsets[-1]) + np.repeat(first - offsets[:-1], count)
    batch = (
        rr.components.LineStrip2DBatch if points.shape[1] == 2 else rr.components.LineStrip3DBatch
    )
    form = batch([points[:1]]).as_arrow_array().type
    flat = points[taken].astype(np.float32).ravel()
    vectors = pa.FixedSizeListArray.from_arrays(flat, type=form.value_type)
    return pa.ListArray.from_arrays(offsets, vectors, type=form)


def _draw_frame(stream: rr.RecordingStream, scale: float, unit: str, limit: float) -> None:
    low = -_HEIGHT
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]) * _TURN
    floor = np.column_stack((corners, np.full(5, low)))
    frame = rr.LineStrips3D(
        [floor, np.array([(0, 0, low), (0, 0, -low)])], colors=DARK, radii=rr.Radius.ui_points(0.8)
    )
    stream.log(f"{TORUS}/frame", frame, static=True)
    labels = {
        "0": (0, 0, low),
        "phase A": (0.5 * _TURN, -0.4, low),
        "2π": (_TURN, 0, low),
        "phase B": (_TURN + 0.4, 0.5 * _TURN, low),
        "2π ": (_TURN, _TURN, low),
        f"height: x = {readable(scale, unit)}": (0, 0, -low),
        f"colour: f = {readable(-limit, 'N')} blue, {readable(limit, 'N')} orange": (
            0.5 * _TURN,
            _TURN,
            -1.3 * low,
        ),
    }
    marks = rr.Points3D(
        list(labels.values()),
        labels=list(labels),
        show_labels=True,
        colors=GREY,
        radii=rr.Radius.ui_points(0.5),
    )
    stream.log(f"{TORUS}/labels", marks, static=True)


def _turn_starts(phases: Floats) -> NDArray[np.int64]:
    """Return for each sample the first one of its way that no edge of the square interrupts."""
    back = np.diff(phases, axis=0, prepend=phases[:1]) < -0.5 * _TURN
    numbers = np.arange(len(phases))
    return np.maximum.accumulate(np.where(back.any(axis=1), numbers, 0))
