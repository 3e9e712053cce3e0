"""Running a scene, in slow time or at full order, and recording it."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

from slipmode.rom import Model, SlipmodeError
from slipmode.rom.short_repr import short_list
from slipmode.runner.interrupts import interrupts_held_back
from slipmode.runner.plan.plan import Plan
from slipmode.runner.plan.planning import plan_scene
from slipmode.runner.plan.wear import worn
from slipmode.runner.recording.channels import Channel
from slipmode.runner.recording.load import RecordingData, read
from slipmode.runner.recording.record import (
    Header,
    McapSink,
    Recorder,
    Sink,
    describe_run,
)
from slipmode.runner.scene.scene import Scene, load_scene
from slipmode.runner.transients.passes.blades import BladePass
from slipmode.runner.transients.passes.integrated import IntegratedPass
from slipmode.runner.transients.passes.loop import Destination, Pass
from slipmode.runner.transients.passes.slow import SlowPass
from slipmode.runner.transients.passes.tones import TonePass
from slipmode.runner.transients.passes.waves import WavePass
from slipmode.runner.view.foxglove import write_layout
from slipmode.runner.view.viewer import Viewer

_log = logging.getLogger("slipmode.run")

# By `Plan.kind`. Passes with a friction table also need the model.
PASSES: dict[str, Callable[..., Pass[Any]]] = {
    "modes": SlowPass,
    "waves": WavePass,
    "tones": TonePass,
    "blades": BladePass,
    "full order": IntegratedPass,
}


@dataclass(frozen=True, eq=False)
class Recording:
    """Hold the files of a run, and its computing times.

    Attributes
    ----------
    plan : Plan
        Plan of the scene.
    model : Model or None
        Model of the scene; None without a friction table.
    mcap, rrd : Path or None
        Recordings, if [log] of the scene requests them.
    steps, samples : int
        Number of communication steps, and of samples of fast motion.
    table_seconds, slow_seconds, total_seconds : float
        Wall times of the plan and the friction table, of the integration, and of the whole run
        [s].
    cached : bool
        Whether the table came from the cache or from `model.file`.
    """

    plan: Plan[Any]
    model: Model | None
    mcap: Path | None
    rrd: Path | None
    steps: int
    samples: int
    table_seconds: float
    slow_seconds: float
    total_seconds: float
    cached: bool

    def __repr__(self) -> str:
        scene = self.plan.scene
        files = ", ".join(str(path) for path in (self.mcap, self.rrd) if path) or "no files"
        topics = short_list(channel.topic for channel in self.plan.channels)
        return (
            f"Recording({scene.title!r}: {files}; {topics}; complete, {scene.run.duration:g} s, "
            f"{self.steps} steps, {self.samples} samples of fast motion)"
        )

    def read(self) -> RecordingData:
        """Return the recorded channels as arrays.

        Returns
        -------
        RecordingData
            Channels and events of the MCAP file.

        Raises
        ------
        ValueError
            If the run wrote no MCAP file.
        """
        if self.mcap is None:
            raise ValueError("this run was not recorded as MCAP: set log.mcap = true")
        return read(self.mcap)


def run(
    scene: Scene | str | PathLike[str],
    output: str | PathLike[str] = "logs",
    *,
    fmu: str | PathLike[str] | None = None,
    live: Viewer | None = None,
    progress: bool = False,
) -> Recording:
    """Run a scene in slow time and record it.

    Parameters
    ----------
    scene : Scene, path or str
        Scene, TOML file, or name of a shipped scene.
    output : path, default "logs"
        Folder for the recordings <scene>.mcap and <scene>.rrd, and for a layout of Foxglove. It is
        made if it does not exist.
    fmu : path, optional
        FMU of the model of this scene, which takes the slow-time steps with its own friction
        table. If it was exported with a headroom of 1, the results are bit-identical to a run
        without FMU.
    live : Viewer, optional
        Viewer that shows the run while it is recorded, from `find_viewer`.
    progress : bool, default False
        Show progress bars if the computation takes longer than 1 s.

    Returns
    -------
    Recording
        Files of the run, its plan and its model.

    Raises
    ------
    SlipmodeError
        If the scene or the FMU is refused, or the run stops. The recording up to this time is
        readable and contains the reason.
    OSError
        If the recording cannot be written.
    KeyboardInterrupt
        On Ctrl-C, after the recording is complete up to this time. A second Ctrl-C does not wait.

    Examples
    --------
    A run, and a channel of its recording::

        recording = runner.run("sweep")
        modes = recording.read().channels["/modes"]
        amplitude = modes.column("A_abs")
    """
    started = time.perf_counter()
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    if fmu is not None:
        scene.check_tabulated()
        if scene.model.transients == "hybrid":
            raise SlipmodeError(
                'model.transients = "hybrid": must be "auto" or "slow" to run an FMU, because '
                "an FMU has slow time only"
            )
        scene = scene.in_slow_time()
    plan = plan_scene(scene, progress=progress)
    for warning in plan.warnings:
        _log.warning("%s", warning)
    if fmu is not None:
        from slipmode.runner.fmi.load import open_fmu, range_of  # FMPy takes a while to import

        plan = replace(plan, amplitude=range_of(fmu, plan))
    model, cached = plan.model(progress=progress) if scene.tabulated else (None, False)
    if model is not None:
        plan = replace(plan, schedule=worn(plan.excited, plan.schedule, model, plan.scene))
    table_seconds = time.perf_counter() - started
    folder = Path(output)
    mcap = folder / f"{scene.name}.mcap" if scene.log.mcap else None
    rrd = folder / f"{scene.name}.rrd" if scene.log.rerun else None
    if mcap or rrd:
        folder.mkdir(parents=True, exist_ok=True)

    details = describe_run(scene.text, model)
    moved = plan.excited.moved(plan.amplitude)
    details |= {f"mode_{name}": each.describe() for name, each in moved.items()}
    details |= {"fmu": Path(fmu).name} if fmu else {}
    header = Header(scene.title, scene.text, details, scene.name)
    with ExitStack() as stack:
        raise_if_interrupted = stack.enter_context(interrupts_held_back())
        component = stack.enter_context(open_fmu(fmu, plan, model)) if fmu and model else None
        recorder = stack.enter_context(open_recorder(header, plan.channels, mcap, rrd, live))
        tabulated = (model, component) if model else ()
        destination = Destination(recorder, raise_if_interrupted)
        pass_ = PASSES[plan.kind](plan, destination, *tabulated)
        pass_.run(progress)
    if mcap:
        write_layout(mcap, header, plan.channels)
    return Recording(
        plan=plan,
        model=model,
        mcap=mcap,
        rrd=rrd,
        steps=plan.schedule.steps,
        samples=pass_.samples,
        table_seconds=table_seconds,
        slow_seconds=pass_.seconds,
        total_seconds=time.perf_counter() - started,
        cached=cached,
    )


def open_recorder(
    header: Header,
    listed: list[Channel],
    mcap: Path | None,
    rrd: Path | None,
    live: Viewer | None = None,
) -> Recorder:
    """Open the files and the viewer of a recording; close all if one cannot be opened."""
    sinks: list[Sink] = []
    try:
        if mcap:
            sinks.append(McapSink(mcap, header, listed))
        if rrd or live:
            from slipmode.runner.view.rerun_sink import RerunSink  # it takes a while to import

            sinks += [RerunSink(rrd, header, listed)] if rrd else []
            sinks += [RerunSink(live, header, listed, live=True)] if live else []
    except BaseException:
        Recorder(sinks).close()
        raise
    return Recorder(sinks)
