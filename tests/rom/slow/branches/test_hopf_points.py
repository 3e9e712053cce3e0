"""Hopf points and the beats beyond them, beside time integration.

Friction holds the flutter of the first mode at |a| = 1.1; the force catches it near resonance.
"""

import numpy as np
import pytest
from beside_oracle import demodulated, fluttering, system_of

from slipmode import rom

pytestmark = pytest.mark.oracle

FORCE = 0.04
FLUTTER = -0.015j
ASIDE = 0.02  # of the amplitude: where runs begin
LONG = 6.0  # over the growth of the fastest deviation: how long they take
KEPT, LEFT = 0.01, 0.04  # of the amplitude: how far they are from it at the end


@pytest.fixture(scope="module")
def two_masses():
    """The structure for time integration, and its model."""
    structure, law = rom.two_mass(beta=0.01), rom.Coulomb(2.0)
    plain = rom.reduce(structure, (0,))
    system = fluttering(system_of(structure, law), plain.mode_shapes[:, 0], FLUTTER)
    reduced = rom.reduce(structure, modes=(0,), aerodynamics=(FLUTTER,))
    return system, rom.tabulate(reduced, law, (8.0,), 1e-3)


@pytest.fixture(scope="module")
def curve(two_masses):
    _, model = two_masses
    return rom.response_curve(model, (0.98,), ({0: FORCE},), "frequency_A", (0.95, 1.03))


@pytest.mark.parametrize(
    ("vary", "frequency", "span", "reach", "part"),
    [
        ("frequency_A", 1.0, (1.0, 1.03), 0.008, 0.6),
        pytest.param("force", 1.015, (0.8, 2.5), 0.5, -0.3, marks=pytest.mark.slow),
        pytest.param("force", 1.015, (0.8, 2.5), 0.5, 0.3, marks=pytest.mark.slow),
    ],
)
def test_runs_keep_to_stable_states_and_leave_unstable_ones(
    two_masses, vary, frequency, span, reach, part
):
    system, model = two_masses
    curve = rom.response_curve(model, [frequency], [{0: FORCE}], vary, span)
    # Two folds 3e-6 apart are where slip begins, also in a table of half the tolerance.
    (point,) = (each for each in curve.special if each.kind == "Hopf")
    value = point.parameter + part * reach
    ((a,),), (stable,) = curve.at(value)
    assert stable == ((part < 0.0) == (vary == "frequency_A"))
    factor, Omega = (1.0, value) if vary == "frequency_A" else (value, frequency)
    growth = curve.growth[np.abs(curve.parameter - value).argmin()]
    periods = int(LONG / abs(growth) * Omega / (2.0 * np.pi))
    steps = 1024 if vary == "frequency_A" else 4096  # 1 % off in amplitude with 1024
    found = demodulated(
        *(system, model.reduced.mode_shapes[:, 0], Omega, {0: factor * FORCE}),
        *((1.0 + ASIDE) * a, periods, steps),
    )
    away = np.abs(found[-periods // 5 :] - a).max() / abs(a)
    assert away <= KEPT if stable else away >= LEFT


def test_beats_reach_the_stated_amplitudes(two_masses, curve):
    """From rest, long after the beginning; beats vary the amplitude by more than 1.3."""
    system, model = two_masses
    cycles = curve.cycles
    assert cycles.parameter.size >= 10
    k = 2
    size = np.abs(
        demodulated(
            *(system, model.reduced.mode_shapes[:, 0], cycles.parameter[k], {0: FORCE}),
            *(0.0, 1200, 512),
        )
    )[500:]
    assert size.min() == pytest.approx(cycles.lowest[k, 0], abs=0.03 * size.max())
    assert size.max() == pytest.approx(cycles.highest[k, 0], rel=0.03)
    assert size.max() > 1.3 * size.min()
