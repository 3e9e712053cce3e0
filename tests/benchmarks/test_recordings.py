"""What `make bench-recordings` measures; how fast this machine is, is not tested."""

import pytest

from benchmarks.recordings import measure


@pytest.mark.slow
def test_every_ratio_is_measured(tmp_path):
    lines = list(measure(tmp_path, repeats=1))
    for words in (
        "times the mcap package, messages encoded before",
        "times the mcap package with protobuf encoding",
        "of the rate of zstd alone",
        "times the mcap package with protobuf decoding",
        "of the rate of bare send_columns",
        "times the time without recordings",
    ):
        (line,) = [line for line in lines if words in line]
        assert float(line.split()[0]) > 0.0, line
