"""Scenes through slow time: every shipped scene, what is left out, and how runs end early."""

import resource
import shutil
import signal
import subprocess
import sysconfig
import threading
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from scene_text import TANH_ON_BOTH_MODES

from slipmode import runner
from slipmode.fmu import Component
from slipmode.rom import SlipmodeError, Tanh, steady, two_mass
from slipmode.rom.full import Excitation, integrate
from slipmode.rom.slow.motion import reconstruct
from slipmode.runner import slow_pass
from slipmode.runner.cli import main
from slipmode.runner.recording.channels import Event
from slipmode.runner.recording.check.recover import recover
from slipmode.runner.recording.interruption import interrupts_held_back
from slipmode.runner.recording.mcapfile.writer import FIRST_FLUSH_SECONDS
from slipmode.runner.recording.record import McapSink
from slipmode.runner.scene.scene import parse_scene
from slipmode.runner.trajectory import sample_times

RERUN = shutil.which("rerun", path=sysconfig.get_path("scripts"))

# Modulus of each mode at the end and at its largest [kg^1/2 m], dissipated energy [J], and the
# largest displacement of each contact inside the windows [m].
PINNED = {
    "beating": {
        "end": (0.583859, 0.059519),
        "peak": (1.14364, 0.109379),
        "energy": 2.7295,
        "contact": (0.0170463, 0.000503824),
    },
    "force-step": {
        "end": (2.90457, 1.25106),
        "peak": (8.53812, 3.47634),
        "energy": 1053.76,
        "contact": (0.752385, 0.120184),
    },
    "one-mode": {
        "end": (3.12799,),
        "peak": (3.12799,),
        "energy": 183.034,
        "contact": (0.219243, 0.0124875),
    },
    "sweep": {
        "end": (1.27469, 0.325638),
        "peak": (3.06588, 1.25878),
        "energy": 1469.53,
        "contact": (0.242566, 0.156938),
    },
    "two-mode": {
        "end": (3.09219, 1.25217),
        "peak": (3.09809, 1.25299),
        "energy": 716.796,
        "contact": (0.252774, 0.160714),
    },
}

SCENE = f"""
title = "A scene for tests"
[structure]
model = "two-mass"
{TANH_ON_BOTH_MODES}[forcing.A]
dof = 0
amplitude = 0.15
frequency = 0.98
[run]
duration = 700.0
step = 1.0
[[contact]]
window = [600.0, 700.0]
samples_per_period = 16
[log]
mcap = true
rerun = false
"""
CONTACT = SCENE[SCENE.index("[[contact]]") : SCENE.index("[log]")]
SMALL_RANGE = ("[log]", "[model]\namplitude = [2.5, 2.0]\n[log]")
LARGE_RANGE = ("[log]", "[model]\namplitude = [4.0, 2.0]\n[log]")
FORCING_B = "[forcing.B]\ndof = 1\namplitude = 0.25\nfrequency = 1.65\n[run]"


def changed(*changes):
    text = SCENE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return replace(parse_scene(text, "."), name="test")


def decisions(scene):
    return {d.subject: (d.choice, d.reason) for d in runner.make_plan(scene).decisions}


def column(data, topic, name):
    channel, _, values = data.channels[topic]
    return values[:, channel.names.index(name)]


@contextmanager
def independent_reader(path):
    with path.open("rb") as file:
        yield make_reader(file, validate_crcs=True)


def times_in(path, topic):
    with independent_reader(path) as reader:
        return [message.log_time / 1e9 for _, _, message in reader.iter_messages(topic)]


def verified(path):
    done = subprocess.run([RERUN, "rrd", "verify", path], capture_output=True, text=True)
    return done.returncode == 0


# Every shipped scene


@pytest.fixture(scope="module", params=sorted(runner.shipped_scenes()))
def shipped(request, shipped_scene):
    return shipped_scene(request.param)


