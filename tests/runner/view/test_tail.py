"""The tails of a moving point, made in one go."""

import numpy as np
import pytest
import rerun as rr

from slipmode.runner.view.drawing import tails

STARTS = np.where(np.arange(50) < 20, 0, 20)  # two stretches
SHOWN = np.array([0, 5, 19, 20, 33, 49])
LENGTH = 7


@pytest.mark.parametrize(("width", "archetype"), [(2, rr.LineStrips2D), (3, rr.LineStrips3D)])
def test_they_are_what_rerun_makes_of_a_list_of_strips(width, archetype):
    points = np.random.default_rng(1).normal(size=(50, width))
    one_by_one = [points[max(STARTS[i], i + 1 - LENGTH) : i + 1] for i in SHOWN]
    assert [len(strip) for strip in one_by_one] == [1, 6, 7, 1, 7, 7]
    found = tails(points, STARTS, SHOWN, LENGTH)
    assert found.equals(archetype(one_by_one).strips.as_arrow_array())
