"""The curves of "square-plate" as a picture: a force that rotates moves two close modes.

python examples/square_plate_picture.py [PICTURE]
"""

import sys

import numpy as np
from matplotlib.figure import Figure

from slipmode import rom, runner

POINTS = {13: 1.0, 8: -1j}  # the second a quarter of a period later
FORCES, SPAN = (0.05, 1.0), (268.0, 288.0)  # the damper sticks, slips [N]; [Hz]
SHOWN = (273.0, 274.2, 275.2, 276.5, 279.0)  # frequencies of the orbits [Hz]


def curves() -> tuple[rom.ToneModel, list[rom.ToneCurve]]:
    """The model, and its curves under both forces."""
    plate = rom.load_structure(runner.shipped_scenes()["square-plate"].with_suffix(".npz"))
    damper = rom.Jenkins(limit=0.8, stiffness=1e4)
    reduced = rom.reduce(plate, modes=(1, 2), law=damper, tones=(0, 0))
    model = rom.tabulate(reduced, damper)
    ends = 2 * np.pi * np.array(SPAN)
    forces = [{dof: F * part for dof, part in POINTS.items()} for F in FORCES]
    return model, [rom.response_curve(model, [0.0], [f], "frequency_A", ends) for f in forces]


def draw(picture: str = "docs/square-plate.png") -> None:
    """Amplitudes per force, and the motion of both modes over a period."""
    model, found = curves()
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for force, curve, style in zip(FORCES, found, (":", "-"), strict=True):
        for k, colour in enumerate(("C0", "C1")):
            size = 1e6 * np.abs(curve.amplitude[:, k]) / force
            label = f"|{curve.modes[k]}|, {force:g} N"
            left.plot(curve.frequency / (2 * np.pi), size, style, color=colour, label=label)
    turn = np.exp(1j * np.linspace(0, 2 * np.pi, 200))
    for hertz in SHOWN:
        pair = rom.steady(model, [2 * np.pi * hertz], [POINTS])
        shade = str(0.85 * (SHOWN[-1] - hertz) / (SHOWN[-1] - SHOWN[0]))
        right.plot(*(2e6 * np.outer(pair, turn).real), color=shade, label=f"{hertz:g} Hz")
    left.set(xticks=np.arange(268, 289, 4), xlabel="excitation [Hz]")
    left.set(ylabel=r"amplitude per force [$10^{-6}$ kg$^{1/2}$ m/N]")
    right.set(xlabel="mode A, 1 N", ylabel="mode A2, 1 N", aspect="equal")
    left.legend(frameon=False), right.legend(frameon=False, loc="upper left", fontsize=8)
    figure.savefig(picture, dpi=120)


if __name__ == "__main__":
    draw(*sys.argv[1:])
