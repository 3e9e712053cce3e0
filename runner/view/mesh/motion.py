"""A mesh in motion: displacements and contact states at some instants, also as VTK files."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.extras import extra
from slipmode.rom.laws.states import STATES
from slipmode.rom.short_repr import frozen
from slipmode.rom.storage.files import replacing
from slipmode.runner.recording.channels import MODES
from slipmode.runner.recording.load import Signals, load
from slipmode.runner.view.viewer import find_viewer, write_picture

_KINDS = {4: "tetra", 8: "hexahedron"}  # of cells, by their corners


@frozen
class MeshMotion:
    """Frames of a mesh and its contacts, for `show_mesh` and `write_mesh`.

    Parameters
    ----------
    nodes : (nodes, 3) array_like
        At rest [m].
    cells : (cells, 4 or 8) array_like of int
        Tetrahedra or hexahedra, by rows of `nodes`.
    displacement : (frames, nodes, 3) array_like
        [m]
    contacts : sequence of (k,) array_like of int
        The nodes each contact is made of, as `ContactPairs.nodes`.
    state : (frames, contacts) array_like of int
        0 stuck, 1 slipping, 2 open.
    time : (frames,) array_like
        [s]

    Raises
    ------
    SlipmodeError
        Naming the argument that does not fit.
    """

    nodes: Floats
    cells: NDArray[np.intp]
    displacement: Floats
    contacts: tuple[NDArray[np.intp], ...]
    state: NDArray[np.int8]
    time: Floats

    def __init__(
        self,
        nodes: ArrayLike,
        cells: ArrayLike,
        displacement: ArrayLike,
        contacts: Sequence[ArrayLike],
        state: ArrayLike,
        time: ArrayLike,
    ) -> None:
        instants = np.asarray(time, dtype=float)
        if instants.ndim != 1 or not instants.size or np.any(np.diff(instants) <= 0.0):
            raise SlipmodeError("time: must be increasing, at least one")
        x = _finite("nodes", nodes, (None, 3))
        u = _finite("displacement", displacement, (instants.size, len(x), 3))
        members = tuple(
            _numbers(f"contacts[{k}]", c, len(x)).ravel() for k, c in enumerate(contacts)
        )
        if not members:
            raise SlipmodeError("contacts: must be at least one")
        states = _finite("state", state, (instants.size, len(members)))
        if not np.isin(states, range(len(STATES))).all():
            raise SlipmodeError("state: must be 0 (stuck), 1 (slipping) or 2 (open)")
        corners = _numbers("cells", cells, len(x))
        if corners.ndim != 2 or corners.shape[1] not in _KINDS:
            raise SlipmodeError(f"cells: must be (cells, 4 or 8), got {corners.shape}")
        values = (x, corners, u, members, states.astype(np.int8), instants)
        for name, value in zip(self.__dataclass_fields__, values, strict=True):
            object.__setattr__(self, name, value)

    @classmethod
    def at_rest(
        cls,
        nodes: ArrayLike,
        cells: ArrayLike,
        shape: ArrayLike,
        contacts: Sequence[ArrayLike],
        state: ArrayLike,
    ) -> Self:
        """Return one frame: a mode shape or static displacement (nodes, 3), states (contacts,)."""
        displacement, states = (np.asarray(each)[np.newaxis] for each in (shape, state))
        return cls(nodes, cells, displacement, contacts, states, [0.0])

    @classmethod
    def of_recording(
        cls,
        recording: str | PathLike[str],
        nodes: ArrayLike,
        cells: ArrayLike,
        shapes: ArrayLike,
        contacts: Sequence[ArrayLike],
        most: int = 64,
    ) -> Self:
        """Return the last period of mode A in a recording that has contact motion.

        Parameters
        ----------
        recording : path
            MCAP file of a scene with elastic contacts and a [[contact]] window.
        nodes, cells, contacts
            As of the class.
        shapes : (modes, nodes, 3) array_like
            Mode shapes of the reduction [kg^-1/2], of the modes that are recorded.
        most : int, default 64
            Frames at most.
        """
        signals = load(recording)
        states = _states(signals, len(contacts))
        time = signals["/contact/0"].time
        angle, amplitude = _carriers(signals, time)
        first = int(np.searchsorted(angle[:, 0], angle[-1, 0] - 2 * np.pi))
        frames = min(len(time) - first, most)
        kept = np.linspace(first, len(time) - 1, frames).round().astype(int)
        phi = np.asarray(shapes, dtype=float)
        if len(phi) != amplitude.shape[1]:
            raise SlipmodeError(
                f"shapes: must be of {amplitude.shape[1]} modes, those recorded, got {len(phi)}"
            )
        q = 2.0 * np.real(amplitude * np.exp(1j * angle))[kept]
        displacement = np.tensordot(q, phi, axes=1)
        return cls(nodes, cells, displacement, contacts, states[kept], time[kept])

    def contact_nodes(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the nodes of all contacts, and the contact of each."""
        contact = np.repeat(np.arange(len(self.contacts)), [len(c) for c in self.contacts])
        return np.concatenate(self.contacts), contact


def _states(signals: dict[str, Signals], contacts: int) -> NDArray[np.int8]:
    """Return the recorded states (samples, contacts)."""
    topics = [f"/contact/{k}" for k in range(contacts)]
    if not contacts or not set(topics) <= set(signals) or f"/contact/{contacts}" in signals:
        found = sum(topic.startswith("/contact/") for topic in signals)
        raise SlipmodeError(
            f"contacts: {contacts} are given, and {found} recorded; their motion is in windows, "
            "[[contact]] of the scene"
        )
    return np.stack([signals[topic].column("state") for topic in topics], axis=1).astype(np.int8)


