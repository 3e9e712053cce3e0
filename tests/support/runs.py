"""Scenes that several tests run, and readings of what they record."""

from contextlib import contextmanager
from dataclasses import replace

from mcap.reader import make_reader

from slipmode import runner
from slipmode.runner import parse_scene

TANH_ON_BOTH_MODES = """\
[friction]
law = "tanh"
limit = 2.0
alpha = 0.02
[modes]
A = 0
B = 1
"""

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


def replaced(text, *changes):
    """Return text with other parts, each of which is in it."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def changed(*changes):
    return replace(parse_scene(replaced(SCENE, *changes), "."), name="test")


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
