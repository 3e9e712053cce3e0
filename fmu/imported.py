"""An FMU as a component: an FMU file that is read, and stepped like `fmu.Component`, by FMPy."""

from __future__ import annotations

import io
import shutil
import tempfile
import threading
import weakref
import zipfile
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from ctypes import byref
from itertools import count
from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np

from slipmode.fmu.archive.binaries import host_platform, library_path
from slipmode.fmu.archive.resources import IDENTITY
from slipmode.fmu.stepping import StoppedError
from slipmode.rom import SlipmodeError
from slipmode.rom.arrays import Floats, as_number
from slipmode.rom.errors import one_line_reason
from slipmode.rom.extras import extra
from slipmode.rom.storage.stored_arrays import check_unpacked_size, read_npy

fmpy = extra("fmpy", "fmu")
fmi1 = extra("fmpy.fmi1", "fmu")
fmi2 = extra("fmpy.fmi2", "fmu")
logging = extra("fmpy.logging", "fmu")
simulation = extra("fmpy.simulation", "fmu")


class Archive:
    """An FMU for Co-Simulation that can be loaded on this machine.

    Raises SlipmodeError if the file is not such an FMU.

    Attributes
    ----------
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
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = Path(path)
        if not self.path.exists():
            raise SlipmodeError(f"{path}: no such FMU")
        if not zipfile.is_zipfile(self.path):
            raise SlipmodeError(f"{path}: is not an FMU, because it is not a zip archive")
        try:
            with zipfile.ZipFile(self.path) as archive:
                check_unpacked_size(archive, self.path.stat().st_size)
            self.description = fmpy.read_model_description(self.path)
        except Exception as error:  # fmpy raises plain exceptions
            raise SlipmodeError(f"{path}: is not a readable FMU: {error}") from None
        self.fmi = str(self.description.fmiVersion)
        if self.fmi not in ("2.0", "3.0"):
            raise SlipmodeError(f"{path}: must be FMI 2.0 or 3.0, got {self.fmi}")
        if self.description.coSimulation is None:
            raise SlipmodeError(f"{path}: must be an FMU for Co-Simulation")
        self._check_library()
        self.inputs = self._references("input")
        self.outputs = self._references("output")
        variables = self.description.modelVariables
        self.settable = tuple(v.name for v in variables if simulation.settable_in_instantiated(v))
        self.identity, self.amplitude_range = self._model()

    def require(self, names: Iterable[str], present: Iterable[str], words: str) -> None:
        """Raise SlipmodeError if a name is not among the present names, described by `words`."""
        found = list(present)
        shown = ", ".join(found[:12]) + (", ..." if len(found) > 12 else "")
        for name in names:
            if name not in found:
                raise SlipmodeError(f"{self.path}: {name} is not among its {words}: {shown}")

    def _references(self, causality: str) -> dict[str, int]:
        variables = [v for v in self.description.modelVariables if v.causality == causality]
        numbers = [v for v in variables if v.type in ("Real", "Float64") and not v.dimensions]
        return {v.name: int(v.valueReference) for v in numbers}

    def _check_library(self) -> None:
        host = host_platform()
        identifier = self.description.coSimulation.modelIdentifier
        library = library_path(host, int(self.fmi[0]), identifier)
        if not zipfile.Path(self.path, library).exists():
            platforms = ", ".join(fmpy.supported_platforms(self.path)) or "none"
            raise SlipmodeError(f"{self.path}: has no library for {host}, only for {platforms}")

    def _model(self) -> tuple[str, tuple[float, ...]]:
        """Return identity and amplitude range of an FMU that slipmode exported."""
        with zipfile.ZipFile(self.path) as archive:
            members = {f"resources/{name}" for name in (IDENTITY, "node_a.npy", "node_b.npy")}
            if not members <= set(archive.namelist()):
                return "", ()
            try:
                identity = archive.read(f"resources/{IDENTITY}").decode()
                files = [archive.read(f"resources/node_{mode}.npy") for mode in "ab"]
                nodes = [read_npy(io.BytesIO(file), len(file)) for file in files]
                return identity, tuple(float(node[-1]) for node in nodes if node.size > 1)
            except Exception as error:  # damaged files make zipfile, zlib and numpy raise anything
                reason = one_line_reason(error)
                raise SlipmodeError(f"{self.path}: its model is damaged: {reason}") from None


class Log:
    """The last reason that an FMU logged for a refused call.

    FMPy formats the messages of FMI 2.0 in one function of the process, which passes all of them
    to the logger that it received last, even if that was freed. So there is one logger for all
    instances, `_route`, which lasts as long as the process and knows instances by environment.
    """

    def __init__(self) -> None:
        self._last = ""

    def write(self, *arguments: Any) -> None:
        """Logger of either version of the standard."""
        status, _, message = arguments[-3:]
        if status >= 2:  # discard, error or fatal
            self._last = message.decode(errors="replace")

    def reason(self, error: Exception) -> str:
        """Return the reason logged since the last reading, else the message of the error."""
        reason, self._last = self._last or str(error), ""
        return reason

    def callbacks(self) -> Any:
        """Return callback functions for an instance of FMI 2.0 that logs here."""
        environment = next(_environments)
        _logs[environment] = self
        # FMPy's memory functions last as long as the process too
        callbacks = fmi2.fmi2CallbackFunctions(
            logger=_route,
            allocateMemory=fmi2.defaultCallbacks.allocateMemory,
            freeMemory=fmi2.defaultCallbacks.freeMemory,
            componentEnvironment=environment,
        )
        logging.addLoggerProxy(byref(callbacks))
        return callbacks


_environments = count(1)
_logs: weakref.WeakValueDictionary[int, Log] = weakref.WeakValueDictionary()


def _to_its_log(environment: int | None, *arguments: Any) -> None:
    log = _logs.get(environment or 0)
    if log is None:
        fmi1.printLogMessage(environment, *arguments)
    else:
        log.write(*arguments)


_route = fmi2.fmi2CallbackLoggerTYPE(_to_its_log)


# FMPy changes the working directory of the process while it loads a library. Two threads at once
# would leave it changed.
_LOADING = threading.Lock()


class Imported:
    """An FMU for Co-Simulation, FMI 2.0 or 3.0, initialized and stepped like `Component`.

    Use it in a `with` block, or `close` it: its files are in a temporary folder.

    Parameters
    ----------
    archive : Archive or path
        The .fmu file.
    start : mapping of str to float or bool, optional
        Values of inputs, parameters and start values before the initialization, such as
        {"force_A": 0.15, "A_re": 0.5}; default: those in the file.

    Attributes
    ----------
    input_names, output_names : tuple of str
        Its scalar floating-point inputs; "time" and its scalar floating-point outputs.

    Raises
    ------
    SlipmodeError
        If the file is no FMU that can be loaded on this machine, or it refuses to start.
    """

    def __init__(
        self,
        archive: Archive | str | PathLike[str],
        start: Mapping[str, float | bool] | None = None,
    ) -> None:
        self._archive = archive if isinstance(archive, Archive) else Archive(archive)
        self._archive.require(start or (), self._archive.settable, "start values")
        self._inputs = self._archive.inputs
        self._outputs = list(self._archive.outputs.values())
        self.input_names = tuple(self._inputs)
        self.output_names = ("time", *self._archive.outputs)
        self._time = 0.0
        self._log = Log()
        self._resources = ExitStack()
        weakref.finalize(self, self._resources.close)
        try:
            self._instance = self._started(dict(start or {}))
        except Exception as error:  # fmpy raises plain exceptions
            self.close()
            raise SlipmodeError(f"{self._archive.path}: {self._log.reason(error)}") from None
        suffix = "Real" if self._archive.fmi == "2.0" else "Float64"
        self._get = getattr(self._instance, f"get{suffix}")
        self._set = getattr(self._instance, f"set{suffix}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the instance and its files. Closing again does nothing."""
        self._resources.close()

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; the others keep their values.

        Raises SlipmodeError if a name is unknown or the FMU refuses a value.
        """
        for name in values.keys() - self._inputs.keys():
            known = ", ".join(self._inputs)
            raise SlipmodeError(f"{name}: is not an input; inputs are {known}")
        numbers = [as_number(name, value) for name, value in values.items()]
        try:
            self._set([self._inputs[name] for name in values], numbers)
        except fmi1.FMICallException as error:
            raise SlipmodeError(self._log.reason(error)) from None

    def do_step(self, time: float, duration: float) -> None:
        """Advance from `time`, the present time, by `duration` > 0 [s].

        Raises StoppedError, with the reason that the FMU logged, if it refuses the step.
        """
        if not abs(time - self._time) <= 1e-9 * max(1.0, abs(self._time)):
            raise SlipmodeError(
                f"time: must be the present time of the FMU, {self._time:g} s, got {time:g} s"
            )
        try:
            self._advance(duration)
        except fmi1.FMICallException as error:
            raise self._stopped(error, np.empty((0, len(self.output_names)))) from None

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the present time, by name."""
        return dict(zip(self.output_names, self._row(), strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Advance by many steps with inputs (steps, inputs); return outputs (steps, outputs).

        Raises StoppedError, with the outputs of the steps before, if a step fails. The FMU keeps
        the inputs of the failed step.
        """
        references = list(self._inputs.values())
        outputs = np.empty((len(durations), len(self.output_names)))
        steps = zip(durations.tolist(), inputs.tolist(), strict=True)
        for done, (duration, values) in enumerate(steps):
            try:
                self._set(references, values)
                self._advance(duration)
                outputs[done] = self._row()
            except fmi1.FMICallException as error:
                raise self._stopped(error, outputs[:done]) from None
        return outputs

    def _advance(self, duration: float) -> None:
        self._instance.doStep(self._time, duration)
        self._time += duration

    def _row(self) -> list[float]:
        return [self._time, *self._get(self._outputs)]

    def _stopped(self, error: Exception, outputs: Floats) -> StoppedError:
        reason = self._log.reason(error)
        message = f"{self._archive.path.name}: stopped at t = {self._time:g} s: {reason}"
        return StoppedError(message, self._time, outputs)

    def _started(self, start: dict[str, float | bool]) -> Any:
        """Return an initialized instance, with its files in a temporary folder."""
        description, is_fmi2 = self._archive.description, self._archive.fmi == "2.0"
        unzipped = tempfile.mkdtemp(prefix="slipmode-")
        self._resources.callback(shutil.rmtree, unzipped, ignore_errors=True)
        fmpy.extract(self._archive.path, unzipped)
        with _LOADING:
            if is_fmi2:
                identifier = description.coSimulation.modelIdentifier
                instance = fmi2.FMU2Slave(
                    guid=description.guid, unzipDirectory=unzipped, modelIdentifier=identifier
                )
                instance.instantiate(callbacks=self._log.callbacks())
            else:
                instance = simulation.instantiate_fmu(
                    unzipped, description, "CoSimulation", logger=self._log.write
                )
        self._resources.callback(instance.freeInstance)
        settable = simulation.settable_in_instantiated
        simulation.apply_start_values(instance, description, start, settable)
        if is_fmi2:
            instance.setupExperiment(startTime=0.0)
        instance.enterInitializationMode(**({} if is_fmi2 else {"startTime": 0.0}))
        instance.exitInitializationMode()
        return instance