def _carriers(signals: dict[str, Signals], time: Floats) -> tuple[Floats, NDArray[np.complex128]]:
    """Return the carrier angles theta_j and amplitudes a_j, (times, modes)."""
    slow, forcing = signals["/modes"], signals["/forcing"]
    present = [mode for mode in MODES if f"{mode}_abs" in slow.channel.names]
    amplitude = [slow.column(f"{m}_re") + 1j * slow.column(f"{m}_im") for m in present]
    angles = []
    for mode in present:
        Omega, t = forcing.column(f"{mode}_frequency"), forcing.time
        turned = np.cumsum(0.5 * (Omega[1:] + Omega[:-1]) * np.diff(t))
        angles.append(np.interp(time, t, np.append(0.0, turned)))
    a = [np.interp(time, slow.time, each) for each in amplitude]
    return np.stack(angles, axis=1), np.stack(a, axis=1)


def _finite(name: str, given: ArrayLike, shape: tuple[int | None, ...]) -> Floats:
    try:
        values = np.asarray(given, dtype=float)
    except (ValueError, TypeError):
        raise SlipmodeError(f"{name}: must be numbers") from None
    pairs = zip(shape, values.shape, strict=False)
    fits = values.ndim == len(shape) and all(wanted in (None, size) for wanted, size in pairs)
    if not fits or not np.isfinite(values).all():
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise SlipmodeError(f"{name}: must be ({wanted}), finite, got {values.shape}")
    return values


def _numbers(name: str, given: ArrayLike, nodes: int) -> NDArray[np.intp]:
    numbers = np.asarray(given)
    if numbers.dtype.kind not in "iu" or not numbers.size:
        raise SlipmodeError(f"{name}: must be integers, at least one")
    if numbers.min() < 0 or numbers.max() >= nodes:
        raise SlipmodeError(f"{name}: nodes must be 0 to {nodes - 1}")
    return np.asarray(numbers, dtype=np.intp)


def skin(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the facets (facets, 3 or 4) that belong to one cell alone: the surface of a mesh.

    Cells (cells, 4 or 8) are tetrahedra or hexahedra, the lower four corners first, as Abaqus and
    VTK order them. Facets are counter-clockwise as seen from outside.
    """
    cells = np.asarray(cells)
    corners = {
        4: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        8: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    }[cells.shape[1]]
    faces = cells[:, corners].reshape(-1, len(corners[0]))
    same = np.sort(faces, axis=1)
    _, first, count = np.unique(same, axis=0, return_index=True, return_counts=True)
    return np.asarray(faces[np.sort(first[count == 1])])


def triangles(facets: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return facets (facets, 3 or 4) as triangles (triangles, 3)."""
    if facets.shape[1] == 3:
        return facets
    return facets[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def show_mesh(
    motion: MeshMotion, save: str | Path | None = None, screenshot: str | Path | None = None
) -> None:
    """Show a mesh in motion, displacements enlarged, and its contacts coloured by state.

    Above the mesh as it moves, beneath it the contacts alone, seen along their normal. Raises
    SlipmodeError if nothing moves, or no viewer can be started; OSError if a file cannot be
    written.

    Parameters
    ----------
    motion : MeshMotion
    save : path, optional
        Write an .rrd file, views included, instead of opening the viewer.
    screenshot : path, optional
        Write a PNG of the last frame, without a window.
    """
    if not motion.displacement.any():
        raise SlipmodeError("displacement: nothing moves")
    from slipmode.runner.view.mesh.show import draw_mesh  # Rerun takes a while to import

    if save is not None:
        draw_mesh(motion, Path(save))
    if screenshot is not None:
        write_picture(screenshot, lambda rrd: draw_mesh(motion, rrd), float(motion.time[-1]))
    if save is None and screenshot is None:
        draw_mesh(motion, find_viewer())


def write_mesh(motion: MeshMotion, path: str | PathLike[str]) -> list[Path]:
    """Write frames of a mesh and its contacts as VTK files (needs `slipmode[mesh]`).

    Nodes have a "displacement" [m], to warp by. The nodes of contacts are cells of their own,
    vertices, whose "state" is 0 stuck, 1 slipping, 2 open; the "state" of other cells is -1.
    Returns the files. Raises SlipmodeError if the path ends otherwise, or meshio is not installed;
    OSError if a file cannot be written.

    Parameters
    ----------
    motion : MeshMotion
    path : path
        Ending in .vtu. Each of several frames gets a file, NAME_000.vtu and so on, which
        ParaView opens as one series.
    """
    target = Path(path)
    if target.suffix != ".vtu":
        raise SlipmodeError(f"path: must end in .vtu, got {target.name}")
    meshio = extra("meshio", "mesh")
    files = [target]
    if len(motion.time) > 1:
        files = [target.with_stem(f"{target.stem}_{k:03}") for k in range(len(motion.time))]
    node, contact = motion.contact_nodes()
    blocks = [(_KINDS[motion.cells.shape[1]], motion.cells), ("vertex", node[:, np.newaxis])]
    none = np.full(len(motion.cells), -1, dtype=np.int32)
    for file, u, state in zip(files, motion.displacement, motion.state, strict=True):
        states = [none, state[contact].astype(np.int32)]
        mesh = meshio.Mesh(
            motion.nodes, blocks, point_data={"displacement": u}, cell_data={"state": states}
        )
        with replacing(file) as stream:
            meshio.write(stream.name, mesh, "vtu")  # it opens files by name alone
    return files
