"""Scripted scalars: right-continuous piecewise linear functions of time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipmode.rom import SlipmodeError
from slipmode.runner.scene.script import Script

pytestmark = pytest.mark.quick

RAMP_AND_JUMP = Script.through([[0, 1.0], [10, 3.0], [10, 5.0], [20, 5.0]])


@pytest.mark.parametrize(
    ("t", "value", "before", "rate"),
    [
        (-1.0, 1.0, 1.0, 0.0),
        (0.0, 1.0, 1.0, 0.2),
        (5.0, 2.0, 2.0, 0.2),
        (10.0, 5.0, 3.0, 0.0),
        (15.0, 5.0, 5.0, 0.0),
        (99.0, 5.0, 5.0, 0.0),
    ],
)
def test_is_linear_between_breakpoints_constant_outside_and_right_continuous(
    t, value, before, rate
):
    assert RAMP_AND_JUMP.value(t) == pytest.approx(value)
    assert RAMP_AND_JUMP.value_before(t) == pytest.approx(before)
    assert RAMP_AND_JUMP.rate(t) == pytest.approx(rate)


def test_arrays_of_times_keep_their_shape_and_agree_with_single_times():
    t = np.linspace(-5.0, 25.0, 24).reshape(4, 6)
    for method in (RAMP_AND_JUMP.value, RAMP_AND_JUMP.value_before, RAMP_AND_JUMP.rate):
        one_by_one = np.array([method(float(moment)) for moment in t.ravel()])
        np.testing.assert_array_equal(method(t), one_by_one.reshape(4, 6))


@pytest.mark.parametrize(
    ("points", "breaks"),
    [
        ([[0, 4.0]], ()),
        ([[0, 1.0], [10, 3.0], [10, 5.0], [20, 5.0]], (0.0, 10.0)),
        ([[0, 1.0], [1, 2.0], [2, 3.0]], (0.0, 2.0)),
        ([[3, 1.0], [3, 1.0]], ()),
        ([[3, 1.0], [3, 2.0]], (3.0,)),
    ],
)
def test_breaks_are_where_the_value_jumps_or_the_slope_changes(points, breaks):
    assert Script.through(points).breaks == breaks


@pytest.mark.parametrize(
    ("t0", "t1", "expected"),
    [
        (0.0, 5.0, (1.0, 2.0)),
        (5.0, 10.0, (2.0, 5.0)),
        (10.0, 20.0, (5.0, 5.0)),
        (-5.0, 30.0, (1.0, 5.0)),
    ],
)
def test_range_takes_in_both_sides_of_a_jump_but_not_what_was_before(t0, t1, expected):
    assert RAMP_AND_JUMP.range(t0, t1) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([], "at least one breakpoint"),
        ([[1, 0.0], [0, 1.0]], "sorted in time, got t = 0 after 1"),
        ([[1, 0.0], [1, 1.0], [1, 2.0]], "at most two breakpoints"),
        ([[0, 0.0], [5e-324, 1.0]], "must be further apart in time"),
    ],
)
def test_refuses_breakpoints_that_are_no_function(points, message):
    with pytest.raises(SlipmodeError, match=message):
        Script.through(points)


@given(
    st.lists(st.integers(0, 50), min_size=2, max_size=6, unique=True).map(sorted),
    st.data(),
)
def test_without_jumps_it_is_numpy_interpolation(times, data):
    values = data.draw(st.lists(st.floats(-9, 9), min_size=len(times), max_size=len(times)))
    t = np.linspace(-5.0, 55.0, 61)
    script = Script(tuple(map(float, times)), tuple(values))
    np.testing.assert_allclose(script.value(t), np.interp(t, times, values), atol=1e-12)


@given(st.floats(-5.0, 25.0), st.floats(0.0, 30.0))
def test_values_stay_within_the_range(t0, length):
    low, high = RAMP_AND_JUMP.range(t0, t0 + length)
    values = RAMP_AND_JUMP.value(np.linspace(t0, t0 + length, 50))
    assert low - 1e-12 <= values.min()
    assert values.max() <= high + 1e-12
