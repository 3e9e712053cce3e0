"""What is in an .fmu file, read without loading it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

import numpy as np

from slipmode.fmu.archive.binaries import extension, folder, host_platform
from slipmode.fmu.archive.resources import IDENTITY
from slipmode.rom import SlipmodeError
from slipmode.rom.extras import extra

fmpy = extra("fmpy", "fmu")
settable_in_instantiated = extra("fmpy.simulation", "fmu").settable_in_instantiated

_REAL = {"2.0": "Real", "3.0": "Float64"}
_MOST_NAMES = 12  # in a message


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
        What can be given a value before the initialization.
    identity : str
        Which model it holds, as `resources.identity` has it; "" if it does not say.
    amplitude_range : tuple of float
        How far its friction table goes [kg^1/2 m], by mode; empty if it does not say.

    Raises
    ------
    SlipmodeError
        If the file is no such FMU.
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
        """Refuse if one of the names is not among those present, which `words` describe."""
        found = list(present)
        shown = ", ".join(found[:_MOST_NAMES]) + (", ..." if len(found) > _MOST_NAMES else "")
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
        name = f"{self.description.coSimulation.modelIdentifier}{extension(host)}"
        library = f"binaries/{folder(host, int(self.fmi[0]))}/{name}"
        with zipfile.ZipFile(self.path) as archive:
            present = library in archive.namelist()
        if not present:
            platforms = ", ".join(fmpy.supported_platforms(self.path)) or "none"
            raise SlipmodeError(f"{self.path}: has no library for {host}, only for {platforms}")

    def _model(self) -> tuple[str, tuple[float, ...]]:
        """Identity and amplitude range of an FMU of ours."""
        with zipfile.ZipFile(self.path) as archive:
            members = {f"resources/{name}" for name in (IDENTITY, "node_a.npy", "node_b.npy")}
            if not members <= set(archive.namelist()):
                return "", ()
            identity = archive.read(f"resources/{IDENTITY}").decode()
            nodes = [
                np.load(io.BytesIO(archive.read(f"resources/node_{mode}.npy"))) for mode in "ab"
            ]
        return identity, tuple(float(node[-1]) for node in nodes if node.size > 1)
