"""A model as an FMU: one zip archive that any FMI tool loads."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import fields, replace
from importlib.metadata import files
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from slipmode.fmu.archive import binaries
from slipmode.fmu.archive.resources import resource_files
from slipmode.fmu.component import Component, findings_of
from slipmode.fmu.description.documentation import contact_count, icon_png, index_html
from slipmode.fmu.description.options import MODEL_IDENTIFIER, ExportOptions
from slipmode.fmu.description.reference_result import reference_files
from slipmode.fmu.description.xml_files import (
    Fmi2Description,
    Fmi3Description,
    build_description,
    terminals_xml,
)
from slipmode.fmu.handle import ComponentOptions, takes
from slipmode.fmu.inputs import present_modes
from slipmode.fmu.variables.listing import list_variables
from slipmode.rom import Model, SlipmodeError
from slipmode.rom.files import replacing
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.validity import Finding, carrier_findings, warn


@takes(ExportOptions)
def export(
    model: Model,
    path: str | PathLike[str],
    force_patterns: ForcePatterns | None = None,
    **options: Any,
) -> Path:
    """Write a model as an FMU for Co-Simulation and Model Exchange, and return its path.

    Parameters
    ----------
    model : Model
    path : path
        The .fmu file; replaced if it exists.
    force_patterns : sequence of {DOF: amplitude} or (n,) array_like, one per mode, optional
        As for `Component`: the forces that a force input of 1 N represents. Default: the input is
        the modal force [N kg^-1/2].
    fmi : {2, 3}
        Version of the standard: 2.0 for older tools, else 3.0 (default).
    platforms : sequence of str
        Platforms in addition to this machine's, of "x86_64-linux", "aarch64-linux",
        "x86_64-windows", "x86_64-darwin" and "aarch64-darwin"; needs the extra
        `slipmode[platforms]`.
    contact, elastic, mode_names, tolerance, warned
        As for `Component`.
    name : str
        Name of the model in tools: one line without control characters.
    start : mapping of str to float
        Start values by variable name, such as {"force_A": 0.15, "A_re": 0.5}.
    largest_force : mapping of str to float
        Largest magnitudes by name of the input, such as {"force_A": 0.3}. The inputs declare them
        as their range, because importers cannot know the range of the friction table.
    stop_time, step_size : float
        Default experiment [s]; default 100 and 1.
    reference_step : float
        Interval of the reference result inside the file [s]; default: `step_size`.
    stimuli : Stimuli
        Inputs of the reference result; default: they keep their start values.
    origin : Origin
        Author, copyright and license of the model, and when it was made; default: none of them is
        written, and the same model gives the same bytes.

    Raises
    ------
    SlipmodeError
        On arguments that are not allowed.

    Warns
    -----
    ValidityWarning
        As `Component` does, and if the frequencies of `start` and `stimuli` are far from their
        mode. The documentation inside the FMU lists these warnings.
    """
    chosen = ExportOptions(**{key: value for key, value in options.items() if value is not None})
    chosen = replace(chosen, mode_names=present_modes(model, chosen.mode_names))
    if force_patterns is not None:
        check_force_patterns(model, AppliedForces.of(model.reduced, force_patterns))
    shared = {field.name: getattr(chosen, field.name) for field in fields(ComponentOptions)}
    component = Component(model, force_patterns, **shared | {"warned": False})
    variables = list_variables(model, force_patterns is not None, chosen)
    resources = resource_files(model, force_patterns, chosen, variables)
    if chosen.fmi == 2:
        variables = [v for v in variables if v.size is None]
    sources = binaries.source_files(chosen.fmi)
    description = (Fmi2Description if chosen.fmi == 2 else Fmi3Description)(
        options=chosen,
        variables=variables,
        summary=_summary(model),
        token=resources["token.txt"].decode(),
        sources=[source for source in sources if source.endswith(".c")],
    )
    host = binaries.host_platform()
    libraries = {host: binaries.host_binary()}
    others = [platform for platform in chosen.platforms if platform != host]
    libraries |= {platform: binaries.platform_binary(platform) for platform in others}
    paths = {at: binaries.library_path(at, chosen.fmi, MODEL_IDENTIFIER) for at in libraries}
    content = {
        "modelDescription.xml": description.to_bytes(),
        **{paths[at]: library for at, library in libraries.items()},
        **{f"resources/{file}": content for file, content in resources.items()},
        **{f"sources/{file}": source.read_bytes() for file, source in sources.items()},
        "documentation/licenses/slipmode.txt": _license(),
        "model.png" if chosen.fmi == 2 else "terminalsAndIcons/icon.png": icon_png(),
        **reference_files(component, variables, chosen),
    }
    # after the reference result, which refuses start values that nothing can follow
    findings = [*findings_of(model, chosen.mode_names), *_forcing_findings(model, chosen)]
    if chosen.warned:
        warn(findings)
    content["documentation/index.html"] = index_html(model, description, findings)
    if chosen.fmi == 3:
        content["terminalsAndIcons/terminalsAndIcons.xml"] = terminals_xml(variables)
        content["sources/buildDescription.xml"] = build_description(description.sources)
    _write(Path(path), content)
    return Path(path)


def _forcing_findings(model: Model, options: ExportOptions) -> list[Finding]:
    """Report frequencies of the start values and of the stimuli that are far from their mode."""
    modes, stimuli, omega = options.mode_names, options.stimuli, model.reduced.frequency
    names = [f"frequency_{mode}" for mode in modes]
    reached = np.array([[options.start.get(*each) for each in zip(names, omega, strict=True)]])
    if stimuli is not None and set(names) <= set(stimuli.names):
        columns = [list(stimuli.names).index(name) for name in names]
        reached = np.vstack((reached, stimuli.values[:, columns]))
    return carrier_findings("frequency_{}", modes, omega, reached)


def _summary(model: Model) -> str:
    modes = "one mode" if model.modes == 1 else "two modes"
    count = contact_count(model)
    contacts = f"{count} dry-friction contact{'s' if count > 1 else ''}"
    way = f"in slow time, {model.reduced.formulation} formulation"
    return f"Amplitudes of {modes} of a structure with {contacts} {way}"


def _license() -> bytes:
    """Return the license of slipmode and of its library in the FMU."""
    listed = [file for file in files("slipmode") or [] if file.name == "LICENSE"]
    if not listed:
        raise SlipmodeError("LICENSE: missing in the installed package; install slipmode again")
    return listed[0].read_binary()


def _write(target: Path, files: Mapping[str, bytes]) -> None:
    with replacing(target) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            entry = zipfile.ZipInfo(name)  # dated 1980: the same model gives the same bytes
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, files[name])
