"""Tables with a margin of the amplitude range."""

import numpy as np
import pytest

from slipmode.rom import SlipmodeError, Tanh, reduce, tabulate, two_mass
from slipmode.rom.table.cache import cached_model

LAW = Tanh(2.0, 0.02)
RANGE = {(0,): (3.6,), (0, 1): (3.6, 1.5)}


@pytest.mark.parametrize("modes", RANGE)
@pytest.mark.parametrize("headroom", [1.0, 1.3])
def test_the_table_ends_at_headroom_times_the_amplitude(modes, headroom):
    reduced, amplitude = reduce(two_mass(beta=0.01), modes), np.array(RANGE[modes])
    longer = tabulate(reduced, LAW, amplitude, 1e-2, headroom=headroom)
    np.testing.assert_array_equal(longer.table.amplitude_range, headroom * amplitude)
    assert longer.hash == tabulate(reduced, LAW, headroom * amplitude, 1e-2).hash


def test_the_cache_has_one_entry_for_one_range():
    reduced = reduce(two_mass(beta=0.01), (0,))
    longer, cached = cached_model(reduced, LAW, (3.6,), 1e-2, headroom=1.3)
    again, found = cached_model(reduced, LAW, (1.3 * 3.6,), 1e-2)
    assert (cached, found) == (False, True)
    assert longer.hash == again.hash


@pytest.mark.parametrize("headroom", [0.9, np.nan, np.inf])
def test_what_is_no_headroom_is_refused(headroom):
    with pytest.raises(SlipmodeError, match="headroom: must be a finite number >= 1"):
        tabulate(reduce(two_mass(beta=0.01), (0,)), LAW, (3.6,), headroom=headroom)
