"""Scenes through slow time: every shipped scene, what is left out, and how runs end early."""

import threading
import time

import numpy as np
import pytest
from runs import (
    CONTACT,
    FORCING_B,
    SMALL_RANGE,
    changed,
    column,
    decisions,
    independent_reader,
    times_in,
)

from slipmode import runner
from slipmode.fmu import Component
from slipmode.rom import Tanh, reconstruct, steady, two_mass
from slipmode.rom.full import Excitation, integrate
from slipmode.runner import recover
from slipmode.runner.recording.mcap_writer import FIRST_FLUSH_SECONDS
from slipmode.runner.transients import passes

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
    asked_for = {"test.mcap": mcap, "test.foxglove.json": mcap, "test.rrd": rerun}
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
    real = passes.slow_trajectory

    def slow_trajectory(plan, model, names, outputs, first):
        kept.append((len(outputs), first))
        return real(plan, model, names, outputs, first)

    monkeypatch.setattr(passes, "slow_trajectory", slow_trajectory)
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
    times = plan.schedule.sample_times(plan.scene.contact[0])
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
        ("[log]", "[output]\nelastic = [0, 2]\n[model]\ntolerance = 3e-4\n[log]"),
    )
    recording = runner.run(scene, tmp_path)
    end = column(recording.read(), "/modes", "A_abs")[-1]
    a = steady(recording.model, (0.98,), ({2: 2.5},))
    assert end == pytest.approx(abs(a[0]), rel=5e-3)  # not yet at rest: 0.29 %
    moved = recording.read().channels["/elastic"]
    excitation = Excitation.harmonic(two_mass(), ({2: 2.5},), (0.98,))
    exact = integrate(two_mass(), Tanh(2.0, 0.02), excitation, moved.time, step=0.01)
    # measured: 9.2e-5 and 3.6e-4
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
def test_elastic_windows_record_the_motion_of_contact_windows(tmp_path):
    scene = elastic_windows([100, 150], [0])
    choice, reason = decisions(scene)["elastic motion"]
    assert choice == "100 to 150 s, reconstructed"
    assert reason == "64 samples per period"
    recording = runner.run(scene, tmp_path)
    assert set(recording.read().channels) == {"/modes", "/forcing", "/energy", "/elastic"}
    both = runner.run(
        changed((CONTACT, "[[contact]]\nwindow = [100, 150]\n[output]\nelastic = [0]\n")), tmp_path
    )
    alone, beside = (column(r.read(), "/elastic", "x_0") for r in (recording, both))
    assert recording.samples == alone.size
    np.testing.assert_array_equal(alone, beside)


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