def test_shipped_scenes_give_their_numbers(shipped):
    data = shipped.read()
    moduli = np.array([column(data, "/modes", f"{m}_abs") for m in shipped.plan.excited.modes])
    contacts = [column(data, f"/contact/{i}", "x") for i in range(2)]
    found = {
        "end": moduli[:, -1],
        "peak": moduli.max(axis=1),
        "energy": column(data, "/energy", "dissipated_energy")[-1],
        "contact": np.abs(contacts).max(axis=1),
    }
    for name, pinned in PINNED[shipped.plan.scene.name].items():
        assert found[name] == pytest.approx(pinned, rel=1e-3), name
    assert max(np.abs(column(data, f"/contact/{i}", "f")).max() for i in range(2)) <= 2.0


def test_recordings_of_shipped_scenes_hold_what_the_scene_asks_for(shipped):
    scene, schedule = shipped.plan.scene, shipped.plan.schedule
    slow, fast = {"/modes", "/forcing", "/energy"}, {"/contact/0", "/contact/1"}
    fast |= {"/elastic"} if scene.output.elastic else set()
    with independent_reader(shipped.mcap) as reader:
        summary = reader.get_summary()
        counts = {
            summary.channels[number].topic: count
            for number, count in summary.statistics.channel_message_counts.items()
        }
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        attachments = {record.name: record.data for record in reader.iter_attachments()}
        assert sum(1 for _ in reader.iter_messages()) == summary.statistics.message_count
    two = len(shipped.plan.excited.modes) == 2
    fast |= {"/phases"} if two else set()
    points, samples = schedule.steps + 1, shipped.samples
    expected = dict.fromkeys(slow, points) | dict.fromkeys(fast, samples) | {"/events": 2}
    expected |= {"/torus": 32 * 64} if two else {}
    assert counts.pop("/overview/modes") == points <= 4096
    assert counts == expected
    assert attachments == {"scene.toml": scene.path.read_bytes()}
    assert metadata["scene"] == {"title": scene.title, "name": scene.name}
    assert metadata["units"]["/contact/1.v"] == "m/s"
    assert metadata["units"]["/energy.dissipated_energy"] == "J"
    assert metadata["run"]["model_hash"] == shipped.model.hash
    for topic in slow:
        assert times_in(shipped.mcap, topic) == pytest.approx(schedule.time(), abs=1e-9)


def test_shipped_scenes_step_as_they_say(shipped):
    run, time = shipped.plan.scene.run, shipped.plan.schedule.time()
    assert (time[0], time[-1]) == (0.0, run.duration)
    assert np.diff(time).max() == pytest.approx(run.step)
    assert set(np.arange(0.0, run.duration, run.step)) <= set(time)
    assert shipped.steps == time.size - 1


def test_contact_samples_fill_the_windows_of_shipped_scenes(shipped):
    (window,) = shipped.plan.scene.contact
    time = np.array(times_in(shipped.mcap, "/contact/0"))
    assert (time[0], time[-1]) == (window.start, window.end)
    assert np.ptp(np.diff(time)) < 1e-8
    scripts = [forcing.frequency for forcing in shipped.plan.scene.forcing.values()]
    fastest = max(script.range(window.start, window.end)[1] for script in scripts)
    finest = 2 * np.pi / fastest / window.samples_per_period
    assert 0.99 * finest < np.diff(time).mean() <= finest


def test_rerun_recordings_of_shipped_scenes_are_named_after_them(shipped):
    assert shipped.rrd.name == f"{shipped.plan.scene.name}.rrd"


VERIFIED = ("one-mode", "two-mode")  # these two have all kinds of views between them


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name in VERIFIED else [pytest.mark.slow])
        for name in sorted(runner.shipped_scenes())
    ],
)
def test_rerun_recordings_of_shipped_scenes_are_valid(name, shipped_scene):
    assert verified(shipped_scene(name).rrd)


# What a run returns


@pytest.mark.quick
def test_a_run_returns_what_it_wrote(tmp_path):
    first = runner.run(changed(), tmp_path / "new" / "folder")
    again = runner.run(changed(), tmp_path / "new" / "folder")
    assert first.mcap == tmp_path / "new" / "folder" / "test.mcap"
    assert first.rrd is None
    assert first.read().complete
    assert (first.steps, first.model.modes, first.cached, again.cached) == (700, 1, False, True)
    assert first.samples == len(times_in(first.mcap, "/contact/0"))
    assert 0.0 < first.slow_seconds < first.total_seconds
    assert 0.0 < first.table_seconds < first.total_seconds
    assert again.model.hash == first.model.hash


