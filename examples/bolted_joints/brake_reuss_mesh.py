"""What brake_reuss.py found, on the mesh: for Rerun and for ParaView.

    python examples/bolted_joints/brake_reuss_mesh.py beam rest.rrd
    python examples/bolted_joints/brake_reuss_mesh.py beam vibrating.vtu logs/beam.mcap

The mode with the contacts as the bolts leave them; or a period of a recording of the scene.
"""

import sys
from pathlib import Path

import numpy as np

from slipmode import runner


def motion(folder: Path, recording: Path | None = None) -> runner.MeshMotion:
    """The mode of the scene at rest, or as it vibrates at the end of a recording."""
    with np.load(folder / "found.npz") as found:
        x, cells, shapes, state = (found[name] for name in ("nodes", "cells", "shapes", "state"))
        contacts = np.split(found["members"], np.cumsum(found["sizes"])[:-1])
    if recording is None:
        return runner.MeshMotion.at_rest(x, cells, shapes[0], contacts, state)
    return runner.MeshMotion.of_recording(recording, x, cells, list(shapes), contacts)


def main(folder: Path, picture: Path, recording: Path | None = None) -> None:
    """To .vtu for ParaView, to .png or .rrd by Rerun."""
    seen = motion(folder, recording)
    if picture.suffix == ".vtu":
        runner.write_mesh(seen, picture)
    elif picture.suffix == ".png":
        runner.show_mesh(seen, screenshot=picture)
    else:
        runner.show_mesh(seen, save=picture)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
