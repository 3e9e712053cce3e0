"""The examples of the documentation run as they are printed."""

import pytest

import rom


def test_the_example_of_the_package_runs():
    lines = rom.__doc__.splitlines()
    example = "\n".join(line.strip() for line in lines if " = " in line)
    assert example.count("\n") >= 3
    names = {"rom": rom}
    exec(example, names)
    assert abs(names["a_A"]) == pytest.approx(3.0951, rel=1e-3)
    assert abs(names["a_B"]) == pytest.approx(1.2515, rel=1e-3)
