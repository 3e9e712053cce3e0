"""The ratios that `make bench-recordings` prints, against bounds that a busy machine keeps."""

import pytest

from slipmode.runner.report.methods.recordings import measure

LEAST = {
    "times the mcap package with protobuf encoding": 5.0,
    "of the rate of zstd alone": 0.3,
    "times the mcap package with protobuf decoding": 10.0,
    "of the rate of bare send_columns": 0.15,
}


@pytest.mark.slow
def test_recordings_are_fast(tmp_path):
    lines = list(measure(tmp_path, repeats=5))
    for words, least in LEAST.items():
        (line,) = [line for line in lines if words in line]
        assert float(line.split()[0]) > least, line
    assert float(lines[-1].split()[0]) < 5.0, lines[-1]
