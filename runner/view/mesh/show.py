"""A mesh in motion and its contacts, in Rerun."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import scipy

from slipmode.rom.arrays import Floats
from slipmode.rom.laws.states import STATES
from slipmode.rom.storage.files import create_file
from slipmode.runner.view.drawing import time_column
from slipmode.runner.view.mesh.motion import MeshMotion, skin, triangles
from slipmode.runner.view.plots import STATE_COLORS
from slipmode.runner.view.viewer import Viewer


def draw_mesh(motion: MeshMotion, target: Path | Viewer) -> None:
    """Write an .rrd file of a mesh in motion, or show it in a viewer."""
    stream = rr.RecordingStream("slipmode mesh")
    layout = _blueprint(motion)
    if isinstance(target, Path):
        create_file(target).close()  # Rerun reports no errno of its own
        stream.save(target, default_blueprint=layout)
    else:
        stream.connect_grpc(target.url, default_blueprint=layout)
    # the largest displacement is shown as 6 % of the size of the mesh
    largest = np.linalg.norm(motion.displacement, axis=-1).max()
    scale = 0.06 * float(np.ptp(motion.nodes, axis=0).max()) / float(largest)
    _draw_skin(stream, motion, scale)
    _draw_contacts(stream, motion, scale)
    stream.flush()
    stream.disconnect()


def _draw_skin(stream: rr.RecordingStream, motion: MeshMotion, scale: float) -> None:
    """Draw all frames; nodes that move far are light; facets have corners of their own."""
    facets = skin(motion.cells)
    corner = facets.ravel()
    length = np.linalg.norm(motion.displacement, axis=-1).max(axis=0)[corner]
    share = (length / max(length.max(), np.finfo(float).tiny))[:, np.newaxis]
    x = motion.nodes[facets]
    normal = np.cross(x[:, 1] - x[:, 0], x[:, -1] - x[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, np.newaxis]
    own = np.arange(corner.size).reshape(facets.shape)
    dark, light = np.array((95, 100, 110)), np.array((150, 200, 245))
    still = rr.Mesh3D.from_fields(
        triangle_indices=triangles(own),
        vertex_normals=np.repeat(normal, facets.shape[1], axis=0),
        vertex_colors=(dark + share * (light - dark)).astype(np.uint8),
    )
    stream.log("/mesh/body", still, static=True)
    moved = motion.nodes[corner] + scale * motion.displacement[:, corner]
    columns = rr.Mesh3D.columns(vertex_positions=moved.reshape(-1, 3))
    columns = columns.partition([corner.size] * len(moved))
    stream.send_columns("/mesh/body", [_times(motion)], columns)


def _draw_contacts(stream: rr.RecordingStream, motion: MeshMotion, scale: float) -> None:
    """Draw all frames of the contacts' nodes, moving with the mesh, and at rest below it."""
    node, contact = motion.contact_nodes()
    radius = 0.4 * _spacing(motion.nodes[node])
    colors = np.array([*STATE_COLORS.values()])[motion.state[:, contact]].reshape(-1, 3)
    for entity, enlarged in (("/mesh/contacts", scale), ("/interface", 0.0)):
        stream.log(entity, rr.Points3D.from_fields(radii=radius), static=True)
        place = motion.nodes[node] + enlarged * motion.displacement[:, node]
        columns = rr.Points3D.columns(positions=place.reshape(-1, 3), colors=colors)
        stream.send_columns(entity, [_times(motion)], columns.partition([node.size] * len(place)))


def _times(motion: MeshMotion) -> rr.TimeColumn:
    return time_column(np.round(motion.time * 1e9).astype(np.int64))


def _blueprint(motion: MeshMotion) -> rrb.Blueprint:
    """Return the views: the mesh from a side, the contacts along their thinnest direction."""
    x = motion.nodes[np.unique(motion.cells)]
    interface = motion.nodes[np.concatenate(motion.contacts)]
    axes = np.linalg.svd(interface - interface.mean(axis=0), full_matrices=False)[2]
    up = axes[-1] * np.sign(axes[-1][np.argmax(np.abs(axes[-1]))])
    long = axes[0] * np.sign(axes[0][np.argmax(np.abs(axes[0]))])
    across = np.cross(up, long)

    def seen(name: str, origin: str, points: Floats, towards: Floats, up: Floats) -> rrb.View:
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        extent = np.sort(np.ptp(points, axis=0))[1:]
        distance = max(1.4 * extent[0], 0.5 * extent[1])  # both sides are in sight
        eye = centre + distance * towards / np.linalg.norm(towards)
        return rrb.Spatial3DView(
            origin=origin,
            name=name,
            line_grid=rrb.LineGrid3D(visible=False),
            eye_controls=rrb.EyeControls3D(position=eye, look_target=centre, eye_up=up),
        )

    said = ", ".join(map(" ".join, zip(STATE_COLORS, STATES, strict=True)))
    mesh = seen("Mesh, displacements enlarged", "/mesh", x, 0.35 * up - across, up)
    contacts = seen(f"Contacts: {said}", "/interface", interface, up, across)
    return rrb.Blueprint(rrb.Vertical(mesh, contacts), collapse_panels=True)


def _spacing(points: Floats) -> float:
    """Return the median distance of a point from the next."""
    if len(points) < 2:
        return 1.0
    return float(np.median(np.asarray(scipy.spatial.cKDTree(points).query(points, 2)[0])[:, 1]))