@pytest.mark.quick
def test_the_same_scene_gives_the_same_bytes(tmp_path):
    paths = [runner.run(changed(), tmp_path / name).mcap for name in "ab"]
    samples = []
    for path in paths:
        with independent_reader(path) as reader:
            samples.append([(m.log_time, m.data) for _, _, m in reader.iter_messages()])
    assert len(samples[0]) > 2000
    assert samples[0] == samples[1]


@pytest.mark.parametrize("mcap", [False, True])
@pytest.mark.parametrize("rerun", [False, True])
def test_only_the_recordings_asked_for_are_written(tmp_path, mcap, rerun):
    wanted = f"mcap = {mcap}\nrerun = {rerun}\n".lower()
    recording = runner.run(changed(("mcap = true\nrerun = false\n", wanted)), tmp_path / "logs")
    written = {path.name for path in tmp_path.glob("logs/*")}
    asked_for = {"test.mcap": mcap, "test.rrd": rerun}
    assert written == {name for name, asked in asked_for.items() if asked}
    assert (recording.mcap is not None, recording.rrd is not None) == (mcap, rerun)
    if not mcap:
        with pytest.raises(ValueError, match=r"log\.mcap = true"):
            recording.read()


def test_runs_in_threads(tmp_path):
    runner.run(changed(), tmp_path)  # fills the cache
    folders = [tmp_path / str(number) for number in range(3)]
    threads = [threading.Thread(target=runner.run, args=(changed(), folder)) for folder in folders]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    ends = [column(runner.read(folder / "test.mcap"), "/modes", "A_abs")[-1] for folder in folders]
    assert len(set(ends)) == 1


# Long runs


def test_long_steps_are_on_disk_before_many_of_them_are_done(tmp_path, monkeypatch):
    """Each of 1e5 periods and more: the first is recorded before the third is taken."""
    seen, real = [], Component.run

    def run(component, durations, inputs):
        seen.append((len(durations), recover(path, tmp_path / "whole.mcap").kept))
        time.sleep(1.2 * FIRST_FLUSH_SECONDS)
        return real(component, durations, inputs)

    path = tmp_path / "test.mcap"
    scene = changed(("duration = 700.0\nstep = 1.0", "duration = 7e6\nstep = 7e5"), (CONTACT, ""))
    monkeypatch.setattr(Component, "run", run)
    recording = runner.run(scene, tmp_path)
    steps, kept = zip(*seen, strict=True)
    assert steps == 10 * (1,)
    assert kept[2] > 0
    assert column(recording.read(), "/modes", "A_abs").size == 11


def test_a_window_late_in_a_run_needs_no_more_than_its_own_steps(tmp_path, monkeypatch):
    """The same samples as from the whole trajectory, of which the run keeps the end alone."""
    kept = []
    real = slow_pass.slow_trajectory

    def slow_trajectory(plan, model, names, outputs, first):
        kept.append((len(outputs), first))
        return real(plan, model, names, outputs, first)

    monkeypatch.setattr(slow_pass, "slow_trajectory", slow_trajectory)
    sweep = "frequency = [[0, 0.96], [19000, 0.96], [20000, 1.0]]"
    force = "amplitude = [[0, 0.1], [19530, 0.1], [19530, 0.15]]"
    late = changed(
        ("duration = 700.0", "duration = 20000.0"),
        ("[600.0, 700.0]", "[19600.0, 19700.0]"),
        ("frequency = 0.98", sweep),
        ("amplitude = 0.15", force),
    )
    recording = runner.run(late, tmp_path)
    ((rows, first),) = kept
    assert rows < 3 * 1024 < 16000 < first
    plan, model = recording.plan, recording.model
    component = plan.component(model)
    start = [list(component.outputs().values())]
    whole = component.run(plan.schedule.durations(), plan.schedule.inputs(component.input_names))
    trajectory = real(plan, model, component.output_names, np.vstack((start, whole)))
    data = recording.read()
    times = sample_times(plan.scene.contact[0], trajectory)
    expected = reconstruct(model, trajectory, times)
    np.testing.assert_array_equal(column(data, "/contact/0", "f"), expected.force[:, 0])
    np.testing.assert_array_equal(column(data, "/contact/1", "x"), expected.displacement[:, 1])


