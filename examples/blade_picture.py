"""The shipped scene "blade" in one picture: input and answer; needs `slipmode[pictures]`.

python examples/blade_picture.py [PICTURE]
"""

import sys
from itertools import pairwise
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

sys.path.insert(0, str(Path(__file__).parent))
from meshed_blade import PLATFORM, STEM, X, Y

from slipmode import runner
from slipmode.runner.validation.validate import validate

TIP = 202  # the DOF that the scene forces
A, B, FULL = "#1f5fa8", "#c2570c", "#212529"


def sketch(axes: Axes) -> None:
    """The mesh, clamped at its root; forces at the tip, dampers under the platform [mm]."""
    for left, right in pairwise(1e3 * X):
        for low, high in pairwise(1e3 * Y):
            if max(-left, right) <= 1e3 * STEM or low == 1e3 * PLATFORM[0]:
                cell = (left, low), right - left, high - low
                axes.add_patch(Rectangle(*cell, facecolor="#dee2e6", edgecolor="#868e96", lw=0.5))
    axes.add_patch(Rectangle((-20, -8), 40, 8, facecolor="none", edgecolor=FULL, hatch="////"))
    for height, colour, force in ((182, A, "6 N, 317 Hz"), (168, B, "25 N, 1685 Hz")):
        axes.annotate("", (0, height), (-30, height), arrowprops={"color": colour, "width": 1.5})
        axes.text(9, height, force, color=colour, va="center", fontsize=10)
    for side, preload in ((-1, "16 N"), (1, "24 N")):
        axes.plot([35 * side, 47 * side], [40, 28], color="#2b8a3e", lw=5)
        axes.text(38 * side, 10, preload, color="#2b8a3e", ha="center", fontsize=10)
    axes.text(12, 75, "dampers,\nfriction 0.4", color="#2b8a3e", fontsize=10)
    axes.set(aspect="equal", xlim=(-60, 75), ylim=(-12, 195), title="Input: mesh, dampers, forces")
    axes.axis("off")


def draw(picture: str = "docs/blade.png") -> None:
    """Input, amplitudes in slow time, and friction of the dampers beside full order."""
    scene, folder = runner.load_scene("blade"), mkdtemp()
    recording = runner.run(scene, folder)
    validation = validate(scene, folder)
    modes = runner.load(recording.mcap)["/modes"]
    compared = runner.load(validation.recordings[0])
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    structure, slow, loops = figure.subplots(1, 3, width_ratios=(0.9, 1.2, 1.2))
    sketch(structure)
    shapes = np.abs(recording.plan.excited.reduced.mode_shapes[TIP])
    for name, colour, phi in zip("AB", (A, B), shapes, strict=True):
        tip = 2e3 * phi * modes.column(f"{name}_abs")
        slow.plot(modes.time, tip, color=colour, lw=2)
        slow.text(0.95 * modes.time[-1], tip[-1] + 0.02, f"mode {name}", color=colour, ha="right")
    slow.set(title="Answer: vibration of the tip", xlabel="time [s]", ylabel="amplitude [mm]")
    for prefix, style in (
        ("", {"color": "#2b8a3e", "lw": 2}),
        ("/full", {"color": FULL, "ls": ":"}),
    ):
        contact = compared[f"{prefix}/contact/1"]
        label = "full order" if prefix else "slipmode"
        loops.plot(1e6 * contact.column("x"), contact.column("f"), label=label, **style)
    loops.set(
        title="Answer: friction of the right damper", xlabel="slip [um]", ylabel="friction [N]"
    )
    loops.legend(loc="lower right")
    for axes in (slow, loops):
        axes.grid(alpha=0.4)
    figure.savefig(picture, dpi=140)


if __name__ == "__main__":
    draw(*sys.argv[1:])
