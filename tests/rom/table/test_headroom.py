"""Tables that go further than was asked for: the same up to there."""

import numpy as np
import pytest

from slipmode.rom import Coulomb, SlipmodeError, Tanh, reduce, tabulate, two_mass
from slipmode.rom.table.region import Region

LAW = Tanh(2.0, 0.02)
RANGE = {(0,): (3.6,), (0, 1): (3.6, 1.5)}


def inside(model, amplitude):
    """Nodes of the first mode up to an amplitude."""
    return model.table.node_a[model.table.node_a <= amplitude * (1.0 + 1e-12)]


@pytest.mark.parametrize("modes", RANGE)
@pytest.mark.parametrize("law", [LAW, Coulomb(2.0)])
def test_up_to_the_amplitudes_it_is_the_table_without(modes, law):
    reduced, amplitude = reduce(two_mass(beta=0.01), modes), RANGE[modes]
    without = tabulate(reduced, law, amplitude, 1e-2, harmonics=3)
    longer = tabulate(reduced, law, amplitude, 1e-2, harmonics=3, headroom=1.25)
    np.testing.assert_allclose(longer.table.amplitude_range, 1.25 * np.array(amplitude))
    for long, short in zip(longer.table.axes, without.table.axes, strict=True):
        assert np.isin(short, long).all()
    points = np.random.default_rng(1).uniform(0.0, 1.0, (200, len(modes))) * amplitude
    largest = np.abs(without.table(points)).max(axis=0)
    apart = np.abs(longer.table(points) - without.table(points)).max(axis=0)
    assert np.all(apart < 1e-12 * largest)


def test_beyond_it_is_as_exact():
    reduced = reduce(two_mass(beta=0.01))
    amplitude = np.array(RANGE[(0, 1)])
    longer = tabulate(reduced, LAW, amplitude, 1e-2, headroom=1.25)
    whole = tabulate(reduced, LAW, 1.25 * amplitude, 1e-3)
    points = np.random.default_rng(2).uniform(0.0, 1.25, (400, 2))
    points = points[points.max(axis=1) > 1.0] * amplitude
    largest = np.abs(longer.table.nodes()[..., :2]).max(axis=(0, 1))
    assert np.abs((longer.table(points) - whole.table(points)) / largest).max() < 1.2e-2
    assert longer.accuracy.interpolation <= 1e-2


def test_headroom_goes_by_eighths():
    reduced = reduce(two_mass(beta=0.01), (0,))
    table = tabulate(reduced, LAW, (3.6,), headroom=1.3).table
    assert table.amplitude_range == pytest.approx([3.6 * 1.375])


@pytest.mark.parametrize("headroom", [0.9, np.nan, np.inf])
def test_what_is_no_headroom_is_refused(headroom):
    with pytest.raises(SlipmodeError, match="headroom: must be a finite number >= 1"):
        tabulate(reduce(two_mass(beta=0.01), (0,)), LAW, (3.6,), headroom=headroom)


def test_a_region_has_none():
    path = np.array([(0.0, 0.0), (1.0, 1.0)])
    region = Region.along(path, RANGE[(0, 1)], np.array([0.1, 0.1]))
    with pytest.raises(SlipmodeError, match="headroom: must be 1"):
        tabulate(reduce(two_mass(beta=0.01)), LAW, RANGE[(0, 1)], region=region, headroom=1.25)
