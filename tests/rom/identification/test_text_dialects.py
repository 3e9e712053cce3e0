"""Text files in dialects drawn at random by an independent writer."""

import re

import numpy as np
import pytest
from measured.dialects import write_drawn

from slipmode import rom


@pytest.mark.parametrize("seed", range(200))
def test_drawn_text_files_are_read_right_or_refused(seed, tmp_path):
    path = tmp_path / "hit.txt"
    true = write_drawn(path, seed)
    given = {"quantity": "x", "unit": None if true.unit else "m/s", "sample_rate": true.given}
    try:
        found = rom.read_measurement(path, **given)
    except rom.SlipmodeError as error:
        # Commas that separate columns and decimals cannot be distinguished.
        assert true.ambiguous, true.dialect
        assert re.search(r"hit.txt: line \d+: commas may be decimal marks", str(error))
        return
    (record,) = found.records
    assert found.channels == true.names, true.dialect
    assert found.unit == (true.unit or "m/s")
    assert record.sample_rate == pytest.approx(true.rate, rel=1e-4)
    assert record.signal.shape == true.values.shape
    np.testing.assert_allclose(record.signal, true.values, rtol=0.0, atol=1.001 * true.rounding)
