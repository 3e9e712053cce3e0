"""A mesh in motion and its contacts, for ParaView and other readers of VTK files."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.files import replacing
from slipmode.runner.view.mesh.mesh_motion import MeshMotion

_KINDS = {4: "tetra", 8: "hexahedron"}
_NO_CONTACT = -1


def write_mesh(motion: MeshMotion, path: str | PathLike[str]) -> list[Path]:
    """Write frames of a mesh and its contacts as VTK files (needs `slipmode[mesh]`).

    Nodes have a "displacement" [m], to warp by. The nodes of contacts are cells of their own,
    vertices, whose "state" is 0 stuck, 1 slipping, 2 open; it is -1 of the others.

    Parameters
    ----------
    motion : MeshMotion
    path : path
        Ending in .vtu. Of several frames each has a file, NAME_000.vtu and so on, which ParaView
        opens as one series.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    SlipmodeError
        If the path ends otherwise, or meshio is not installed.
    OSError
        If a file cannot be written.
    """
    target = Path(path)
    if target.suffix != ".vtu":
        raise SlipmodeError(f"path: must end in .vtu, got {target.name}")
    meshio = extra("meshio", "mesh")
    files = [target]
    if len(motion.time) > 1:
        files = [target.with_stem(f"{target.stem}_{k:03}") for k in range(len(motion.time))]
    node = np.concatenate(motion.contacts)
    contact = np.repeat(np.arange(len(motion.contacts)), [len(c) for c in motion.contacts])
    blocks = [(_KINDS[motion.cells.shape[1]], motion.cells), ("vertex", node[:, np.newaxis])]
    none = np.full(len(motion.cells), _NO_CONTACT, dtype=np.int32)
    for file, u, state in zip(files, motion.displacement, motion.state, strict=True):
        mesh = meshio.Mesh(
            motion.nodes,
            blocks,
            point_data={"displacement": u},
            cell_data={"state": [none, state[contact].astype(np.int32)]},
        )
        with replacing(file) as stream:
            meshio.write(stream.name, mesh, "vtu")  # it opens files by name alone
    return files
