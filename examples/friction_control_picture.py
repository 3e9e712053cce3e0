"""The recordings of friction_control.py as a picture; needs `pip install 'slipmode[pictures]'`.

python examples/friction_control_picture.py [FOLDER OF THE RECORDINGS] [PICTURE]
"""

import sys
from pathlib import Path

from matplotlib.figure import Figure

from slipmode import runner

FIXED, CONTROLLED, FORCING = "#868e96", "#1f5fa8", "#c92a2a"


def draw(folder="logs", picture="docs/friction-control.png"):
    """|A| and friction limit of the two runs, and the forcing of both, over time."""
    fixed = runner.read(Path(folder) / "friction_control.mcap").channels
    controlled = runner.read(Path(folder) / "controlled.mcap").channels
    time = controlled["/modes"][1]
    force, frequency = controlled["/forcing"][2].T[:2]
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    largest = [each["/modes"][2][:, -1].max() for each in (controlled, fixed)]
    title = "Controlled friction limit: peak |A| {:.3g} instead of {:.3g} kg$^{{1/2}}$ m"
    figure.suptitle(title.format(*largest), x=0.01, ha="left", fontsize=11)
    amplitude, limit, forcing = figure.subplots(3, sharex=True, height_ratios=(3, 2, 2))
    amplitude.plot(time, fixed["/modes"][2][:, -1], color=FIXED, label="fixed friction limit")
    amplitude.plot(time, controlled["/modes"][2][:, -1], color=CONTROLLED, label="controlled")
    amplitude.set_ylabel("|A| [kg$^{1/2}$ m]")
    amplitude.legend(frameon=False)
    for panel in (amplitude, limit, forcing):
        panel.grid(color="#dddddd", linewidth=0.5)
    limit.axhline(1.0, color=FIXED)
    limit.plot(time, controlled["/control"][2][:, 0], color=CONTROLLED)
    limit.set_ylabel("friction limit,\nrelative")
    forcing.plot(time, force, color=FORCING)
    forcing.set(xlabel="time [s]", xlim=(0.0, time[-1]))
    forcing.set_ylabel("force [N]", color=FORCING)
    sweep = forcing.twinx()
    sweep.plot(time, frequency, color="black", linewidth=1.0)
    sweep.set_ylabel("frequency [rad/s]")
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    draw(*sys.argv[1:])
