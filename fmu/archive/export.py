"""A model as an FMU: one zip archive that any FMI tool loads."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from importlib.metadata import files, version
from math import isfinite
from os import PathLike
from pathlib import Path

import numpy as np

from slipmode.fmu.archive import binaries
from slipmode.fmu.archive import cross_compiler as cross
from slipmode.fmu.archive.resources import resource_files
from slipmode.fmu.component import Component, findings_of
from slipmode.fmu.description.description import (
    MODEL_IDENTIFIER,
    Description,
    Experiment,
    FmiVersion,
    Origin,
)
from slipmode.fmu.description.documentation import contact_count, icon_png, index_html
from slipmode.fmu.description.fmi2 import Fmi2Writer
from slipmode.fmu.description.fmi3 import Fmi3Writer, build_description
from slipmode.fmu.description.reference_result import Stimuli, reference_files
from slipmode.fmu.description.terminals import terminals_xml
from slipmode.fmu.inputs import MODE_NAMES, present_modes
from slipmode.fmu.variables.listing import Choice, list_variables
from slipmode.rom import Model, SlipmodeError
from slipmode.rom.error_budget import SLOW_FLOW
from slipmode.rom.files import replacing
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.text import checked_line
from slipmode.rom.validity import Finding, carrier_findings, warn

_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same model gives the same bytes


def export(
    model: Model,
    path: str | PathLike[str],
    force_patterns: ForcePatterns | None = None,
    *,
    fmi: FmiVersion = 3,
    platforms: Sequence[str] = (),
    contact: bool = False,
    elastic: Sequence[int] = (),
    mode_names: Sequence[str] = MODE_NAMES,
    name: str = "slipmode",
    start: Mapping[str, float] | None = None,
    largest_force: Mapping[str, float] | None = None,
    stop_time: float = 100.0,
    step_size: float = 1.0,
    reference_step: float | None = None,
    stimuli: Stimuli | None = None,
    tolerance: float = SLOW_FLOW,
    origin: Origin | None = None,
) -> Path:
    """Write a model as an FMU for Co-Simulation and Model Exchange.

    Parameters
    ----------
    model : Model
    path : path
        The .fmu file; replaced if it exists.
    force_patterns : sequence of {DOF: amplitude} or (n,) array_like, one per mode, optional
        As `Component` has them: the forces that a force input of 1 N stands for. Default: the
        input is the modal force [N kg^-1/2].
    fmi : {2, 3}
        Version of the standard: 2.0 for older tools, else 3.0.
    platforms : sequence of str
        Platforms besides this machine's, of "x86_64-linux", "aarch64-linux", "x86_64-windows",
        "x86_64-darwin" and "aarch64-darwin"; needs the extra `slipmode[platforms]`.
    contact : bool
        Have contact displacement, velocity and force among the outputs; the model must keep
        harmonics for it, as `Component` says.
    elastic : sequence of int
        DOFs whose displacement is an output; needs `contact`.
    mode_names : sequence of str
        What the model's modes are called, of "A" and "B".
    name : str
        Of the model, as tools show it: one line without control characters.
    start : mapping of str to float, optional
        Start values by variable name, such as {"force_A": 0.15, "A_re": 0.5}.
    largest_force : mapping of str to float, optional
        Largest magnitudes by name of the input, such as {"force_A": 0.3}, which the inputs
        declare as their range; what the friction table can bear, importers cannot know.
    stop_time, step_size : float
        Default experiment [s].
    reference_step : float, optional
        Interval of the reference result inside the file [s]; default: `step_size`.
    stimuli : Stimuli, optional
        What the reference result does to the inputs; default: they stay as they start.
    tolerance : float
        Relative tolerance of the slow flow per internal step, 1e-13 to 1e-2.
    origin : Origin, optional
        Author, copyright and license of the model, and when it was made; default: nothing is
        said, and the same model gives the same bytes.

    Returns
    -------
    Path
        Of the FMU.

    Raises
    ------
    SlipmodeError
        On arguments that are not allowed.

    Warns
    -----
    ValidityWarning
        As `Component` does of the model, and where the frequencies of `start` and `stimuli` are
        far from their mode. The documentation inside the FMU lists these warnings.
    """
    target = Path(path)
    checked_line("name", name)
    if fmi not in (2, 3):
        raise SlipmodeError(f"fmi: must be 2 or 3, got {fmi}")
    interval = step_size if reference_step is None else reference_step
    for key, value in (
        *(("stop_time", stop_time), ("step_size", step_size), ("reference_step", interval)),
    ):
        if not (isfinite(value) and value > 0):
            raise SlipmodeError(f"{key}: must be a finite number > 0 [s], got {value}")
    modes = present_modes(model, mode_names)
    if force_patterns is not None:
        check_force_patterns(model, AppliedForces.of(model.reduced, force_patterns))
    component = Component(
        model,
        force_patterns,
        contact=contact,
        elastic=elastic,
        mode_names=modes,
        tolerance=tolerance,
        warned=False,
    )
    choice = Choice(
        mode_names=modes,
        newtons=force_patterns is not None,
        contact=contact,
        elastic=tuple(elastic),
        tolerance=tolerance,
        start=start or {},
        largest=largest_force or {},
    )
    variables = list_variables(model, choice)
    resources = resource_files(model, force_patterns, contact, elastic, variables)
    if fmi == 2:
        variables = [v for v in variables if v.size is None]
    sources = binaries.source_files(fmi)
    description = Description(
        name=name,
        description=_summary(model),
        version=version("slipmode"),
        token=resources["token.txt"].decode(),
        variables=variables,
        experiment=Experiment(stop_time, step_size, tolerance, interval),
        sources=[source for source in sources if source.endswith(".c")],
        origin=origin or Origin(),
    )
    writer = Fmi2Writer if fmi == 2 else Fmi3Writer
    host = binaries.host_platform()
    libraries = {host: binaries.host_binary()}
    libraries |= {other: cross.platform_binary(other) for other in platforms if other != host}
    content = {
        "modelDescription.xml": writer(description).to_bytes(),
        **{_library_path(at, fmi): library for at, library in libraries.items()},
        **{f"resources/{file}": content for file, content in resources.items()},
        **{f"sources/{file}": source.read_bytes() for file, source in sources.items()},
        "documentation/licenses/slipmode.txt": _license(),
        "model.png" if fmi == 2 else "terminalsAndIcons/icon.png": icon_png(),
        **reference_files(
            *(component, modes, choice.start, variables, description.experiment), stimuli
        ),
    }
    # after the reference result, which refuses start values that nothing can follow
    findings = [
        *findings_of(model, modes),
        *_forcing_findings(model, modes, choice.start, stimuli),
    ]
    warn(findings)
    page = index_html(name, model, variables, fmi, description.version, findings)
    content["documentation/index.html"] = page
    if fmi == 3:
        content["terminalsAndIcons/terminalsAndIcons.xml"] = terminals_xml(variables)
        content["sources/buildDescription.xml"] = build_description(description.sources)
    _write(target, content)
    return target


def _forcing_findings(
    model: Model, modes: Sequence[str], start: Mapping[str, float], stimuli: Stimuli | None
) -> list[Finding]:
    """Report frequencies of the start values and of the stimuli that are far from their mode."""
    names, omega = [f"frequency_{mode}" for mode in modes], model.reduced.frequency
    reached = np.array([[start.get(*each) for each in zip(names, omega, strict=True)]])
    if stimuli is not None and set(names) <= set(stimuli.names):
        columns = [list(stimuli.names).index(name) for name in names]
        reached = np.vstack((reached, stimuli.values[:, columns]))
    return carrier_findings("frequency_{}", modes, omega, reached)


def _library_path(platform_tuple: str, fmi: FmiVersion) -> str:
    name = f"{MODEL_IDENTIFIER}{binaries.extension(platform_tuple)}"
    return f"binaries/{binaries.folder(platform_tuple, fmi)}/{name}"


def _summary(model: Model) -> str:
    modes = "one mode" if model.modes == 1 else "two modes"
    contacts = contact_count(model)
    return (
        f"Amplitudes of {modes} of a structure with {contacts} dry-friction "
        f"contact{'s' if contacts > 1 else ''} in slow time, {model.reduced.formulation} "
        "formulation"
    )


def _license() -> bytes:
    """The license that slipmode, and its library in the FMU, come with."""
    listed = [file for file in files("slipmode") or [] if file.name == "LICENSE"]
    if not listed:
        raise SlipmodeError("LICENSE: missing in the installed package; install slipmode again")
    return listed[0].read_binary()


def _write(target: Path, files: Mapping[str, bytes]) -> None:
    with replacing(target) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, files[name])
