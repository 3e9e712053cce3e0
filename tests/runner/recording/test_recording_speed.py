"""What `make bench-recordings` measures and judges; how fast this machine is, is left to it."""

import pytest

from slipmode.runner.report.methods.recordings import LEAST, _kept, measure


@pytest.mark.slow
def test_every_ratio_that_has_a_bound_is_measured(tmp_path):
    lines = list(measure(tmp_path, repeats=1))
    for words in (*LEAST, "times the time without recordings"):
        (line,) = [line for line in lines if words in line]
        assert float(line.split()[0]) > 0.0, line


@pytest.mark.parametrize(
    ("line", "kept"),
    [
        ("        0.29  of the rate of zstd alone (1.00 M/s)", False),
        ("        0.31  of the rate of zstd alone (1.00 M/s)", True),
        ("        5.10  times the time without recordings", False),
        ("write MCAP                  0.01 M/s", True),
    ],
)
def test_ratios_are_judged(line, kept):
    assert _kept(line) == kept
