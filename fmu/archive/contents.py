"""The content of an .fmu file, read without loading it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

import numpy as np

from slipmode.fmu.archive.binaries import host_platform, library_path
from slipmode.fmu.archive.resources import IDENTITY
from slipmode.rom import SlipmodeError
from slipmode.rom.extras import extra

fmpy = extra("fmpy", "fmu")
settable_in_instantiated = extra("fmpy.simulation", "fmu").settable_in_instantiated

_REAL = {"2.0": "Real", "3.0": "Float64"}


class Archive:
    """An FMU for Co-Simulation that can be loaded on this machine.

    Parameters
    ----------
    path : path
        The .fmu file.

    Attributes
    ----------
    path : Path
    description : fmpy.model_description.ModelDescription
    fmi : str
        Version of the standard.
    inputs, outputs : dict of str to int
        Value references of its scalar floating-point inputs and outputs.
    settable : tuple of str
        Names of variables that can be set before the initialization.
    identity : str
        Hash of its model by `resources.identity`; "" if it has none.
    amplitude_range : tuple of float
        Largest amplitudes of its friction table [kg^1/2 m], by mode; empty if it has none.

    Raises
    ------
    SlipmodeError
        If the file is not such an FMU.
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = Path(path)
        if not self.path.exists():
            raise SlipmodeError(f"{path}: no such FMU")
        if not zipfile.is_zipfile(self.path):
            raise SlipmodeError(f"{path}: not an FMU: it is no zip archive")
        try:
            self.description = fmpy.read_model_description(self.path)
        except Exception as error:  # fmpy's own are plain ones
            raise SlipmodeError(f"{path}: not a readable FMU: {error}") from None
        self.fmi = str(self.description.fmiVersion)
        if self.fmi not in _REAL:
            raise SlipmodeError(f"{path}: must be FMI {' or '.join(_REAL)}, not {self.fmi}")
        if self.description.coSimulation is None:
            raise SlipmodeError(f"{path}: must be for Co-Simulation, which this FMU is not")
        self._check_library()
        self.inputs = self._references("input")
        self.outputs = self._references("output")
        variables = self.description.modelVariables
        self.settable = tuple(v.name for v in variables if settable_in_instantiated(v))
        self.identity, self.amplitude_range = self._model()

    def require(self, names: Iterable[str], present: Iterable[str], words: str) -> None:
        """Raise SlipmodeError if a name is not among the present names, described by `words`."""
        found, shown_names = list(present), 12
        shown = ", ".join(found[:shown_names]) + (", ..." if len(found) > shown_names else "")
        for name in names:
            if name not in found:
                raise SlipmodeError(f"{self.path}: {name} is not among its {words}: {shown}")

    def _references(self, causality: str) -> dict[str, int]:
        return {
            variable.name: int(variable.valueReference)
            for variable in self.description.modelVariables
            if variable.causality == causality
            and variable.type == _REAL[self.fmi]
            and not variable.dimensions
        }

    def _check_library(self) -> None:
        host = host_platform()
        identifier = self.description.coSimulation.modelIdentifier
        library = library_path(host, int(self.fmi[0]), identifier)
        with zipfile.ZipFile(self.path) as archive:
            present = library in archive.namelist()
        if not present:
            platforms = ", ".join(fmpy.supported_platforms(self.path)) or "none"
            raise SlipmodeError(f"{self.path}: has no library for {host}, only for {platforms}")

    def _model(self) -> tuple[str, tuple[float, ...]]:
        """Return identity and amplitude range of an FMU that slipmode exported."""
        with zipfile.ZipFile(self.path) as archive:
            members = {f"resources/{name}" for name in (IDENTITY, "node_a.npy", "node_b.npy")}
            if not members <= set(archive.namelist()):
                return "", ()
            identity = archive.read(f"resources/{IDENTITY}").decode()
            nodes = [
                np.load(io.BytesIO(archive.read(f"resources/node_{mode}.npy"))) for mode in "ab"
            ]
        return identity, tuple(float(node[-1]) for node in nodes if node.size > 1)
