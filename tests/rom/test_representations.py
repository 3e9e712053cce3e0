"""What is printed of objects that hold arrays: a line, however large they are."""

import dataclasses

import numpy as np

from slipmode import rom

MOST = 400  # characters of a line


def check(shown, *words):
    assert "\n" not in shown
    assert 0 < len(shown) < MOST
    assert all(word in shown for word in words)


def test_objects_with_arrays_are_a_line_each(two_mode_model):
    model = two_mode_model
    for part in (model.reduced, model.table, model.harmonics, model.accuracy):
        check(repr(part))
    nodes = f"{model.table.node_a.size} x {model.table.node_b.size} nodes to 4, 4"
    check(repr(model), "2 modes, 2 contacts, consistent, Tanh(limit=2.0, alpha=0.02)", nodes)
    many = rom.Tanh(np.linspace(1.0, 2.0, 300), 0.1)
    assert repr(many) == "Tanh(limit=<tuple of 300>, alpha=0.1)"
    check(repr(dataclasses.replace(model, law=many)))
    check(repr(rom.two_mass()), "4 DOFs, 2 contacts, dense")
    check(str(rom.travelling_wave(rom.lumped_disk(12, 1e-5), rom.Jenkins(1.0, 5e4), 3)))


def test_a_run_is_a_few_lines(shipped_scene):
    recording = shipped_scene("one-mode")
    data = recording.read()
    for each in (recording.plan, recording.plan.scene, recording.plan.schedule, data):
        check(repr(each))
    shown = str(recording)
    assert len(shown.splitlines()) <= 4
    for words in (str(recording.mcap), str(recording.rrd), "/contact/1", "800 s", "complete"):
        assert words in shown
