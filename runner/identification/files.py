"""Files of an identification: report, backbones, pictures, model, scene and FMU."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from slipmode.rom import Identification, IdentifiedLaw, SineIdentification
from slipmode.rom.arrays import Complexes
from slipmode.rom.storage.files import replacing
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.identification.pictures import pictures
from slipmode.runner.identification.report import model_samples

# Initial amplitudes of the scene and the FMU relative to the edge of the table. Solvers of Model
# Exchange evaluate derivatives beyond the present state as well, and a force needs room.
START = 0.95
_FORCING = """
[forcing.{mode}]                    # a force at the sensor; none in a free decay
dof = {channel}
amplitude = 0.0                # [N]
frequency = {frequency:.6g}
"""
_SCENE = """title = "Free decay of an identified law"

[model]
file = "model.npz"

[initial]                      # {start:.0%} of the largest measured amplitudes [kg^1/2 m]
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
    found: Identification | SineIdentification,
    text: str,
    folder: Path,
    modal_mass: Sequence[float] | None,
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
    yield from pictures(found, folder)
    model = found.model(modal_mass=modal_mass, samples=model_samples(found)[0])
    model.save(folder / "model.npz")
    yield folder / "model.npz"
    factors = found.sensor_factors(modal_mass=modal_mass)
    with replacing(folder / "scene.toml") as file:
        file.write(_scene(found, factors).encode())
    yield folder / "scene.toml"
    yield export_fmu(folder / "scene.toml", folder / "model.fmu", progress=True)


def _scene(found: Identification | SineIdentification, factors: Complexes) -> str:
    omega = found.law.frequencies(*np.zeros((len(factors), 1)))[:, 0]
    period = 2.0 * np.pi / float(omega.min())
    start = zip("AB", START * found.range[:, 1] / np.abs(factors), strict=False)
    channel = found.channels.index(found.channel)
    if isinstance(found, Identification):
        duration = max(r.end - r.start for r in found.records)
    else:  # until the smallest measured amplitude, or before
        low, high = found.range[0]
        duration = float(np.log(high / low) / found.law.damping_rates(np.array(low))[0])
    return _SCENE.format(
        initial="\n".join(f"{mode} = [{float(size)!r}, 0.0]" for mode, size in start),
        start=START,
        forcing="".join(
            _FORCING.format(mode=mode, channel=channel, frequency=each / (2.0 * np.pi))
            for mode, each in zip("AB", omega, strict=False)
        ),
        duration=duration,
        step=period,
        window=20.0 * period,
        channels=list(range(len(found.channels))),
    )


def _write_backbones(found: IdentifiedLaw, path: Path) -> None:
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
