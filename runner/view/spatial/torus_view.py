"""Motion of a contact over the phases of both carriers: a surface and a moving point on it."""

from __future__ import annotations

from collections.abc import Sequence
from math import tau

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats
from slipmode.runner.recording.channels import PHASES, TORUS, Channel
from slipmode.runner.view.drawing import Drawing, Path, draw_labels, draw_lines, draw_moving_point
from slipmode.runner.view.plots import BLUE, DARK, ORANGE
from slipmode.runner.view.samples import Latest, window_starts

_TITLE = "Contact 0 over the phases of both carriers"
_WHITE = (230, 230, 230)


def _view() -> rrb.Spatial3DView:
    """Return the view of the surface, from above a corner."""
    eye, target = (0.5 * tau - 4.2, 0.5 * tau - 8.4, 7.6), (0.5 * tau, 0.5 * tau, -0.9)
    controls = rrb.EyeControls3D(position=eye, look_target=target, eye_up=(0, 0, 1))
    no_grid = rrb.LineGrid3D(visible=False)
    return rrb.Spatial3DView(origin=TORUS, name=_TITLE, line_grid=no_grid, eye_controls=controls)


def surface(torus: Floats) -> tuple[Floats, Floats, NDArray[np.int32]]:
    """Return the surface over one whole period of both carriers.

    From samples (n, 5) of ``/torus`` at one instant, with any phases of B at each phase of A:
    vertices (m, 3), two phases and a displacement; friction forces (m,); triangles (k, 3).
    """
    rounded = np.round(torus[:, 0], 9)  # equal phases of A
    rounded[rounded == np.round(tau, 9)] = 0.0
    columns, which = np.unique(rounded, return_inverse=True)
    phase = np.linspace(0.0, tau, 64 + 1)
    profiles = []
    for number in range(len(columns)):
        _, b, x, _, f = torus[which == number].T
        profiles.append([np.interp(phase, b, values, period=tau) for values in (x, f)])
    x, f = np.moveaxis(np.array([*profiles, profiles[0]]), 1, 0)
    grid = np.meshgrid(np.append(columns, columns[0] + tau), phase, indexing="ij")
    corner = np.arange(x.size).reshape(x.shape)
    corners = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    a, b, c, d = (each.ravel() for each in corners)
    triangles = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    vertices = np.column_stack([each.ravel() for each in (*grid, x)])
    return vertices, f.ravel(), triangles.astype(np.int32)


def _draw(stream: rr.RecordingStream, channels: Sequence[Channel], rows: Sequence[Floats]) -> None:
    """Draw the last surface, and a point that moves on it in the last window."""
    torus, phases, motion = rows
    torus = torus[torus[:, 0] == torus[-1, 0], 1:]
    count = min(len(phases), len(motion))
    phases, motion = phases[-count:], motion[-count:]
    last = window_starts(motion[:, 0].astype(np.int64))[-1]
    x = channels[-1].names.index("x")
    unit = channels[-1].fields[x].unit
    places = np.column_stack((phases[last:, 1:], motion[last:, 1 + x]))
    vertices, f, triangles = surface(torus)
    scale = float(np.abs(vertices[:, 2]).max()) or 1.0
    top = 1.6  # height of the largest displacement, where a period is 2 pi wide
    upright = (1.0, 1.0, top / scale)
    limit = np.abs(f).max() or 1.0
    share = (f / limit)[:, np.newaxis]
    stuck, positive, negative = np.array((DARK, ORANGE, BLUE))
    colors = stuck + np.maximum(share, 0) * (positive - stuck)
    colors = (colors + np.maximum(-share, 0) * (negative - stuck)).astype(np.uint8)
    mesh = rr.Mesh3D(
        vertex_positions=vertices * upright, triangle_indices=triangles, vertex_colors=colors
    )
    stream.log(f"{TORUS}/surface", mesh, static=True)
    back = np.diff(places[:, :2], axis=0, prepend=places[:1, :2]) < -0.5 * tau
    edges = np.maximum.accumulate(np.where(back.any(axis=1), np.arange(len(back)), 0))
    raised = places * upright + (0.0, 0.0, 0.06)  # the surface would hide half of the point
    path = Path(motion[last:, 0].astype(np.int64), raised, edges, tail=True)
    draw_moving_point(stream, TORUS, path, _WHITE, _WHITE)
    low = -1.3 * top  # the floor, below the surface
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]) * tau
    floor = np.column_stack((corners, np.full(5, low)))
    draw_lines(stream, f"{TORUS}/frame", [floor, [(0, 0, low), (0, 0, top)]], DARK, 0.8)
    height = f"height: x to ±{scale:.3g} {unit}"
    forces = f"colour: f = {-limit:.3g} N blue, {limit:.3g} N orange"
    labels = {
        (0.5 * tau, tau, 2.2 * top): f"{height}; {forces}",
        (0, 0, low): "0",
        (0.5 * tau, -0.4, low): "phase A",
        (tau, 0, low): "2π",
        (tau + 1.5, 0.5 * tau, low): "phase B",
        (tau + 0.5, tau, low): "2π",
    }
    draw_labels(stream, TORUS, labels)


DRAWING = Drawing(_TITLE, (TORUS, PHASES, "/contact/0"), Latest, _view, _draw)
