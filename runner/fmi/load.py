"""An FMU as the component of a scene."""

from __future__ import annotations

from os import PathLike

import numpy as np

from slipmode.fmu.archive.resources import identity
from slipmode.fmu.imported import Archive, Imported
from slipmode.rom import Model, SlipmodeError
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.transients.motion import POWERS


def range_of(path: str | PathLike[str], plan: ModesPlan) -> tuple[float, ...]:
    """Return the largest amplitudes of the friction table of an FMU of a scene [kg^1/2 m].

    They are the amplitude range of the plan times one factor of at least 1. Raises SlipmodeError
    if the file is no FMU for this machine, or not of the scene's model.
    """
    found = Archive(path).amplitude_range
    if len(found) == len(plan.amplitude):
        factor = np.divide(found, plan.amplitude)
        if factor.min() >= 1.0 and np.allclose(factor, factor[0], rtol=1e-9, atol=0.0):
            return found
    raise _another_model(path)


def open_fmu(path: str | PathLike[str], plan: ModesPlan, model: Model) -> Imported:
    """Return an FMU that starts as the scene does at t = 0.

    Raises SlipmodeError if the file is no FMU for this machine, or does not hold this model.
    """
    archive, schedule = Archive(path), plan.schedule
    if archive.identity != identity(model, plan.excited.force_patterns):
        raise _another_model(path)
    archive.require(schedule.scripted, archive.inputs, "inputs")
    amplitudes = plan.excited.start()
    angles = [f"theta_{mode}" for mode in plan.excited.modes]
    archive.require([*amplitudes, *angles, *POWERS], archive.outputs, "outputs")
    (first,) = schedule.inputs(tuple(archive.inputs), slice(1)).tolist()
    start = dict(zip(archive.inputs, first, strict=True)) | amplitudes
    start["tolerance"] = plan.scene.run.tolerance
    if "contact_wanted" in archive.settable:
        start["contact_wanted"] = False  # the runner reconstructs it
    return Imported(archive, start)


def _another_model(path: str | PathLike[str]) -> SlipmodeError:
    return SlipmodeError(
        f"{path}: has a different model than the scene; export the model of the scene with "
        "slipmode fmu"
    )
