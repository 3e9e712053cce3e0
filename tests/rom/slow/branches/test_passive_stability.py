"""Curves of passive structures with one mode have no Hopf point.

The trace of the Jacobian of the slow flow is -(1 / A) d(A^2 delta) / dA, and the dissipated power
A^2 delta grows with A for every passive contact.
"""

import pytest
from evidence.answers import forces, reduced, variant

from slipmode import rom

pytestmark = pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")


@pytest.mark.oracle
@pytest.mark.parametrize("seeds", [range(2), pytest.param(range(2, 100), marks=pytest.mark.slow)])
def test_no_hopf_point_and_no_fold_of_drawn_structures(seeds):
    """Jenkins and Iwan contacts with constant normal loads, forced up to well beyond slip."""
    curves = 0
    for seed in seeds:
        given = variant(seed, ("Jenkins", "Iwan"), 1)
        small, law = reduced(given)
        Omega, size = given.tones[0].Omega, 2.0 * given.amplitude[0]
        span = (0.92 * Omega, 1.06 * Omega)
        try:
            model = rom.tabulate(small, law, (size,), (1e-2, 1e-3)[seed % 2])
            found = [
                rom.response_curve(
                    model, [Omega], [factor * each for each in forces(given)], "frequency_A", span
                )
                for factor in (0.3, 1.0, 1.8)
            ]
        except rom.SlipmodeError:  # the response of the modes does not converge, or is too strong
            continue
        for curve in found:
            assert curve.special == (), given.name
            assert curve.stable.all(), given.name
        curves += len(found)
    assert curves >= 2 * len(seeds)
