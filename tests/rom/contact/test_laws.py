"""Friction laws as values: equal and of one hash where they are the same law."""

import numpy as np
import pytest

from slipmode.rom import Coulomb, Tanh


@pytest.mark.parametrize("law", [lambda limit: Tanh(limit, 0.1), Coulomb], ids=["tanh", "coulomb"])
@pytest.mark.parametrize("make", [tuple, list, np.array, lambda v: np.array(v, dtype=np.float32)])
def test_laws_compare_and_hash_by_value(law, make):
    one, same, other = law(make([2.0, 0.5])), law((2.0, 0.5)), law(make([2.0, 0.25]))
    assert one == same
    assert hash(one) == hash(same)
    assert one != other
    assert len({one, same, other}) == 2


@pytest.mark.parametrize("limit", [2, 2.0, np.float64(2.0), np.array(2.0), np.int64(2)])
def test_one_limit_is_a_number(limit):
    assert Coulomb(limit) == Coulomb(2.0)
    assert type(Coulomb(limit).limit) is float
    assert Coulomb(limit) != Coulomb((2.0,))


def test_a_law_keeps_its_limits_when_the_array_changes():
    limits = np.array([2.0, 0.5])
    law = Tanh(limits, np.float64(0.1))
    limits[:] = 7.0
    assert law == Tanh((2.0, 0.5), 0.1)
    assert Tanh(2.0, 0.1) != Coulomb(2.0)
