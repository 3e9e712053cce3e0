"""An FMU as a component: an FMU file that is stepped like `fmu.Component`, through FMPy."""

from __future__ import annotations

import shutil
import tempfile
import threading
import weakref
from collections.abc import Mapping
from contextlib import ExitStack
from os import PathLike
from typing import Any, Self

import numpy as np

from slipmode.fmu.archive.contents import Archive
from slipmode.fmu.import_log import Log
from slipmode.fmu.stepping import StoppedError
from slipmode.rom import SlipmodeError
from slipmode.rom.arrays import Floats
from slipmode.rom.extras import extra

fmpy = extra("fmpy", "fmu")
fmi2 = extra("fmpy.fmi2", "fmu")
simulation = extra("fmpy.simulation", "fmu")
FMICallException = extra("fmpy.fmi1", "fmu").FMICallException

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

        Raises
        ------
        SlipmodeError
            If a name is unknown or the FMU refuses a value.
        """
        for name in values:
            if name not in self._inputs:
                known = ", ".join(self._inputs)
                raise SlipmodeError(f"{name}: not an input; inputs are {known}")
        try:
            self._set([self._inputs[name] for name in values], list(values.values()))
        except FMICallException as error:
            raise SlipmodeError(self._log.reason(error)) from None

    def do_step(self, time: float, duration: float) -> None:
        """Advance from `time`, the present time, by `duration` > 0 [s].

        Raises
        ------
        StoppedError
            If the FMU refuses the step; the message has the reason that it logged.
        """
        if not abs(time - self._time) <= 1e-9 * max(1.0, abs(self._time)):
            raise SlipmodeError(f"time: the FMU stands at {self._time:g} s, not at {time:g} s")
        try:
            self._advance(duration)
        except FMICallException as error:
            raise self._stopped(error, np.empty((0, len(self.output_names)))) from None

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the present time, by name."""
        return dict(zip(self.output_names, self._row(), strict=True))

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Advance by many steps with inputs (steps, inputs); return outputs (steps, outputs).

        Raises
        ------
        StoppedError
            If a step fails; it has the outputs of the steps before. The FMU keeps the inputs of
            the failed step.
        """
        references = list(self._inputs.values())
        outputs = np.empty((len(durations), len(self.output_names)))
        steps = zip(durations.tolist(), inputs.tolist(), strict=True)
        for done, (duration, values) in enumerate(steps):
            try:
                self._set(references, values)
                self._advance(duration)
                outputs[done] = self._row()
            except FMICallException as error:
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
        description = self._archive.description
        unzipped = tempfile.mkdtemp(prefix="slipmode-")
        self._resources.callback(shutil.rmtree, unzipped, ignore_errors=True)
        fmpy.extract(self._archive.path, unzipped)
        with _LOADING:
            instance = self._instantiated(unzipped)
        self._resources.callback(instance.freeInstance)
        simulation.apply_start_values(
            instance, description, start, simulation.settable_in_instantiated
        )
        if self._archive.fmi == "2.0":
            instance.setupExperiment(startTime=0.0)
            instance.enterInitializationMode()
        else:
            instance.enterInitializationMode(startTime=0.0)
        instance.exitInitializationMode()
        return instance

    def _instantiated(self, unzipped: str) -> Any:
        description = self._archive.description
        if self._archive.fmi != "2.0":
            return simulation.instantiate_fmu(
                unzipped, description, "CoSimulation", logger=self._log.write
            )
        instance = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=unzipped,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        instance.instantiate(callbacks=self._log.callbacks())
        return instance
