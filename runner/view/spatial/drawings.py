"""The drawings in space that a recording has."""

from __future__ import annotations

from collections.abc import Sequence

from slipmode.runner.recording.channels import Channel
from slipmode.runner.view.drawing import Drawing
from slipmode.runner.view.spatial import blade_map, disk_view, torus_view

_DRAWINGS = (torus_view.DRAWING, disk_view.DRAWING, blade_map.DRAWING)


def drawings(channels: Sequence[Channel]) -> list[Drawing]:
    """Return the drawings whose channels are recorded."""
    topics = {channel.topic for channel in channels}
    return [drawing for drawing in _DRAWINGS if topics.issuperset(drawing.topics)]