# No more model than the scene needs


@pytest.mark.parametrize(
    ("scene", "present", "absent"),
    [
        (changed(), "A", "B"),
        (changed(("[forcing.A]\ndof = 0", "[forcing.B]\ndof = 1"), ("0.98", "1.65")), "B", "A"),
    ],
)
@pytest.mark.quick
def test_a_mode_that_nothing_moves_is_left_out(tmp_path, scene, present, absent):
    made = decisions(scene)
    assert made[f"mode {present}"] == ("modelled", f"moved by forcing.{present}")
    choice, reason = made[f"mode {absent}"]
    assert choice == "left out"
    assert reason.startswith("neither forced nor moving at t = 0")
    assert absent not in made["friction table"][0]
    recording = runner.run(scene, tmp_path)
    assert recording.model.table.values.shape[1] == 1  # amplitudes of a second mode
    for channel, _, _ in recording.read().channels.values():
        assert not any(name.startswith(f"{absent}_") for name in channel.names)
    assert column(recording.read(), "/modes", f"{present}_abs")[-1] > 0.4


def test_a_mode_that_only_starts_is_modelled():
    made = decisions(changed(("[run]", "[initial]\nB = [0.5, 0.0]\n[run]")))
    assert made["mode B"] == ("modelled", "moved by initial.B")


def test_forces_on_contacts_move_modes_and_contacts(tmp_path):
    scene = changed(
        ("dof = 0\namplitude = 0.15", "dof = 2\namplitude = 2.5"),
        ("[log]", "[output]\nelastic = [0, 2]\n[log]"),
    )
    recording = runner.run(scene, tmp_path)
    end = column(recording.read(), "/modes", "A_abs")[-1]
    a = steady(recording.model, (0.98,), ({2: 2.5},))
    assert end == pytest.approx(abs(a[0]), rel=5e-3)  # not yet at rest: 0.29 %
    moved = recording.read().channels["/elastic"]
    excitation = Excitation.harmonic(two_mass(), ({2: 2.5},), (0.98,))
    exact = integrate(two_mass(), Tanh(2.0, 0.02), excitation, moved.time, step=0.01)
    # measured: 8.9e-5 and 1.18e-3
    for name, dof, bound in (("x_0", 0, 2e-4), ("x_2", 2, 2.4e-3)):
        x = exact.displacement[:, dof]
        assert (np.std(moved.column(name) - x) / np.std(x)) < bound


def test_contacts_that_nobody_looks_at_are_not_marched(tmp_path):
    scene = changed((CONTACT, ""))
    assert decisions(scene)["fast motion"] == ("none", "no [[contact]] or [[elastic]] window")
    recording = runner.run(scene, tmp_path)
    assert set(recording.read().channels) == {"/modes", "/forcing", "/energy"}
    assert recording.samples == 0


def elastic_windows(window, dofs):
    """The scene with its contact window made an elastic one."""
    return changed((CONTACT, f"[[elastic]]\nwindow = {window}\n[output]\nelastic = {dofs}\n"))


@pytest.mark.quick
def test_elastic_motion_alone_is_summed_from_harmonics(tmp_path):
    scene = elastic_windows([100, 150], [0])
    choice, reason = decisions(scene)["elastic motion"]
    assert choice == "100 to 150 s, harmonics to order 5 summed"
    assert reason.startswith("64 samples per period; they miss 0 of it")
    recording = runner.run(scene, tmp_path)
    assert set(recording.read().channels) == {"/modes", "/forcing", "/energy", "/elastic"}
    marched = runner.run(
        changed((CONTACT, "[[contact]]\nwindow = [100, 150]\n[output]\nelastic = [0]\n")), tmp_path
    )
    summed, exact = (column(r.read(), "/elastic", "x_0") for r in (recording, marched))
    assert summed.size == exact.size == recording.samples
    np.testing.assert_allclose(summed, exact, atol=2e-3 * np.abs(exact).max())


