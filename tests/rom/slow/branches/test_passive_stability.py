"""Curves of passive structures with one mode have no Hopf point.

The trace of the Jacobian of the slow flow is -(1 / A) d(A^2 delta) / dA, and the dissipated power
A^2 delta grows with A for every passive contact.
"""

import pytest
from evidence.answers import forces, reduced, variant

from slipmode import rom

SEEDS = 100
pytestmark = pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")


@pytest.mark.oracle
@pytest.mark.slow
def test_no_hopf_point_and_no_fold_of_drawn_structures():
    """Jenkins and Iwan contacts with constant normal loads, forced up to well beyond slip."""
    curves = 0
    for seed in range(SEEDS):
        small, law = reduced(given := variant(seed, ("Jenkins", "Iwan"), 1))
        Omega, size = given.tones[0].Omega, 2.0 * given.amplitude[0]
        try:
            model = rom.tabulate(small, law, (size,), (1e-2, 1e-3)[seed % 2])
            for factor in (0.3, 1.0, 1.8):
                load, span = factor * forces(given)[0], (0.92 * Omega, 1.06 * Omega)
                curve = rom.response_curve(model, [Omega], [load], "frequency_A", span)
                assert not curve.special and curve.stable.all(), given.name
                curves += 1
        except rom.SlipmodeError:
            continue  # the response of the modes does not converge, or is too strong
    assert curves >= 2 * SEEDS
