"""Verdicts about stability on both sides of Hopf points, against full order: 40 in all.

Two self-excited structures, the two masses and a cantilever of finite elements with an elastic
contact, each through a Hopf point against frequency and through one against force: friction holds
the flutter where it slips, and not where the forced vibration is too small for that.
"""

import numpy as np
import pytest
from elastic.frictional_beam import DAMPING, TIP
from elastic.frictional_beam import structure as beam

from slipmode import rom
from slipmode.rom import full

SAMPLES = 32  # of a period
ASIDE = 0.02  # of the amplitude: where runs begin
LONG = 6.0  # over the growth of the fastest deviation: how long they take
KEPT, LEFT = 0.01, 0.04  # of the amplitude: how far they are from it at the end
PARTS = (0.05, 0.15, 0.3, 0.6, 1.0)  # of the way from a Hopf point


@pytest.fixture(scope="module")
def two_masses():
    structure = rom.two_mass(beta=0.01)
    reduced = rom.reduce(structure, modes=(0,), aerodynamics=(-0.015j,))
    return structure, rom.tabulate(reduced, rom.Coulomb(2.0), (8.0,), 1e-3)


@pytest.fixture(scope="module")
def cantilever():
    law = rom.Jenkins(limit=0.1, stiffness=40.0)
    structure = beam(law, 3)
    omega = rom.reduce(structure, (0,), law=law).frequency[0]
    flutter = -1j * (0.1 + 2.0 * DAMPING * omega**2)
    reduced = rom.reduce(
        structure, (0,), law=law, aerodynamics=(flutter,), force_patterns=[{TIP: 1.0}]
    )
    return structure, rom.tabulate(reduced, law, (0.04,), 1e-3)


def end_of_run(structure, model, force, frequency, a, growth):
    """Largest distance from a steady state over the last fifth of a run from beside it."""
    shape = model.reduced.mode_shapes[:, 0]
    beside = (1.0 + ASIDE) * a * shape
    periods = int(LONG / abs(growth) * frequency / (2.0 * np.pi))
    times = np.arange(periods * SAMPLES) * 2.0 * np.pi / (frequency * SAMPLES)
    body = full.aeroelastic(structure, model.reduced)
    motion = full.integrate(
        body,
        model.law,
        full.Excitation.harmonic(body, [force], [frequency]),
        times,
        steps_per_period=2 * SAMPLES,
        outputs=(shape @ structure.mass)[np.newaxis],
        start=full.State(0.0, 2.0 * beside.real, -2.0 * frequency * beside.imag),
    )
    window = np.hanning(2 * SAMPLES + 1)[:-1] / SAMPLES
    carried = motion.displacement[:, 0] * np.exp(-1j * frequency * motion.time)
    found = np.convolve(carried, window, "valid")[-periods * SAMPLES // 5 :]
    return np.abs(found - a).max() / abs(a)


@pytest.mark.slow
@pytest.mark.parametrize("part", [*(-part for part in PARTS), *PARTS])
@pytest.mark.parametrize(
    ("name", "dof", "size", "frequency", "vary", "span", "hopf", "reach"),
    [
        ("two_masses", 0, 0.04, 1.0, "frequency_A", (1.0, 1.03), 1.00963, 0.008),
        ("two_masses", 0, 0.04, 1.015, "force", (0.8, 2.5), 1.5322, 0.5),
        ("cantilever", TIP, 0.004, 3.6, "frequency_A", (3.58, 3.68), 3.6287, 0.02),
        ("cantilever", TIP, 0.004, 3.64, "force", (0.5, 2.0), 1.2308, 0.4),
    ],
    ids=["masses-frequency", "masses-force", "cantilever-frequency", "cantilever-force"],
)
def test_full_order_agrees_beside_hopf_points(
    request, name, dof, size, frequency, vary, span, hopf, reach, part
):
    structure, model = request.getfixturevalue(name)
    curve = rom.response_curve(model, [frequency], [{dof: size}], vary, span)
    (point,) = curve.special
    assert point.kind == "Hopf"
    # the force is as exact as friction in the table
    assert point.parameter == pytest.approx(hopf, rel=1e-3 if vary == "force" else 1e-4)
    value = hopf + part * reach
    ((a,),), (stable,) = curve.at(value)
    assert stable == ((part < 0.0) == (vary == "frequency_A"))
    factor, Omega = (1.0, value) if vary == "frequency_A" else (value, frequency)
    growth = curve.growth[np.abs(curve.parameter - value).argmin()]
    away = end_of_run(structure, model, {dof: factor * size}, Omega, a, growth)
    assert away <= KEPT if stable else away >= LEFT
