"""Hard cases: how the cost of a contact step grows with the number of contacts."""

import math
from functools import cache
from itertools import pairwise

import pytest

from benchmarks.contact_solves import ALPHA, CONTACTS, step_cost

cost = cache(step_cost)


@pytest.mark.parametrize("alpha", [None, ALPHA], ids=["Coulomb", "tanh"])
@pytest.mark.parametrize(("few", "many"), pairwise(CONTACTS))
def test_the_cost_of_a_step_grows_like_the_square(few, many, alpha):
    """Exponent 2, or up to 2.5 where matrices of 100 contacts leave the caches.

    Contacts begin or cease to slip one after the other, and conjugate gradients take as many
    products however many contacts; a factorisation at every stage would make it 3.
    """
    exponent = math.log(cost(many, alpha) / cost(few, alpha)) / math.log(many / few)
    assert exponent <= 2.5
