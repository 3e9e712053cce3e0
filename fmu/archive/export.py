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
from slipmode.fmu.component import Component
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
from slipmode.fmu.inputs import AnyModel, Inputs, present_modes
from slipmode.fmu.outputs import checked_findings
from slipmode.fmu.variables.listing import list_variables
from slipmode.rom import SlipmodeError, __version__
from slipmode.rom.reduction.force_response import ForcePatterns
from slipmode.rom.storage.files import replacing
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.validity import Finding, carrier_findings, warn


@takes(ExportOptions)
def export(
    model: AnyModel,
    path: str | PathLike[str],
    force_patterns: ForcePatterns | None = None,
    **options: Any,
) -> Path:
    """Write a model as an FMU for Co-Simulation and Model Exchange.

    If modes share a tone, the FMU is for Co-Simulation only, starts from rest, and has no
    derivatives.

    Parameters
    ----------
    model : Model or ToneModel
        Model from `rom.tabulate`, `rom.model_of_rates` or an identification.
    path : path
        Name of the .fmu file, which is replaced if it exists.
    force_patterns : sequence of {DOF: amplitude} or (n,) array_like, one per mode, optional
        Forces [N] for a force input of 1 N. Default: the input is the modal force [N kg^-1/2].
        Modes that share a tone need one per tone, [{DOF: amplitude}], possibly complex.
    contact : bool, default False
        Add the contact motion to the outputs, see `Component`.
    elastic : sequence of int
        DOFs whose displacement is an output; needs `contact`.
    mode_names : sequence of str, default ("A", "B")
        Names of the modes; ("B",) if the model has only mode B.
    tolerance : float, default 1e-6
        Relative tolerance of the slow flow in each internal step [-], 1e-13 to 1e-2.
    sample : int, default 0
        Start value of the parameter `sample`, for a model with samples, see `Component`.
    warned : bool, default True
        Warn of violated assumptions.
    fmi : {3, 2}
        Version of the standard: 3.0, or 2.0 for older tools.
    platforms : sequence of str
        Further platforms in addition to this machine: "x86_64-linux", "aarch64-linux",
        "x86_64-windows", "x86_64-darwin", "aarch64-darwin". Needs the extra `slipmode[platforms]`.
    name : str, default "slipmode"
        Name of the model in tools: one line without control characters.
    start : mapping of str to float
        Start values by name of the variable, such as {"force_A": 0.15, "A_re": 0.5}.
    largest_force : mapping of str to float
        Largest magnitude of force inputs by name [N], such as {"force_A": 0.3}. The FMU declares
        it as the range of the input, so that importers respect the range of the friction table.
    stop_time, step_size : float, default 100.0 and 1.0
        Default experiment [s].
    reference_step : float, optional
        Interval of the reference result in the file [s]. Default: `step_size`.
    stimuli : Stimuli, optional
        Inputs of the reference result. Default: constant start values.
    origin : Origin, optional
        Author, copyright, license and date of the model. Default: no origin is written, and equal
        models give files with equal bytes.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    SlipmodeError
        If an argument is not allowed. If the table does not include the quasi-static response of
        the contacts to these forces, and the resulting amplitude error exceeds its tolerance.

    Warns
    -----
    ValidityWarning
        If the model violates an assumption of the method, or a frequency of `start` or `stimuli`
        is far from its mode. The documentation in the FMU lists these warnings.

    Examples
    --------
    Write a model with a force input at DOF 0 in newtons::

        fmu.export(model, "beam.fmu", [{0: 1.0}], mode_names=("A",), start={"force_A": 0.15})
    """
    chosen = ExportOptions(**{key: value for key, value in options.items() if value is not None})
    chosen = replace(chosen, mode_names=present_modes(model, chosen.mode_names))
    findings = checked_findings(model, force_patterns, chosen.mode_names)
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
    findings += _forcing_findings(Inputs(model, force_patterns, chosen.mode_names), chosen)
    if chosen.warned:
        warn(findings)
    content["documentation/index.html"] = index_html(model, description, findings)
    if chosen.fmi == 3:
        content["terminalsAndIcons/terminalsAndIcons.xml"] = terminals_xml(variables)
        content["sources/buildDescription.xml"] = build_description(description.sources)
    _write(Path(path), content)
    return Path(path)


def _forcing_findings(inputs: Inputs, options: ExportOptions) -> list[Finding]:
    """Report frequencies of the start values and of the stimuli that are far from their mode."""
    natural, stimuli = inputs.natural, options.stimuli
    reached = np.array([[options.start.get(*each) for each in natural.items()]])
    if stimuli is not None and natural.keys() <= set(stimuli.names):
        columns = [list(stimuli.names).index(name) for name in natural]
        reached = np.vstack((reached, stimuli.values[:, columns]))
    omega = np.array(list(natural.values()))
    return carrier_findings("frequency_{}", inputs.carriers, omega, reached)


def _summary(model: AnyModel) -> str:
    modes = "one mode" if model.modes == 1 else "two modes"
    if isinstance(model, ToneModel):
        modes = (
            f"{model.modes} modes that share {('a tone', 'two tones')[model.reduced.tones - 1]}"
        )
    count = contact_count(model)
    contacts = f"{count} dry-friction contact{'s' if count > 1 else ''}"
    way = f"in slow time, {model.reduced.formulation} formulation"
    return f"Amplitudes of {modes} of a structure with {contacts} {way}"


def _license() -> bytes:
    """Return the license of slipmode and of its library in the FMU."""
    folders = ("licenses", f"slipmode-{__version__}.dist-info")
    listed = [
        file
        for file in files("slipmode") or []
        if file.name == "LICENSE" and file.parent.name in folders
    ]
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
