"""Every shipped scene runs without a warning, and its recording has what it asks for."""

import re

import numpy as np
import pytest
from beside_oracle import relative_rms, with_laws
from oracles.system import Tanh
from runs import column, independent_reader, times_in
from scene_motion import Force, integrated

from slipmode import rom
from slipmode.__main__ import main
from slipmode.runner import load_scene, shipped_scenes

SHIPPED = ("beating", "blade", "bladed-disk", "force-step", "internal-resonance", "lap-joint")
SHIPPED += ("one-mode", "sweep", "two-mode", "wedge-damper")
OF_ONE_TONE = {"mistuned-disk", "square-plate"}  # see scene/test_shared_tone.py, test_disk_runs.py
SLOW = {"beating", "blade", "force-step", "internal-resonance", "sweep", "wedge-damper"}


def each(names):
    return [pytest.param(n, marks=[pytest.mark.slow] if n in SLOW else []) for n in names]


def test_the_list_of_scenes_is_complete():
    assert {*shipped_scenes()} == {*SHIPPED} | OF_ONE_TONE
    for name, path in shipped_scenes().items():
        scene = load_scene(name)
        assert (scene.name, scene.path) == (name, path)
        assert scene.title


@pytest.mark.parametrize("name", each(SHIPPED))
def test_a_shipped_scene_records_what_it_asks_for_without_a_warning(name, shipped_scene):
    shipped = shipped_scene(name)
    scene, schedule = shipped.plan.scene, shipped.plan.schedule
    assert {event.level for event in shipped.read().events} == {"info"}
    assert main(["plan", name]) == 0
    with independent_reader(shipped.mcap) as reader:
        summary = reader.get_summary()
        counts = {
            summary.channels[number].topic: count
            for number, count in summary.statistics.channel_message_counts.items()
        }
        attachments = {record.name: record.data for record in reader.iter_attachments()}
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        assert sum(1 for _ in reader.iter_messages()) == summary.statistics.message_count
    assert {counts[topic] for topic in ("/modes", "/forcing", "/energy")} == {schedule.steps + 1}
    assert counts["/contact/0"] == shipped.samples
    assert ("/elastic" in counts) == bool(scene.output.elastic)
    assert attachments == {"scene.toml": scene.path.read_bytes()}
    assert metadata["run"]["model_hash"] == shipped.model.hash
    assert metadata["units"]["/contact/0.v"] == "m/s"
    time = np.array(times_in(shipped.mcap, "/modes"))
    assert (time[0], time[-1]) == (0.0, scene.run.duration)
    assert np.diff(time).max() == pytest.approx(scene.run.step)
    (window,) = scene.contact
    time = np.array(times_in(shipped.mcap, "/contact/0"))
    assert (time[0], time[-1]) == (window.start, window.end)
    assert np.ptp(np.diff(time)) < 1e-8


def forces_of(scene):
    """The forces of a scene, each at one DOF, with constant frequencies or sweeps."""
    found = []
    for script in scene.forcing.values():
        parts = [
            np.transpose((part.times, part.values)).tolist()
            for part in (script.amplitude, script.frequency, script.phase)
        ]
        found.append(Force(script.vector(4).tolist(), *parts))
    return found


@pytest.mark.oracle
@pytest.mark.parametrize("name", each(["one-mode", "two-mode", "beating", "sweep"]))
def test_the_motion_of_two_masses_is_the_independent_one(name, shipped_scene):
    """Within the 1 % that a run without a warning allows; the friction forces at their limit."""
    shipped = shipped_scene(name)
    scene, data = shipped.plan.scene, shipped.read()
    law = 2 * [Tanh(scene.friction.limit, scene.friction.alpha)]
    beta = float(re.search(r"^damping = (\S+)", scene.text, re.MULTILINE)[1])
    system = with_laws(rom.two_mass(beta=beta), law)
    exact = integrated(system, forces_of(scene), scene.run.duration, 512)
    contact = data.channels["/contact/0"]
    error = relative_rms(contact.column("x"), exact.at(contact.time)[:, 2])
    assert error < 1e-2
    for i in range(2):
        f, v = (column(data, f"/contact/{i}", name) for name in "fv")
        np.testing.assert_allclose(f, law[0].limit * np.tanh(v / law[0].alpha), atol=1e-3)
