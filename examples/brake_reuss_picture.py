"""A picture of what brake_reuss.py found: mode shape, contacts at rest, damped nonlinear mode.

python examples/brake_reuss_picture.py beam docs/brake-reuss.png
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

SCALE = 0.03  # largest displacement shown [m]
COLOURS = np.array(["tab:green", "tab:orange", "tab:red"])
STATES = ("stuck", "slipping", "open")
_FACES = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
)


def skin(cells: np.ndarray) -> np.ndarray:
    """The faces (k, 4) that one cell alone has."""
    faces = cells[:, _FACES].reshape(-1, 4)
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return faces[first[count == 1]]


def draw(folder: Path, picture: Path) -> None:
    """Three panels."""
    with np.load(folder / "found.npz") as found:
        x, shape, cells = found["nodes"], found["shape"], found["cells"]
        state, pressure, place = found["state"], found["pressure"], found["position"]
        a, frequency, damping = found["curve"]
    figure = plt.figure(figsize=(11, 7), layout="constrained")
    panels = figure.add_gridspec(2, 3, height_ratios=(1.1, 1))
    view = figure.add_subplot(panels[0, :], projection="3d")
    moved = x + shape * SCALE / np.abs(shape).max()
    view.add_collection3d(
        Poly3DCollection(moved[skin(cells)], facecolor="0.85", edgecolor="0.6", linewidth=0.05)
    )
    low, high = moved.min(axis=0), moved.max(axis=0)
    view.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    view.set_box_aspect((high - low) * (1, 1.5, 1.5), zoom=1.6)
    view.view_init(elev=15, azim=-75)
    view.set_axis_off()
    view.set_title("first bending mode, contacts stuck")
    for values, panel, title in (
        (None, panels[1, 0], "contacts at rest"),
        (pressure, panels[1, 1], "contact pressure [MPa]"),
    ):
        axes = figure.add_subplot(panel, title=title, xlabel="x [mm]", ylabel="y [mm]")
        if values is None:
            for k, name in enumerate(STATES):
                own = 1e3 * place[state == k]
                axes.scatter(own[:, 0], own[:, 1], 40, COLOURS[k], label=f"{len(own)} {name}")
            axes.legend(fontsize=7, loc="upper center", ncols=3)
            axes.set_ylim(top=17)
        else:
            dots = axes.scatter(1e3 * place[:, 0], 1e3 * place[:, 1], 40, values)
            figure.colorbar(dots)
    axes = figure.add_subplot(panels[1, 2], title="damped nonlinear mode", xscale="log")
    axes.plot(2 * a, frequency / (2 * np.pi), label="frequency [Hz]")
    axes.set(xlabel="modal amplitude [kg^1/2 m]", ylabel="frequency [Hz]")
    other = axes.twinx()
    other.plot(2 * a, 100 * damping, "tab:red")
    other.set_ylabel("damping [%]", color="tab:red")
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