def test_what_harmonics_cannot_sum_to_the_tolerance_is_marched():
    """A contact DOF: its corners need more harmonics than there are."""
    choice, reason = decisions(elastic_windows([100, 150], [2]))["elastic motion"]
    assert choice == "100 to 150 s, marched"
    assert "harmonics to order 9 miss" in reason
    assert "above 0.001" in reason


def test_the_table_reaches_no_further_than_the_amplitudes(tmp_path):
    recording = runner.run(changed(("[run]", FORCING_B)), tmp_path)
    for limit, mode in zip(recording.model.table.amplitude_range, "AB", strict=True):
        peak = column(recording.read(), "/modes", f"{mode}_abs").max()
        assert peak < limit < 1.3 * peak


def test_a_given_range_is_taken_as_it_is():
    scene = changed(SMALL_RANGE)
    assert runner.make_plan(scene).amplitude == (2.5,)
    assert decisions(scene)["friction table"] == ("|A| <= 2.5", "given as model.amplitude")


@pytest.mark.parametrize(("duration", "step"), [(599.7, 0.3), (700.0, 0.7), (629.2, 1.1)])
def test_a_window_that_ends_with_the_run_is_recorded(tmp_path, duration, step):
    scene = changed(
        ("duration = 700.0", f"duration = {duration}"),
        ("step = 1.0", f"step = {step}"),
        ("[600.0, 700.0]", f"[590.0, {duration}]"),
    )
    recording = runner.run(scene, tmp_path)
    assert times_in(recording.mcap, "/modes")[-1] == duration
    assert times_in(recording.mcap, "/contact/0")[-1] == duration


# Runs that end early


def run_to_failure(scene, folder, error):
    with pytest.raises(error) as failure:
        runner.run(scene, folder)
    return failure.value, runner.read(folder / "test.mcap")


def test_an_interrupted_run_is_readable_and_says_so(tmp_path, monkeypatch):
    taken = []
    run = Component.run

    def interrupted(self, durations, inputs):
        if taken:
            raise KeyboardInterrupt
        if len(durations) < 700:  # not the dry run of the plan, which takes all steps at once
            taken.extend(durations)
        return run(self, durations, inputs)

    monkeypatch.setattr(Component, "run", interrupted)
    monkeypatch.setattr("slipmode.runner.slow_pass._STEPS_PER_BLOCK", 256)
    _, data = run_to_failure(changed(LARGE_RANGE), tmp_path, KeyboardInterrupt)
    assert (data.damage, data.complete) == ("", False)
    assert data.channels["/modes"][1].size == len(taken) + 1 < 700
    assert data.events[-1] == Event(sum(taken), "error", "interrupted by the user")


@pytest.mark.parametrize("topic", ["/modes", "/contact/0"])
def test_ctrl_c_in_the_middle_of_a_batch_waits_for_its_end(tmp_path, monkeypatch, topic):
    write = McapSink.write

    def interrupted(self, written, time, values):
        if written == topic and len(time) > 1:
            signal.raise_signal(signal.SIGINT)
        write(self, written, time, values)

    monkeypatch.setattr(McapSink, "write", interrupted)
    handler = signal.getsignal(signal.SIGINT)
    _, data = run_to_failure(changed(), tmp_path, KeyboardInterrupt)
    assert data.damage == ""
    assert data.complete == (topic == "/contact/0")  # whose batch is the last of the run
    sizes = {name: time.size for name, (_, time, _) in data.channels.items()}
    assert sizes["/modes"] == sizes["/forcing"] == sizes["/energy"] > 1
    assert sizes["/contact/0"] == sizes["/contact/1"]
    assert signal.getsignal(signal.SIGINT) is handler


def test_a_second_ctrl_c_does_not_wait():
    with pytest.raises(KeyboardInterrupt), interrupts_held_back():
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


