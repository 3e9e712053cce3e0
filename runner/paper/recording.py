"""One Rerun recording of the main curves and surfaces, with the claims as text."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from matplotlib import colormaps
from matplotlib.colors import to_rgb

from slipmode.rom.arrays import Floats
from slipmode.runner.paper.claims.claim import Claim, as_markdown
from slipmode.runner.paper.figures.motion_figures import torus_line, torus_points
from slipmode.runner.paper.figures.resonance_figures import slice_lines
from slipmode.runner.paper.figures.style import BOTH, FULL_ORDER, GREY, MODE_A, MODE_B
from slipmode.runner.paper.slices import DETUNINGS, euclidean
from slipmode.runner.paper.study import Study, torus_angles
from slipmode.runner.recording.record import create_file
from slipmode.runner.view.phase_portraits import TIMELINE, time_column

_DETUNING_SCALE = 10.0  # drawn lengths per rad/s
_LIFT = 0.01  # of lines above the surface that they lie on


def write_recording(study: Study, claims: Sequence[Claim], path: Path) -> Path:
    """Write an .rrd file with its views embedded."""
    create_file(path).close()
    stream = rr.RecordingStream("slipmode")
    stream.save(path, default_blueprint=_blueprint())
    stream.send_recording_name("The paper's figures")
    _send_surface(stream, study)
    _send_torus(stream, study)
    _send_curves(stream, study)
    _send_portraits(stream, study)
    _send_motion(stream, study)
    text = rr.TextDocument(as_markdown(claims), media_type=rr.MediaType.MARKDOWN)
    stream.log("/claims", text, static=True)
    stream.disconnect()
    return path


def _send_surface(stream: rr.RecordingStream, study: Study) -> None:
    """Resonance surface and its slices, Fig. 12."""
    surface = study.surface
    first, second = np.meshgrid(
        _DETUNING_SCALE * (surface.frequency_A - 1.0),
        _DETUNING_SCALE * (surface.frequency_B - 1.7),
        indexing="ij",
    )
    height = surface.euclidean
    _log_mesh(stream, "/resonance/surface", (first, second, height), height / height.max())
    for k, (detunings, amplitudes, color, _) in enumerate(slice_lines(study.slices)):
        x, y = (_DETUNING_SCALE * detuning for detuning in detunings)
        line = np.column_stack((x, y, euclidean(amplitudes) + _LIFT))
        strip = rr.LineStrips3D([line], colors=_rgb(color), radii=0.012)
        stream.log(f"/resonance/slice_{k}", strip, static=True)


def _send_torus(stream: rr.RecordingStream, study: Study) -> None:
    """Contact motion on the torus and the line of the motion, Fig. 6."""
    swelling = study.torus / np.abs(study.torus).max()
    t_A, t_B = np.meshgrid(torus_angles(), torus_angles(), indexing="ij")
    points = torus_points(t_A, t_B, swelling)
    _log_mesh(stream, "/torus/surface", points, 0.5 + 0.5 * swelling)
    on_line = torus_line(swelling)
    line = np.column_stack(torus_points(on_line[0], on_line[1], on_line[2] + _LIFT))
    motion = rr.LineStrips3D([line], colors=_rgb(FULL_ORDER), radii=0.01)
    stream.log("/torus/motion", motion, static=True)


def _send_curves(stream: rr.RecordingStream, study: Study) -> None:
    """Resonance curves, Fig. 13."""
    slices = study.slices
    for entity, alone, both, color in (
        ("/curves_a", slices.alone_a, slices.both_a, MODE_A),
        ("/curves_b", slices.alone_b, slices.both_b, MODE_B),
    ):
        for name, amplitudes, shade in (("alone", alone, color), ("both", both, BOTH)):
            _log_line(
                stream,
                f"{entity}/{name}",
                _DETUNING_SCALE * DETUNINGS,
                euclidean(amplitudes),
                shade,
            )


def _send_portraits(stream: rr.RecordingStream, study: Study) -> None:
    """Contact trajectories and friction cycles, Figs. 4 and 5, in units of their reach."""
    reach = np.abs(study.both.contact).max()
    for name, signals, color in (
        ("both", study.both, BOTH),
        ("only_a", study.alone_a, MODE_A),
        ("only_b", study.alone_b, MODE_B),
    ):
        x_c1, x_c2 = signals.contact.T / reach
        _log_line(stream, f"/trajectory/{name}", x_c1, x_c2, color)
        _log_line(stream, f"/loop/{name}", x_c1, signals.friction[:, 0] / 2.0, color)


def _send_motion(stream: rr.RecordingStream, study: Study) -> None:
    """Motion from rest and its envelope by the slow flow, Fig. 3a."""
    rest, (time, amplitudes) = study.from_rest, study.envelope
    for name, at, values, color in (
        ("x_e1", rest.time, rest.elastic[:, 0], BOTH),
        ("envelope", time, 2 * amplitudes[:, 0], GREY),
    ):
        legend = f"{'2|A|, slow flow' if name == 'envelope' else name} [m]"
        style = rr.SeriesLines(names=[legend], colors=[_rgb(color)])
        stream.log(f"/motion/{name}", style, static=True)
        index = time_column((1e9 * at).astype(np.int64))
        stream.send_columns(f"/motion/{name}", [index], rr.Scalars.columns(scalars=values))


def _log_line(stream: rr.RecordingStream, entity: str, x: Floats, y: Floats, color: str) -> None:
    """A line in the plane, y upwards."""
    strip = rr.LineStrips2D(
        [np.column_stack((x, -y))], colors=_rgb(color), radii=rr.Radius.ui_points(1.0)
    )
    stream.log(entity, strip, static=True)


def _log_mesh(
    stream: rr.RecordingStream, entity: str, points: Sequence[Floats], shade: Floats
) -> None:
    """A surface through points on a grid, coloured by `shade` from 0 to 1."""
    rows, columns = shade.shape
    corner = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    triangles = np.stack((a, b, c, a, c, d), axis=-1).reshape(-1, 3)
    mesh = rr.Mesh3D(
        vertex_positions=np.stack(points, axis=-1).reshape(-1, 3),
        triangle_indices=triangles,
        vertex_colors=(255 * colormaps["viridis"](shade.ravel())).astype(np.uint8),
    )
    stream.log(entity, mesh, static=True)


def _rgb(color: str) -> list[int]:
    return [round(255 * part) for part in to_rgb(color)]


def _blueprint() -> rrb.Blueprint:
    norm = "sqrt(|A|²+|B|²)"
    whole = rr.TimeRange(rr.TimeRangeBoundary.infinite(), rr.TimeRangeBoundary.infinite())
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(
                rrb.Spatial3DView(
                    origin="/resonance", name=f"Resonance surface {norm}; detuning x 10"
                ),
                rrb.Spatial3DView(origin="/torus", name="Contact motion x_c1 on the torus"),
                rrb.TextDocumentView(origin="/claims", name="Claims"),
                column_shares=(3, 3, 4),
            ),
            rrb.Horizontal(
                rrb.Spatial2DView(origin="/curves_a", name=f"{norm} over detuning A x 10"),
                rrb.Spatial2DView(origin="/curves_b", name=f"{norm} over detuning B x 10"),
                rrb.Spatial2DView(origin="/trajectory", name="x_c2 over x_c1"),
                rrb.Spatial2DView(origin="/loop", name="g_1 over x_c1, in units of reach"),
                rrb.TimeSeriesView(
                    origin="/motion",
                    name="x_e1 from rest",
                    axis_x=rrb.TimeAxis(view_range=whole),
                ),
            ),
        ),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        collapse_panels=True,
    )
