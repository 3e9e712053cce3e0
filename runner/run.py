"""A scene through slow time, and what it leaves behind: a recording."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from fmu import Steppable, StoppedError
from rom import Model, SlipmodeError
from rom.errors import UnvisitedError
from rom.motion import Motion, reconstruct, sum_harmonics
from runner import channels
from runner.interruption import interrupts_held_back
from runner.live import LiveSink
from runner.load import RecordingData, read
from runner.plan import Plan, make_plan
from runner.provenance import describe_run
from runner.record import Header, McapSink, Recorder, Sink
from runner.rerun_sink import RerunSink
from runner.scene import Scene, Window, load_scene
from runner.torus_motion import carrier_phases, torus_motion
from runner.trajectory import sample_times, slow_trajectory
from runner.viewer import Viewer

_STEPS_PER_BLOCK = 256
_SAMPLES_PER_BATCH = 16384

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Recording:
    """What a run wrote, and how long it took.

    Attributes
    ----------
    plan : Plan
    model : Model
        Where `plan.visited` is set, its table holds in that part only.
    mcap, rrd : Path or None
        The files, where the scene's [log] asks for them.
    steps : int
        Communication steps.
    samples : int
        Samples of fast motion.
    table_seconds, slow_seconds, total_seconds : float
        Wall time of the plan and the friction table, of the slow-time integration alone, and
        of everything.
    cached : bool
        Whether the table came from the cache.
    """

    plan: Plan
    model: Model
    mcap: Path | None
    rrd: Path | None
    steps: int
    samples: int
    table_seconds: float
    slow_seconds: float
    total_seconds: float
    cached: bool

    def read(self) -> RecordingData:
        """The recorded channels as arrays; needs the MCAP file."""
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
    """Run a scene and record it.

    Parameters
    ----------
    scene : Scene, path of a scene file, or name of a shipped scene
    output : path
        Folder for the recordings <scene>.mcap and <scene>.rrd; made if missing.
    fmu : path, optional
        An FMU of the scene's model that does the slow-time steps, with the same result
        as on the whole table.
    live : Viewer, optional
        Show the run there while it is recorded: `runner.viewer.find_viewer` opens one.
    progress : bool
        Progress bars on work longer than a second.

    Returns
    -------
    Recording

    Raises
    ------
    SlipmodeError
        If the scene or the FMU is refused, or the run has to stop. What was recorded until then
        stays readable, and says why it ends.
    OSError
        If the recording cannot be written.
    KeyboardInterrupt
        On Ctrl-C, once the recording is whole up to there; a second Ctrl-C does not wait.
    """
    started = time.perf_counter()
    if not isinstance(scene, Scene):
        scene = load_scene(scene)
    plan = make_plan(scene, progress=progress)
    if fmu is not None:
        plan = plan.on_whole_table("an FMU has all of it")
    model, cached = plan.model(visited=True, progress=progress)
    table_seconds = time.perf_counter() - started
    folder = Path(output)
    mcap = folder / f"{scene.name}.mcap" if scene.log.mcap else None
    rrd = folder / f"{scene.name}.rrd" if scene.log.rerun else None
    if mcap or rrd:
        folder.mkdir(parents=True, exist_ok=True)
    through = partial(_through, mcap=mcap, rrd=rrd, fmu=fmu, live=live, progress=progress)
    try:
        pass_ = through(plan, model)
    except SlipmodeError as refusal:
        if not _left_visited(model, refusal):
            raise
        left = time.perf_counter()
        plan = plan.on_whole_table(f"a run on the part was refused: {refusal}", "warning")
        model, cached = plan.model(progress=progress)
        table_seconds += time.perf_counter() - left
        pass_ = through(plan, model)
    return Recording(
        plan=plan,
        model=model,
        mcap=mcap,
        rrd=rrd,
        steps=plan.schedule.durations.size,
        samples=pass_.samples,
        table_seconds=table_seconds,
        slow_seconds=pass_.slow_seconds,
        total_seconds=time.perf_counter() - started,
        cached=cached,
    )


def _through(
    plan: Plan,
    model: Model,
    *,
    mcap: Path | None,
    rrd: Path | None,
    fmu: str | PathLike[str] | None,
    live: Viewer | None,
    progress: bool,
) -> _Pass:
    """One pass through slow time, recorded."""
    with (
        interrupts_held_back() as raise_if_interrupted,
        _stepping(fmu, plan, model) as component,
        _open(plan, model, mcap, rrd, fmu, live) as recorder,
    ):
        pass_ = _Pass(plan, model, component, recorder, raise_if_interrupted)
        pass_.through_slow_time(progress)
    return pass_


def _left_visited(model: Model, refusal: SlipmodeError) -> bool:
    """Whether a run was refused for going where only all of the friction table holds."""
    if isinstance(refusal, StoppedError):
        return refusal.left_table and model.table.visited is not None
    return isinstance(refusal, UnvisitedError)


def _stepping(
    fmu: str | PathLike[str] | None, plan: Plan, model: Model
) -> AbstractContextManager[Steppable]:
    """What does the slow-time steps."""
    if fmu is None:
        return nullcontext(plan.component(model))
    from runner.fmu_import import open_fmu  # FMPy takes a while to import

    return open_fmu(fmu, plan, model)


def _open(
    plan: Plan,
    model: Model,
    mcap: Path | None,
    rrd: Path | None,
    fmu: str | PathLike[str] | None,
    live: Viewer | None,
) -> Recorder:
    scene, modes = plan.scene, plan.excited.modes
    listed = [channels.modes(modes), channels.forcing(modes), channels.energy()]
    if scene.contact:
        listed += [channels.contact(i) for i in range(model.reduced.n_contacts)]
        listed += [channels.phases(), channels.torus()] if len(modes) == 2 else []
    if scene.output.elastic:
        listed.append(channels.elastic(scene.output.elastic))
    header = Header(
        title=scene.title,
        scene_text=scene.text,
        run=describe_run(scene.text, model) | ({"fmu": Path(fmu).name} if fmu else {}),
        scene_name=scene.name,
    )
    sinks: list[Sink] = []
    try:
        if mcap:
            sinks.append(McapSink(mcap, header, listed))
        if rrd:
            sinks.append(RerunSink(rrd, header, listed))
        if live:
            sinks.append(LiveSink(live, header, listed))
    except BaseException:
        Recorder(sinks).close()
        raise
    return Recorder(sinks)


class _Pass:
    """One pass of a component through the schedule of a plan."""

    def __init__(
        self,
        plan: Plan,
        model: Model,
        component: Steppable,
        recorder: Recorder,
        raise_if_interrupted: Callable[[], None],
    ) -> None:
        self.samples = 0
        self.slow_seconds = 0.0
        self._plan = plan
        self._model = model
        self._component = component
        self._recorder = recorder
        self._raise_if_interrupted = raise_if_interrupted
        self._now = 0.0  # as the schedule has it: the sum of its steps may round differently
        inputs = plan.schedule.inputs(component.input_names)
        component.set_inputs(**dict(zip(component.input_names, inputs[0].tolist(), strict=True)))
        self._inputs = inputs
        self._columns = {name: k for k, name in enumerate(component.output_names)}
        self._rows = [self._present_row()]
        windows = (*plan.scene.contact, *plan.scene.elastic)
        self._windows = sorted(windows, key=lambda window: window.start)

    def through_slow_time(self, progress: bool) -> None:
        """Step, record, and reconstruct each contact window once its end is reached."""
        schedule = self._plan.schedule
        recorder = self._recorder
        recorder.event(0.0, "info", _summary(self._plan, self._model))
        for decision in self._plan.decisions:
            if decision.level != "info":
                words = f"{decision.subject} {decision.choice}: {decision.reason}"
                recorder.event(0.0, decision.level, words)
        self._record(self._rows[0], 0)
        steps = schedule.durations.size
        try:
            with tqdm(total=steps, unit=" steps", delay=1.0, disable=not progress) as bar:
                for first in range(0, steps, _STEPS_PER_BLOCK):
                    block = slice(first, min(first + _STEPS_PER_BLOCK, steps))
                    self._advance(schedule.durations[block], self._inputs[block], first)
                    bar.update(block.stop - first)
        except (StoppedError, KeyboardInterrupt) as stop:
            reason = str(stop) if isinstance(stop, StoppedError) else "interrupted by the user"
            recorder.event(self._now, "error", reason)
            raise
        recorder.event(self._now, "info", "end of the scene")

    def _advance(self, durations: Floats, inputs: Floats, first: int) -> None:
        self._raise_if_interrupted()
        started = time.perf_counter()
        try:
            outputs = self._component.run(durations, inputs)
        except StoppedError as stop:
            self._keep(stop.outputs, first)
            raise
        finally:
            self.slow_seconds += time.perf_counter() - started
        self._keep(outputs, first)

    def _keep(self, outputs: Floats, first: int) -> None:
        """Record the outputs of the steps from number `first` on."""
        if not len(outputs):
            return
        self._rows.append(outputs)
        self._now = float(self._plan.schedule.time[first + len(outputs)])
        self._record(outputs, first + 1)
        while self._windows and self._windows[0].end <= self._now:
            self._reconstruct(self._windows.pop(0))

    def _present_row(self) -> Floats:
        now = self._component.outputs()
        return np.array([[now[name] for name in self._columns]])

    def _record(self, outputs: Floats, first: int) -> None:
        """Slow channels of the communication points from number `first` on."""
        schedule, modes = self._plan.schedule, self._plan.excited.modes
        points = slice(first, first + len(outputs))
        time_ = schedule.time[points]
        parts = self._take(outputs, [f"{m}_{p}" for m in modes for p in ("re", "im")])
        moduli = np.hypot(parts[:, 0::2], parts[:, 1::2])
        self._recorder.write("/modes", time_, np.hstack((parts, moduli)))
        names = [f"{q}_{m}" for m in modes for q in ("force", "frequency", "phase")]
        self._recorder.write("/forcing", time_, schedule.at_points(names)[points])
        energy = ["input_power", "dissipated_power", "dissipated_energy"]
        self._recorder.write("/energy", time_, self._take(outputs, energy))

    def _take(self, outputs: Floats, names: Sequence[str]) -> Floats:
        return outputs[:, [self._columns[name] for name in names]]

    def _reconstruct(self, window: Window) -> None:
        outputs = np.concatenate(self._rows)
        self._rows = [outputs]
        trajectory = slow_trajectory(self._plan, self._model, list(self._columns), outputs)
        of_contacts = window in self._plan.scene.contact
        on_torus = of_contacts and self._model.modes == 2 and self._recorder.keeps
        summed = not of_contacts and self._plan.elastic_order is not None
        times = sample_times(window, trajectory)
        for start in range(0, times.size, _SAMPLES_PER_BATCH):
            self._raise_if_interrupted()
            batch = times[start : start + _SAMPLES_PER_BATCH]
            motion = (sum_harmonics if summed else reconstruct)(self._model, trajectory, batch)
            self._record_motion(motion, of_contacts)
            if on_torus:
                self._recorder.write(channels.PHASES, batch, carrier_phases(trajectory, batch))
            self.samples += batch.size
        if on_torus:
            torus = torus_motion(self._model, trajectory, window.end)
            self._recorder.write(channels.TORUS, np.full(len(torus), window.end), torus)

    def _record_motion(self, motion: Motion, of_contacts: bool) -> None:
        if of_contacts:
            for i in range(self._model.reduced.n_contacts):
                values = (motion.displacement[:, i], motion.velocity[:, i], motion.force[:, i])
                self._recorder.write(f"/contact/{i}", motion.time, np.column_stack(values))
        if elastic := self._plan.scene.output.elastic:
            self._recorder.write("/elastic", motion.time, motion.elastic(self._model, elastic))


def _summary(plan: Plan, model: Model) -> str:
    modes = " and ".join(plan.excited.modes)
    return (
        f"{plan.scene.title}: mode {modes}, {model.reduced.n_contacts} contacts, "
        f"{model.reduced.formulation} formulation, table tolerance {model.quality.tolerance:g}"
    )
