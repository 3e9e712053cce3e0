"""Files of an identification: report, backbones, pictures, model, scene and FMU."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slipmode.rom import Identification
from slipmode.rom.arrays import Complexes
from slipmode.rom.extras import extra
from slipmode.rom.files import replacing
from slipmode.rom.identification.first_look import demodulate
from slipmode.runner.fmi.export import export_fmu

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FORCING = """
[forcing.{mode}]                    # a force at the sensor; none in a free decay
dof = {channel}
amplitude = 0.0                # [N]
frequency = {frequency:.6g}
"""
_SCENE = """title = "Free decay of an identified law"

[model]
file = "model.npz"

[initial]                      # the largest measured amplitudes [kg^1/2 m]
{initial}
{forcing}
[run]
duration = {duration:.4g}                # [s]
step = {step:.3g}

[[elastic]]                    # motion at the sensors [m]
window = [0.0, {window:.3g}]

[output]
elastic = {channels}

[units]
frequency = "Hz"
"""


def write_files(
    found: Identification, text: str, folder: Path, modal_mass: Sequence[float] | None
) -> Iterator[Path]:
    """Write the files of an identification, and return their paths one by one.

    Raises SlipmodeError if a picture or the FMU cannot be made.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with replacing(folder / "report.txt") as file:
        file.write(f"{text}\n".encode())
    yield folder / "report.txt"
    _write_backbones(found, folder / "backbone.csv")
    yield folder / "backbone.csv"
    figures = extra("matplotlib.figure", "pictures")
    for name, draw in (("backbone", _draw_backbones), ("decays", _draw_decays)):
        figure = figures.Figure(figsize=(9, 7), layout="constrained")
        draw(found, figure)
        figure.savefig(folder / f"{name}.png", dpi=120)
        yield folder / f"{name}.png"
    model = found.model(modal_mass=modal_mass)
    model.save(folder / "model.npz")
    yield folder / "model.npz"
    factors = found.sensor_factors(modal_mass=modal_mass)
    with replacing(folder / "scene.toml") as file:
        file.write(_scene(found, factors).encode())
    yield folder / "scene.toml"
    yield export_fmu(folder / "scene.toml", folder / "model.fmu", progress=True)


def _scene(found: Identification, factors: Complexes) -> str:
    measurement = found.source.measurement
    omega = found.law.frequencies(*np.zeros((len(factors), 1)))[:, 0]
    period = 2.0 * np.pi / float(omega.min())
    largest = zip("AB", found.range[:, 1] / np.abs(factors), strict=False)
    channel = measurement.channels.index(found.channel)
    return _SCENE.format(
        initial="\n".join(f"{mode} = [{float(size)!r}, 0.0]" for mode, size in largest),
        forcing="".join(
            _FORCING.format(mode=mode, channel=channel, frequency=each / (2.0 * np.pi))
            for mode, each in zip("AB", omega, strict=False)
        ),
        duration=max(r.end - r.start for r in found.records),
        step=period,
        window=20.0 * period,
        channels=list(range(len(measurement.channels))),
    )


def _write_backbones(found: Identification, path: Path) -> None:
    columns = {}
    for mode in range(found.law.form.modes):
        curve, hertz, name = found.backbone(mode), 2.0 * np.pi, "AB"[mode]
        columns[f"{name} amplitude [{curve.unit}]"] = curve.amplitude
        columns[f"{name} frequency [Hz]"] = curve.frequency / hertz
        columns[f"{name} frequency deviation [Hz]"] = curve.frequency_deviation / hertz
        columns[f"{name} damping [-]"] = curve.damping
        columns[f"{name} damping deviation [-]"] = curve.damping_deviation
    with replacing(path) as file:
        numbers = np.column_stack(list(columns.values()))
        np.savetxt(file, numbers, delimiter=",", header=",".join(columns), comments="")


def _draw_backbones(found: Identification, figure: Figure) -> None:
    found.plot(figure.subplots(2, found.law.form.modes, sharex="col", squeeze=False))


def _draw_decays(found: Identification, figure: Figure) -> None:
    """Draw the envelopes of all records and their predictions from the first window."""
    source, modes = found.source, found.law.form.modes
    channel = source.measurement.channels.index(found.channel)
    axes = figure.subplots(modes, sharex=True, squeeze=False)[:, 0]
    used = [record for record in found.records if record.use != "excluded"]
    for k, report in enumerate(used):
        made = found.predict(report.name, extrapolate=True)
        label = report.name + (", held out" if report.use == "held out" else "")
        style = "--" if report.use == "held out" else "-"
        for mode, ax in enumerate(axes):
            measured = demodulate(
                made.record.signal,
                made.record.sample_rate,
                source.look.carrier[mode],
                source.plan.bands[mode],
            )
            size = np.abs(measured.values[channel])
            chosen = slice(None, None, max(size.size // 100, 1))
            ax.semilogy(measured.times[chosen], size[chosen], f"C{k % 10}.", ms=3)
            ax.semilogy(made.times, made.amplitude[:, mode], f"C{k % 10}{style}", label=label)
    for mode, ax in enumerate(axes):
        ax.set_ylabel(f"|{'AB'[mode]}| [{source.measurement.unit}]")
        ax.set_ylim(bottom=0.5 * found.range[mode, 0])
    axes[0].set_title("measured envelopes (points), predictions from the first window (lines)")
    axes[0].legend(fontsize="small", ncols=3)
    axes[-1].set_xlabel("time [s]")
