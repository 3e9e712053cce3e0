"""Runs of scenes: files, channels, what is modelled and what is left out."""

import threading

import numpy as np
import pytest
from runs import (
    CONTACT,
    changed,
    column,
    decisions,
    independent_reader,
    times_in,
)

from slipmode import runner
from slipmode.runner import parse_scene


@pytest.mark.quick
def test_a_run_returns_what_it_wrote(tmp_path):
    first = runner.run(changed(), tmp_path / "new" / "folder")
    again = runner.run(changed(), tmp_path / "new" / "folder")
    assert first.mcap == tmp_path / "new" / "folder" / "test.mcap"
    assert first.rrd is None
    assert first.read().complete
    assert (first.steps, first.model.modes, first.cached, again.cached) == (700, 1, False, True)
    assert first.samples == len(times_in(first.mcap, "/contact/0"))
    assert again.model.hash == first.model.hash


@pytest.mark.quick
def test_the_same_scene_gives_the_same_bytes(tmp_path):
    """Also in threads beside each other."""
    runner.run(changed(), tmp_path)  # fills the cache
    folders = [tmp_path / name for name in "abc"]
    threads = [threading.Thread(target=runner.run, args=(changed(), folder)) for folder in folders]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    samples = []
    for folder in (tmp_path, *folders):
        with independent_reader(folder / "test.mcap") as reader:
            samples.append([(m.log_time, m.data) for _, _, m in reader.iter_messages()])
    assert len(samples[0]) > 2000
    assert all(each == samples[0] for each in samples[1:])


@pytest.mark.parametrize(("mcap", "rerun"), [(True, True), (False, False)])
def test_only_the_requested_recordings_are_written(tmp_path, mcap, rerun):
    wanted = f"mcap = {mcap}\nrerun = {rerun}\n".lower()
    recording = runner.run(changed(("mcap = true\nrerun = false\n", wanted)), tmp_path / "logs")
    written = {path.name for path in tmp_path.glob("logs/*")}
    requested = {"test.mcap": mcap, "test.foxglove.json": mcap, "test.rrd": rerun}
    assert written == {name for name, wanted in requested.items() if wanted}
    assert (recording.mcap is not None, recording.rrd is not None) == (mcap, rerun)
    if not mcap:
        with pytest.raises(ValueError, match=r"log\.mcap = true"):
            recording.read()


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
    recording = runner.run(scene, tmp_path)
    for channel, _, _ in recording.read().channels.values():
        assert not any(name.startswith(f"{absent}_") for name in channel.names)
    assert column(recording.read(), "/modes", f"{present}_abs")[-1] > 0.4


def test_without_windows_no_contact_motion_is_computed(tmp_path):
    scene = changed((CONTACT, ""))
    assert decisions(scene)["fast motion"] == ("none", "no [[contact]] or [[elastic]] window")
    recording = runner.run(scene, tmp_path)
    assert set(recording.read().channels) == {"/modes", "/forcing", "/energy"}
    assert recording.samples == 0


@pytest.mark.quick
def test_elastic_windows_record_the_motion_of_contact_windows(tmp_path):
    windows = "[[{}]]\nwindow = [100, 150]\n[output]\nelastic = [0]\n"
    alone = runner.run(changed((CONTACT, windows.format("elastic"))), tmp_path)
    assert set(alone.read().channels) == {"/modes", "/forcing", "/energy", "/elastic"}
    found = column(alone.read(), "/elastic", "x_0")
    beside = runner.run(changed((CONTACT, windows.format("contact"))), tmp_path)
    assert alone.samples == found.size
    np.testing.assert_array_equal(found, column(beside.read(), "/elastic", "x_0"))


@pytest.mark.parametrize(("duration", "step"), [(599.7, 0.3), (629.2, 1.1)])
def test_a_window_that_ends_with_the_run_is_recorded(tmp_path, duration, step):
    scene = changed(
        ("duration = 700.0", f"duration = {duration}"),
        ("step = 1.0", f"step = {step}"),
        ("[600.0, 700.0]", f"[590.0, {duration}]"),
    )
    recording = runner.run(scene, tmp_path)
    assert times_in(recording.mcap, "/modes")[-1] == duration
    assert times_in(recording.mcap, "/contact/0")[-1] == duration


@pytest.mark.oracle
def test_contact_channels_obey_the_law_of_the_contact(tmp_path):
    """N = max(0, preload + k_n x_n), |f| <= mu N, and no friction without pressure."""
    law = "mu = 0.5\npreload = 0.1\ntangential_stiffness = 20.0\nnormal_stiffness = 20.0"
    text = changed(("amplitude = 0.15", "amplitude = 0.1")).text
    friction = text[text.index("[friction]") : text.index("[modes]")]
    text = text.replace(friction, f'[[contacts]]\nlaw = "frictional"\n{law}\n')
    data = runner.run(parse_scene(text, "."), tmp_path).read()
    contact, share = data.channels["/contact/0"], data.channels["/contact_share"]
    N, gap, state = (contact.column(name) for name in ("N", "gap", "state"))
    np.testing.assert_allclose(N, np.maximum(0.1 + 20.0 * contact.column("x_n"), 0.0), atol=1e-12)
    names = [name.rpartition("_")[2] for name in share.channel.names]
    assert names == ["stuck", "slipping", "open"]
    np.testing.assert_array_equal(gap > 0.0, N == 0.0)
    open_ = state == np.median(state[N == 0.0])
    np.testing.assert_array_equal(open_, N == 0.0)
    assert np.all(np.abs(contact.column("f")) <= 0.5 * N * (1.0 + 1e-9) + 1e-15)
    assert share.values[0, 2] == pytest.approx(np.mean(open_))
    assert share.values[0].sum() == pytest.approx(1.0) and share.values.min() > 0.02
