"""Why NLvib's curve as it is shipped is 0.6 % off ours: it has seven harmonics."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slipmode.runner.report.answers.curves import balanced, nlvib_beam

PUBLISHED = Path(__file__).parents[4] / "shared" / "data" / "published"


@pytest.mark.skipif(not PUBLISHED.exists(), reason="needs published/ of the shared data")
@pytest.mark.slow
def test_nlvib_example_08_is_as_far_off_as_its_harmonics():
    """With seven ours is within 0.05 % of the peak; with 21 and with 51 it is 0.60 % off."""
    published = np.load(PUBLISHED / "nlvib08_reference.npz")
    order = np.argsort(published["OM_1"])
    expected = 0.5 * np.abs(published["h1_1"][order])
    beam = nlvib_beam(PUBLISHED)
    off = {}
    for harmonics in (7, 21, 51):
        carriers = list(balanced(replace(beam, harmonics=harmonics), published["OM_1"][order]))
        apart = np.abs(np.abs(np.array(carriers)[:, 0]) - expected)
        off[harmonics] = apart.max() / expected.max()
    assert off[7] <= 6e-4
    assert off[21] == pytest.approx(6e-3, rel=0.1)
    assert off[51] == pytest.approx(off[21], rel=0.03)
