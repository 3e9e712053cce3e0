"""Report, picture and contacts for scenes of a law that was fitted to measured loops."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from textwrap import wrap

from slipmode.rom import LoopFit
from slipmode.rom.laws.law_record import record_of
from slipmode.rom.short_repr import percentage
from slipmode.rom.storage.files import replacing
from slipmode.runner.pictures import page_figure

_UNITS = {"stiffness": "N/m", "spring": "N/m", "backlash": "m", "limit": "N"}


def loop_report(found: LoopFit) -> str:
    """Return the report: model, errors, parameters with intervals, contacts for scenes."""
    width = max(len("loop"), *map(len, found.error))
    lines = [f"model: {found.model}"]
    tried = ", ".join(f"{name} {percentage(error)}" for name, error in found.tried.items())
    lines += wrap(f"rms errors of the tried models: {tried}", 95, subsequent_indent="    ")
    lines += [
        "",
        f"{'loop':{width}}  {'error of model':>14}  {'of contact law':>14}  constant force",
    ]
    for name, error in found.error.items():
        errors = f"{percentage(error):>14}  {percentage(found.law_error[name]):>14}"
        lines.append(f"{name:{width}}  {errors}  {found.mean_force[name]:.4g} N")
    lines += [
        "errors are rms over the loop, relative to its peak force; the constant force acts in "
        "addition to the contact law",
        "",
        _parameters(found),
    ]
    lines += ["", *(f"note: {line}" for line in found.warnings)] if found.warnings else []
    for name in found.laws:
        lines += ["", f"contacts of a scene, {name}:", contacts_table(found, name)]
    return "\n".join(lines)


def _parameters(found: LoopFit) -> str:
    width = max(map(len, found.parameters))
    lines = [f"{'parameter':{width}}  {'value':>10}  {'99 % interval':>24}"]
    for name, value in found.parameters.items():
        low, high = found.interval[name]
        interval = f"{low:.4g} to {high:.4g}" if high < float("inf") else "not determined"
        unit = _UNITS.get(name.rpartition(".")[2].partition("_")[0], "-")
        lines.append(f"{name:{width}}  {value:10.4g}  {interval:>24}  {unit}")
    return "\n".join(lines)


def contacts_table(found: LoopFit, name: str) -> str:
    """Return the contact law of a loop as a table of a scene."""
    values = record_of(found.laws[name])
    law = values.pop("law")
    return "\n".join(
        ["[[contacts]]", f'law = "{law}"', *(f"{key} = {value}" for key, value in values.items())]
    )


def write_loop_files(found: LoopFit, folder: Path) -> Iterator[Path]:
    """Write report, picture, and contacts of each loop; yield the paths one by one."""
    folder.mkdir(parents=True, exist_ok=True)
    with replacing(folder / "report.txt") as file:
        file.write(f"{loop_report(found)}\n".encode())
    yield folder / "report.txt"
    errors = ", ".join(f"{name} {percentage(error)}" for name, error in found.error.items())
    with page_figure(
        folder / "loops.png", f"Rms error of the peak force: {errors}", 3.5
    ) as figure:
        found.plot(figure.subplots(1, len(found.error)))
    yield folder / "loops.png"
    for name in found.laws:
        path = folder / f"contacts_{name}.toml"
        with replacing(path) as file:
            file.write(f"{contacts_table(found, name)}\n".encode())
        yield path
