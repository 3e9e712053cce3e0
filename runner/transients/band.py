"""The band of the amplitudes of a run whose model has samples."""

from __future__ import annotations

import numpy as np

from slipmode.fmu import StoppedError
from slipmode.rom import Model
from slipmode.rom.arrays import Floats
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.recording.channels import BAND
from slipmode.runner.transients.motion import OutputColumns


class SampleBand:
    """Amplitudes below which 5 and 95 % of the samples of a model are, at each point of a run.

    From the point at which a sample leaves the friction table, it counts with the largest
    amplitudes of the table.
    """

    def __init__(self, plan: ModesPlan, model: Model) -> None:
        count = 0 if model.samples is None else len(model.samples)
        excited, self._schedule, tolerance = plan.excited, plan.schedule, plan.scene.run.tolerance
        self._components = {
            k: excited.component(model, tolerance, sample=k + 1) for k in range(count)
        }
        start = np.abs(np.array(excited.amplitude))
        self._moduli = np.tile(start, (count, 1, 1))  # (samples, points, modes), the last ones
        self._ends = model.table.amplitude_range
        names = next(iter(self._components.values())).output_names
        self._columns = OutputColumns.of(names, excited)

    def at(self, points: slice) -> Floats:
        """Return the band at points that follow the last ones, (points, 2 modes).

        The points are of the schedule, beginning with number 0; each mode has two columns.
        """
        steps = slice(max(points.start - 1, 0), points.stop - 1)
        count = steps.stop - steps.start
        moduli = np.tile(self._ends, (len(self._moduli), count, 1))
        for k, component in list(self._components.items()):
            inputs = self._schedule.inputs(component.input_names, steps)
            try:
                rows = component.run(self._schedule.durations(steps), inputs)
            except StoppedError as stop:
                rows = stop.outputs
                del self._components[k]
            moduli[k, : len(rows)] = np.abs(self._columns.amplitudes(rows))
        if points.start == 0:
            moduli = np.concatenate((self._moduli, moduli), axis=1)
        band = np.percentile(moduli, BAND, axis=0)
        return np.moveaxis(band, 0, -1).reshape(len(band[0]), -1)
