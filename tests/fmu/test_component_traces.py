"""Traces: the outputs of a component after each internal step."""

import numpy as np
import pytest
from stepping import (
    HELD,
    amplitude,
    component,
    march,
    state_of,
)

from slipmode.fmu import StoppedError
from slipmode.rom import SlipmodeError

pytestmark = pytest.mark.quick


LENGTHS = np.array([50.0, 0.2, 3000.0, 400.0])


def scripted(traced):
    """Inputs of steps of LENGTHS: a jump, a ramp, a sweep."""
    inputs = np.tile([HELD.get(name, 0.0) for name in traced.input_names], (LENGTHS.size, 1))
    inputs[2:, traced.input_names.index("force_A")] = 0.05
    inputs[2, traced.input_names.index("frequency_rate_A")] = 2e-6
    inputs[3, traced.input_names.index("force_rate_B")] = -2e-4
    return inputs


def traced_rows(traced, lengths, inputs):
    return np.concatenate(list(traced.trace(lengths, inputs)))


@pytest.mark.parametrize("contact", [False, True])
def test_a_trace_passes_through_the_outputs_of_a_run(contact):
    traced, run = (component({}, contact=contact, tolerance=1e-8) for _ in range(2))
    inputs = scripted(traced)
    found, expected = traced_rows(traced, LENGTHS, inputs), run.run(LENGTHS, inputs)
    ends = np.searchsorted(found[:, 0], np.cumsum(LENGTHS) * (1 - 1e-12))
    np.testing.assert_allclose(found[ends, 0], np.cumsum(LENGTHS), rtol=1e-13)
    np.testing.assert_allclose(found[ends, 1:5], expected[:, 1:5], rtol=0, atol=1e-6)
    assert ends[-1] == len(found) - 1
    assert np.all(np.diff(found[:, 0]) > 0.0)
    march(traced, [7.0])
    march(run, [7.0])
    np.testing.assert_allclose(amplitude(traced), amplitude(run), atol=1e-6)


def test_a_trace_rests_where_nothing_happens():
    traced = component({}, tolerance=1e-6)
    rows = traced_rows(traced, LENGTHS, scripted(traced))
    modulus = np.hypot(rows[:, 1], rows[:, 2])
    busy = rows[:, 0] < 200.0
    assert np.diff(rows[busy, 0]).max() < 20.0 < np.diff(rows[:, 0]).max()
    fine = component({}, tolerance=1e-10)
    lengths = np.concatenate([np.full(round(length / 0.1), 0.1) for length in LENGTHS])
    inputs = np.repeat(scripted(fine), np.rint(LENGTHS / 0.1).astype(int), axis=0)
    since = np.concatenate([0.1 * np.arange(round(length / 0.1)) for length in LENGTHS])
    for name in ("force_B", "frequency_A"):
        rate = fine.input_names.index(name.replace("_", "_rate_"))
        inputs[:, fine.input_names.index(name)] += inputs[:, rate] * since
    every = fine.run(lengths, inputs)
    assert modulus.max() == pytest.approx(np.hypot(every[:, 1], every[:, 2]).max(), rel=1e-2)
    assert len(rows) < 0.02 * len(every)


def test_a_trace_does_not_depend_on_how_it_is_cut_into_parts(monkeypatch):
    whole, parts = component({}), component({})
    expected = traced_rows(whole, LENGTHS, scripted(whole))
    monkeypatch.setattr("slipmode.fmu.component._TRACED_ROWS", 7)
    found = list(parts.trace(LENGTHS, scripted(parts)))
    assert max(map(len, found)) == 7
    np.testing.assert_array_equal(np.concatenate(found), expected)
    assert state_of(parts) == state_of(whole)


def test_a_trace_that_leaves_the_table_goes_up_to_its_edge():
    traced = component({})
    inputs = scripted(traced)
    inputs[:, traced.input_names.index("force_A")] = 0.3
    rows = []
    with pytest.raises(StoppedError, match=r"amplitude \|A\| leaves the friction table") as stop:
        rows.extend(traced.trace(LENGTHS, inputs))
    assert stop.value.left_table
    last = np.concatenate((*rows, stop.value.outputs))[-1]
    assert np.hypot(*last[1:3]) == pytest.approx(traced.model.table.amplitude_range[0], rel=1e-3)
    assert traced.time == last[0] == stop.value.time
    traced.reset()
    march(traced, [1.0])


def test_steps_that_cannot_be_traced_are_refused():
    traced = component({})
    inputs = scripted(traced)
    with pytest.raises(SlipmodeError, match="inputs: must have shape"):
        next(traced.trace(LENGTHS, inputs[1:]))
    with pytest.raises(StoppedError, match="step: must be finite and > 0 s, got -1"):
        list(traced.trace(np.array([1.0, -1.0]), inputs[:2]))
    assert traced.time == 1.0
