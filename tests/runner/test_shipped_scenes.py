"""Every shipped scene: its numbers, its recordings."""

import shutil
import sysconfig

import numpy as np
import pytest
from runs import column, independent_reader, times_in, verified

from slipmode import runner

RERUN = shutil.which("rerun", path=sysconfig.get_path("scripts"))
# Modulus of each mode at the end and at its largest [kg^1/2 m], dissipated energy [J], and the
# largest displacement of each contact inside the windows [m].
PINNED = {
    "beating": {
        "end": (0.579345, 0.0595156),
        "peak": (1.14315, 0.109369),
        "energy": 2.72469,
        "contact": (0.0170086, 0.000502634),
    },
    "blade": {
        "end": (1.55909e-4, 1.25566e-5),
        "peak": (1.72028e-4, 1.26285e-5),
        "energy": 2.02478,
        "contact": (1.74435e-4, 1.73930e-4),
    },
    "bladed-disk": {
        "end": (2.32318e-5,),
        "peak": (1.20950e-4,),
        "energy": 0.337453,
        "contact": (2.63866e-4,),
    },
    "force-step": {
        "end": (2.90467, 1.25215),
        "peak": (8.54002, 3.47656),
        "energy": 1053.88,
        "contact": (0.752337, 0.119376),
    },
    "lap-joint": {
        "end": (5.63343e-5,),
        "peak": (7.33253e-5,),
        "energy": 4.26320e-3,
        "contact": (2.39657e-6, 2.20111e-6, 1.39504e-6, 1.20080e-6),
    },
    "one-mode": {
        "end": (3.12799,),
        "peak": (3.12799,),
        "energy": 183.034,
        "contact": (0.219243, 0.0124875),
    },
    "sweep": {
        "end": (1.27865, 0.326651),
        "peak": (3.06588, 1.25878),
        "energy": 1471.95,
        "contact": (0.242566, 0.156938),
    },
    "two-mode": {
        "end": (3.09181, 1.25198),
        "peak": (3.09778, 1.25433),
        "energy": 716.767,
        "contact": (0.252685, 0.160852),
    },
}


LONGEST = "beating"
MISTUNED = {"mistuned-disk"}  # without modes A and B, see scene/test_mistuned_disks.py


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(name, marks=[pytest.mark.slow] if name == LONGEST else [])
        for name in sorted({*runner.shipped_scenes()} - MISTUNED)
    ],
)
def shipped(request, shipped_scene):
    return shipped_scene(request.param)


ELASTIC = {"blade": 2, "lap-joint": 4, "bladed-disk": 1}  # and how many contacts


def test_shipped_scenes_give_their_numbers(shipped):
    data = shipped.read()
    moduli = np.array([column(data, "/modes", f"{m}_abs") for m in shipped.plan.excited.modes])
    name = shipped.plan.scene.name
    contacts = [column(data, f"/contact/{i}", "x") for i in range(ELASTIC.get(name, 2))]
    found = {
        "end": moduli[:, -1],
        "peak": moduli.max(axis=1),
        "energy": column(data, "/energy", "dissipated_energy")[-1],
        "contact": np.abs(contacts).max(axis=1),
    }
    for quantity, pinned in PINNED[name].items():
        assert found[quantity] == pytest.approx(pinned, rel=1e-3), quantity
    if name in ELASTIC:
        stuck, slipping, open_ = data.channels["/contact_share"].values[0].reshape(-1, 3)[0]
        if name == "bladed-disk":  # whose blades always touch
            assert (stuck, slipping, open_) == pytest.approx((0.18, 0.82, 0.0), abs=0.02)
            return
        assert 0.2 < stuck < 0.5
        assert 0.2 < slipping < 0.6
        assert 0.15 < open_ < 0.4
        return
    assert max(np.abs(column(data, f"/contact/{i}", "f")).max() for i in range(2)) <= 2.0


def test_recordings_of_shipped_scenes_hold_what_the_scene_asks_for(shipped):
    scene, schedule = shipped.plan.scene, shipped.plan.schedule
    slow, contacts = {"/modes", "/forcing", "/energy"}, ELASTIC.get(scene.name, 2)
    fast = {f"/contact/{i}" for i in range(contacts)}
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
    expected = dict.fromkeys(slow, points) | dict.fromkeys(fast, samples) | {"/events": 3}
    # scenes with an estimated error by friction beyond the tolerance have an event about it
    expected |= {"/events": 5, "/contact_share": 1} if scene.name in ELASTIC else {}
    expected |= {"/events": 4} if scene.name in {"beating", "lap-joint", "sweep"} else {}
    expected |= {"/torus": 32 * 64} if two else {}
    expected |= {"/disk": 512} if scene.disk is not None else {}
    assert counts.pop("/overview/modes") == points <= 4096
    assert counts == expected
    assert attachments == {"scene.toml": scene.path.read_bytes()}
    assert metadata["scene"] == {"title": scene.title, "name": scene.name}
    assert metadata["units"]["/contact/0.v"] == "m/s"
    assert metadata["units"]["/energy.dissipated_energy"] == "J"
    assert metadata["run"]["model_hash"] == shipped.model.hash
    for topic in slow:
        assert times_in(shipped.mcap, topic) == pytest.approx(schedule.time(), abs=1e-9)


def test_shipped_scenes_give_no_warning(shipped):
    """Their estimated errors are below 1 % RMS of the amplitudes."""
    assert {event.level for event in shipped.read().events} == {"info"}


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
