"""A picture of what brake_reuss.py found: contacts at rest, damped nonlinear mode.

    python examples/bolted_joints/brake_reuss_picture.py beam beam.png
    python examples/bolted_joints/brake_reuss_picture.py beam beam.png tmdsimpy_brb_epmc_flat.yaml

The file is a published curve, beside which ours is drawn.
"""

import json
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

COLOURS = ("tab:green", "tab:orange", "tab:red")
STATES = ("stuck", "slipping", "open")


def published_curve(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Modal amplitude [kg^1/2 m], frequency [Hz] and damping ratio."""
    lines = (line.partition(":") for line in path.read_text().splitlines())
    values = {key.strip(): np.array(json.loads(text)) for key, _, text in lines if "[" in text}
    frequency = values["frequency_rad_per_s"] / (2 * np.pi)
    return values["modal_amplitude"], frequency, values["damping_factor_frac_crit"]


def draw(folder: Path, picture: Path, published: Path | None = None) -> None:
    """Three panels."""
    with np.load(folder / "found.npz") as found:
        state, pressure, place = found["state"], found["pressure"], 1e3 * found["position"]
        a, omega, damping = found["curve"]
    curves = [("here", "-", 2 * a, omega / (2 * np.pi), damping)]
    if published is not None:
        curves.append(("published", ":", *published_curve(published)))
    figure, panels = plt.subplots(1, 3, figsize=(13, 3.6), layout="constrained")
    for axes, title in zip(panels, ("contacts at rest", "contact pressure [MPa]"), strict=False):
        axes.set(title=title, xlabel="x [mm]", ylabel="y [mm]")
    for k, name in enumerate(STATES):
        own = place[state == k]
        panels[0].scatter(own[:, 0], own[:, 1], 30, COLOURS[k], label=f"{len(own)} {name}")
    panels[0].legend(fontsize=7, loc="upper center", ncols=3)
    panels[0].set_ylim(top=17)
    figure.colorbar(panels[1].scatter(place[:, 0], place[:, 1], 30, pressure))
    panels[2].set(title="damped nonlinear mode", xscale="log")
    panels[2].set(xlabel="modal amplitude [kg^1/2 m]", ylabel="frequency, of the lowest amplitude")
    other = panels[2].twinx()
    other.set_ylabel("damping [%]", color="tab:red")
    for name, style, amplitude, frequency, ratio in curves:
        panels[2].plot(amplitude, frequency / frequency[0], style, color="tab:blue", label=name)
        other.plot(amplitude, 100 * ratio, style, color="tab:red")
    panels[2].legend(loc="center left")
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    draw(*map(Path, sys.argv[1:]))