@pytest.mark.quick
def test_a_run_that_leaves_its_table_is_readable_and_says_so(tmp_path):
    error, data = run_to_failure(changed(SMALL_RANGE), tmp_path, SlipmodeError)
    assert "amplitude |A| leaves the friction table, whose range is 2.5" in str(error)
    assert (data.damage, data.complete) == ("", False)
    assert data.events[-1].message == str(error)
    assert data.events[-1].time == data.channels["/modes"][1][-1] < 700.0
    assert 2.0 < column(data, "/modes", "A_abs")[-1] <= 2.5


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (SlipmodeError("contact motion: not a number"), "contact motion: not a number"),
        (MemoryError("no room for it"), "MemoryError: no room for it"),
        (RuntimeError("two\nlines"), "RuntimeError: two lines"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_run_whose_reconstruction_fails_is_readable_and_says_so(
    tmp_path, monkeypatch, error, words
):
    monkeypatch.setattr("slipmode.runner.slow_pass._SAMPLES_PER_BATCH", 64)
    reconstruct, batches = slow_pass.reconstruct, []

    def failing(*arguments):
        if batches:
            raise error
        batches.append(reconstruct(*arguments))
        return batches[-1]

    monkeypatch.setattr(slow_pass, "reconstruct", failing)
    raised, data = run_to_failure(changed(), tmp_path, type(error))
    assert raised is error
    assert (data.damage, data.complete) == ("", False)
    assert (data.events[-1].level, data.events[-1].message) == ("error", words)
    assert data.channels["/modes"][1][-1] == data.events[-1].time == 700.0
    np.testing.assert_array_equal(column(data, "/contact/0", "x"), batches[0].displacement[:, 0])


def test_a_run_that_does_not_begin_says_so(tmp_path, monkeypatch):
    def refused(self, **inputs):
        raise SlipmodeError("frequency_A: must be > 0")

    scene = changed(LARGE_RANGE)
    runner.run(scene, tmp_path)  # the table is there
    monkeypatch.setattr(Component, "set_inputs", refused)
    _, data = run_to_failure(scene, tmp_path, SlipmodeError)
    assert not data.complete
    assert data.events == [Event(0.0, "error", "frequency_A: must be > 0")]


@pytest.mark.parametrize("error", [SlipmodeError("contact motion: no"), MemoryError()])
def test_the_command_says_in_one_line_why_the_reconstruction_failed(
    tmp_path, monkeypatch, capsys, error
):
    def failing(*arguments):
        raise error

    monkeypatch.setattr(slow_pass, "reconstruct", failing)
    assert main(["run", "one-mode", "-o", str(tmp_path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"slipmode: {error if str(error) else 'out of memory'}"
    assert not runner.read(tmp_path / "one-mode.mcap").complete
    assert verified(tmp_path / "one-mode.rrd")


def test_a_full_disk_keeps_what_was_written(tmp_path):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    runner.run(changed(), tmp_path)  # the cache is not what the disk has no room for
    long = changed(("duration = 700.0", "duration = 30000.0"))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_500_000, hard))
    try:
        error, data = run_to_failure(long, tmp_path, OSError)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert error.filename == str(tmp_path / "test.mcap")
    assert not data.complete
    assert 5000 < data.channels["/modes"][1].size < 30000


def occupied(folder):
    (folder / "logs").write_text("a file, not a folder")


def taken_by_a_folder(folder):
    (folder / "logs" / "test.mcap").mkdir(parents=True)


def full(folder):
    (folder / "logs").mkdir()
    (folder / "logs" / "test.mcap").symlink_to("/dev/full")


@pytest.mark.parametrize(
    ("prepare", "at_fault"),
    [(occupied, "logs"), (taken_by_a_folder, "logs/test.mcap"), (full, "logs/test.mcap")],
)
def test_places_that_cannot_be_written(tmp_path, prepare, at_fault):
    prepare(tmp_path)
    with pytest.raises((SlipmodeError, OSError)) as failure:
        runner.run(changed(), tmp_path / "logs")
    assert str(tmp_path / Path(at_fault)) in str(failure.value)
