"""Response curves: every steady state, and whether motion near it tends to it."""

import numpy as np
import pytest
from beside_oracle import amplitudes, demodulated, run, system_of

from slipmode import rom
from slipmode.rom import SlipmodeError

FORCE = ({0: 0.15}, {1: 0.25})
FREQUENCY = (0.98, 1.65)


@pytest.fixture(scope="module")
def both():
    """Both modes of the two masses."""
    reduced = rom.reduce(rom.two_mass(beta=0.01))
    return rom.tabulate(reduced, rom.Coulomb(2.0), (4.0, 2.0), 4e-3, combinations=())


def opening():
    """Two coupled masses, one on a contact that opens: it is soft at large amplitudes."""
    M, K = np.eye(3), np.diag([0.5, 0.5, 3.0])
    K[0, 2] = K[2, 0] = -0.1
    W = np.zeros((3, 2))
    W[1, 0] = W[0, 1] = 1.0
    structure = rom.Structure(M, K, 0.01 * np.eye(3), contact=W)
    law = rom.FrictionalContact(0.3, 1.0, 5.0, 0.5)
    return structure, law


@pytest.fixture(scope="module")
def folding():
    structure, law = opening()
    reduced = rom.reduce(structure, (0,), carrier=(0.94,), law=law)
    model = rom.tabulate(reduced, law, (6.0,), 1e-3, detuning=True)
    return structure, law, model


# The span, and at a value: frequencies, factors on the forces, factor on limits and amplitudes
VARIED = {
    "frequency_A": ((0.9, 1.05), lambda v: ((v, 1.65), (1.0, 1.0), 1.0)),
    "frequency_B": ((1.75, 1.55), lambda v: ((0.98, v), (1.0, 1.0), 1.0)),
    "frequency": (
        ((0.95, 1.6), (1.02, 1.72)),
        lambda v: ((0.95 + 0.07 * v, 1.6 + 0.12 * v), (1.0, 1.0), 1.0),
    ),
    "force": ((0.0, 1.0), lambda v: (FREQUENCY, (v, v), 1.0)),
    "force_B": ((0.1, 1.2), lambda v: (FREQUENCY, (1.0, v), 1.0)),
    "limit": ((0.95, 3.0), lambda v: (FREQUENCY, (1.0 / v, 1.0 / v), v)),
}


@pytest.mark.parametrize("vary", VARIED)
def test_it_is_made_of_steady_states(both, vary):
    span, at = VARIED[vary]
    curve = rom.response_curve(both, FREQUENCY, FORCE, vary, span)
    assert not curve.branch.any() and curve.stable.all()
    ends = (0, 1) if vary == "frequency" else span
    assert {curve.parameter[0], curve.parameter[-1]} == set(ends)
    for value, found in zip(curve.parameter[5::20], curve.amplitude[5::20], strict=True):
        frequency, (A, B), limit = at(value)
        expected = limit * rom.steady(both, frequency, ({0: 0.15 * A}, {1: 0.25 * B}))
        assert found == pytest.approx(expected, abs=1e-8)


@pytest.mark.quick
@pytest.mark.oracle
def test_between_the_folds_of_a_contact_that_opens_integration_finds_the_stable_states(folding):
    """Three states at a frequency; runs from beside the one in the middle leave it."""
    structure, law, model = folding
    curve = rom.response_curve(model, [1.0], [{0: 0.06}], "frequency_A", (0.75, 1.1))
    assert [point.kind for point in curve.special] == ["fold", "fold"]
    low, high = sorted(point.parameter for point in curve.special)
    three = (curve.parameter > low) & (curve.parameter < high)
    assert np.all(curve.stable[~three])
    assert 0 < np.count_nonzero(~curve.stable) < np.count_nonzero(three)
    Omega = 0.5 * (low + high)
    states, stable = curve.at(Omega)
    order = np.argsort(np.abs(states[:, 0]))
    assert stable[order].tolist() == [True, False, True]
    system, shape = system_of(structure, law), model.reduced.mode_shapes[:, 0]
    for a, keeps in zip(states[order, 0], stable[order], strict=True):
        end = demodulated(system, shape, Omega, {0: 0.06}, 1.02 * a, 400)[-1]
        assert (abs(end - a) <= 0.05 * abs(a)) == keeps


@pytest.mark.parametrize("Omega", [0.955, 0.96, 0.965])
def test_beside_a_fold_the_steady_state_is_the_end_of_a_run_from_rest(folding, Omega):
    *_, model = folding
    force = 0.145 / abs(model.reduced.mode_shapes[0, 0])
    inputs = {"force_A": force, "frequency_A": Omega}
    end = amplitudes(run(model, ({0: 1.0},), np.array([3000.0]), tolerance=1e-9, **inputs))[-1, :1]
    assert rom.steady(model, [Omega], [{0: force}]) == pytest.approx(end, rel=1e-5)


@pytest.mark.oracle
def test_growth_is_the_decay_of_deviations(both):
    """The real part of an eigenvalue, beside the slow flow itself from two distances."""
    curve = rom.response_curve(both, FREQUENCY, FORCE, "frequency_A", (0.97, 0.99))
    k = curve.parameter.size // 2
    Omega = curve.parameter[k], FREQUENCY[1]
    inputs = {"force_A": 0.15, "force_B": 0.25, "frequency_A": Omega[0], "frequency_B": Omega[1]}
    times = np.linspace(0.0, 400.0, 401)[1:]
    start = curve.amplitude[k] * 1.001
    flow = run(both, ({0: 1.0}, {1: 1.0}), times, start=start, tolerance=1e-10, **inputs)
    away = np.linalg.norm(amplitudes(flow) - curve.amplitude[k], axis=1)
    slope = np.polyfit(times[150:], np.log(away[150:]), 1)[0]
    assert slope == pytest.approx(curve.growth[k], rel=0.05)


@pytest.mark.parametrize("vary", ["frequency_A", "frequency"])
def test_a_curve_does_not_depend_on_the_direction_of_its_span(both, vary):
    span = (0.9, 1.05) if vary == "frequency_A" else ((0.95, 1.6), (1.02, 1.72))
    curve, back = (
        rom.response_curve(both, FREQUENCY, FORCE, vary, ends) for ends in (span, span[::-1])
    )
    parameter = 1.0 - back.parameter if vary == "frequency" else back.parameter
    assert parameter[::-1] == pytest.approx(curve.parameter, abs=1e-12)
    assert np.array_equal(back.amplitude[::-1], curve.amplitude)
    for end in (0, -1):
        a, stable = curve.at(curve.parameter[end])
        assert np.array_equal(a, curve.amplitude[[end]]) and stable.tolist() == [True]


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("vary", {"vary": "frequency_C"}),
        ("span", {"span": (1.0, 1.0)}),
        ("span", {"vary": "frequency", "span": (0.9, 1.0)}),
        ("vary", {"vary": "limit", "span": (0.0, 1.0)}),
        ("frequency", {"span": (0.9, 1.7003)}),
        ("largest_step", {"largest_step": 0.2}),
    ],
)
def test_bad_arguments_are_named(both, key, change):
    arguments = {
        "frequency": FREQUENCY,
        "force": FORCE,
        "vary": "frequency_A",
        "span": (0.9, 1.0),
    }
    with pytest.raises(SlipmodeError, match=f"^{key}"):
        rom.response_curve(both, **(arguments | change))
