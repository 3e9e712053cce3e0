"""Response curves: every steady state, and whether motion near it tends to it."""

import numpy as np
import pytest
from elastic.frictional_beam import LIFT_OFF, TIP
from elastic.frictional_beam import structure as lifting

from slipmode import rom
from slipmode.rom import SlipmodeError, full
from slipmode.rom.slow.branches import continuation

FORCE = ({0: 0.15}, {1: 0.25})
FREQUENCY = (0.98, 1.65)
LOW_FOLD, HIGH_FOLD = 0.89965, 0.98326  # of `opening` under 0.06 N


@pytest.fixture(scope="module")
def both():
    """Both modes of the two masses."""
    return rom.tabulate(rom.reduce(rom.two_mass(beta=0.01)), rom.Coulomb(2.0), (4.0, 2.0), 2e-3)


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


def test_stability_does_not_depend_on_units(both):
    """Limits and forces a ten-millionth of others: so are amplitudes; decay is the same."""
    part = 1e-7
    reduced = both.reduced
    small = rom.tabulate(reduced, rom.Coulomb(2.0 * part), (4.0 * part, 2.0 * part), 2e-3)
    forces = [{dof: part * size for dof, size in force.items()} for force in FORCE]
    curve, scaled = (
        rom.response_curve(model, FREQUENCY, force, "frequency_A", (0.95, 1.02))
        for model, force in ((both, FORCE), (small, forces))
    )
    assert scaled.parameter.size == pytest.approx(curve.parameter.size, rel=0.05)
    growth = np.interp(curve.parameter, scaled.parameter, scaled.growth)
    assert np.abs(growth / curve.growth - 1.0).max() <= 5e-3


@pytest.mark.parametrize(
    ("vary", "span"),
    [
        ("frequency_A", (0.9, 1.05)),
        ("frequency_B", (1.75, 1.55)),
        ("frequency", ((0.95, 1.6), (1.02, 1.72))),
        ("force", (0.0, 1.0)),
        ("force_B", (0.1, 1.2)),
        ("limit", (0.95, 3.0)),
    ],
)
def test_it_is_made_of_steady_states(both, vary, span):
    curve = rom.response_curve(both, FREQUENCY, FORCE, vary, span)
    assert set(np.unique(curve.branch)) == {0}
    assert curve.stable.all()
    assert {curve.parameter[0], curve.parameter[-1]} == set(
        span if vary != "frequency" else (0, 1)
    )
    for value, amplitude in zip(curve.parameter[5::20], curve.amplitude[5::20], strict=True):
        frequency, force, limit = np.array(FREQUENCY), [dict(one) for one in FORCE], 1.0
        if vary == "frequency":
            frequency = span[0] + value * np.subtract(span[1], span[0])
        elif vary.startswith("frequency"):
            frequency["AB".index(vary[-1])] = value
        elif vary == "limit":
            limit = value
        for mode, one in enumerate(force):
            dof, size = next(iter(one.items()))
            varied = vary == "force" or vary == f"force_{'AB'[mode]}"
            one[dof] = size * (value if varied else 1.0) / limit
        expected = limit * rom.steady(both, frequency, force)
        assert amplitude == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("step", [0.05, 0.02, 0.004])
def test_points_are_as_close_as_asked_for(folding, step):
    _, _, model = folding
    given = (model, [1.0], [{0: 0.02}], "frequency_A", (0.9, 1.0))
    curve = rom.response_curve(*given, largest_step=step)
    z = np.column_stack((curve.amplitude[:, 0] / 6.0, (curve.parameter - 0.9) / 0.1))
    distance = np.linalg.norm(np.diff(z, axis=0), axis=1)
    assert distance.max() == pytest.approx(step, rel=0.02)


@pytest.mark.quick
def test_a_contact_that_opens_folds_the_curve(folding):
    _, _, model = folding
    curve = rom.response_curve(model, [1.0], [{0: 0.06}], "frequency_A", (0.75, 1.1))
    kinds = [point.kind for point in curve.special]
    low, high = sorted(point.parameter for point in curve.special)
    assert kinds == ["fold", "fold"]
    assert (low, high) == pytest.approx((LOW_FOLD, HIGH_FOLD), abs=1e-4)
    three = (curve.parameter > low) & (curve.parameter < high)
    assert np.all(curve.stable[~three])
    assert 0 < np.count_nonzero(~curve.stable) < np.count_nonzero(three)
    # between the folds there are three at each frequency, the one in the middle unstable
    for Omega in np.linspace(low, high, 7)[1:-1]:
        states, stable = curve.at(Omega)
        assert stable[np.argsort(np.abs(states[:, 0]))].tolist() == [True, False, True]


def verdicts(structure, law, model, frequency, force):
    """Of each steady state: whether it is said to be stable, whether full order keeps to it."""
    curve = rom.response_curve(model, [frequency], [force], "force", (0.9, 1.1))
    shape = model.reduced.mode_shapes[:, 0]
    found = []
    for a, stable in zip(*curve.at(1.0), strict=True):
        beside = 1.02 * a[0] * shape
        end = full.steady_amplitude(
            structure,
            law,
            full.Excitation.harmonic(structure, [force], [frequency]),
            outputs=(shape @ structure.mass)[np.newaxis],
            tolerance=1e-3,
            start=full.State(0.0, 2.0 * beside.real, -2.0 * frequency * beside.imag),
            most_windows=40,
        ).amplitude[0, 0]
        found.append((bool(stable), bool(abs(end - a[0]) <= 0.05 * abs(a[0]))))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("part", [-0.3, *np.linspace(0.1, 0.9, 9), 1.3])
def test_full_order_tends_to_the_stable_and_leaves_the_unstable_ones(folding, part):
    structure, law, model = folding
    frequency = LOW_FOLD + part * (HIGH_FOLD - LOW_FOLD)
    found = verdicts(structure, law, model, frequency, {0: 0.06})
    expected = [True] if part < 0.0 or part > 1.0 else [False, True, True]
    assert sorted(stable for stable, _ in found) == expected
    assert all(said == kept for said, kept in found)


@pytest.mark.slow
@pytest.mark.parametrize("detuning", [-0.09, -0.07, -0.065, -0.06, -0.055, -0.05])
def test_so_it_does_where_a_beam_lifts_off(detuning):
    """With the forcing at the carrier: over 6 % of the frequency these states would be 5 % off."""
    structure, force = lifting(LIFT_OFF, 8), {TIP: 0.02}
    omega = rom.reduce(structure, (0,), law=LIFT_OFF).frequency[0]
    frequency = (1.0 + detuning) * omega
    reduced = rom.reduce(
        structure, (0,), law=LIFT_OFF, carrier=[frequency], force_patterns=[{TIP: 1.0}]
    )
    model = rom.tabulate(reduced, LIFT_OFF, (0.06,), 1e-3)
    found = verdicts(structure, LIFT_OFF, model, frequency, force)
    assert len(found) == (1 if detuning < -0.08 else 3)
    assert all(said == kept for said, kept in found)


def test_it_ends_where_the_table_does(both):
    curve = rom.response_curve(both, FREQUENCY, FORCE, "force", (0.0, 3.0))
    assert 1.0 < curve.parameter.max() < 3.0
    at_end = np.abs(curve.amplitude[np.argmax(curve.parameter)]) / both.table.amplitude_range
    assert at_end.max() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("vary", {"vary": "frequency_C"}),
        ("span", {"span": (1.0, 1.0)}),
        ("span", {"span": (0.9, np.nan)}),
        ("span", {"vary": "frequency", "span": (0.9, 1.0)}),
        ("span", {"vary": "force", "span": (-1.0, 1.0)}),
        ("vary", {"vary": "limit", "span": (0.0, 1.0)}),
        ("frequency", {"frequency": [1.0]}),
        ("frequency", {"span": (0.1, 1.0)}),
        ("force", {"force": [{0: 0.1}]}),
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


def test_frequencies_that_cross_between_two_points_are_refused(both):
    with pytest.raises(SlipmodeError, match="must differ all along"):
        rom.response_curve(both, FREQUENCY, FORCE, "frequency_A", (0.9, 1.7003))


def test_it_is_drawn(both, tmp_path):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    ax = figure.subplots()
    curve = rom.response_curve(both, FREQUENCY, FORCE, "frequency_A", (0.9, 1.05))
    assert curve.plot(ax) is ax
    drawn = max(line.get_ydata().max(initial=0.0) for line in ax.lines if line.get_xdata().size)
    assert drawn == np.abs(curve.amplitude).max()


@pytest.mark.parametrize("span", [(0.9, 1.05), (1.05, 0.9)])
def test_states_at_both_ends_of_the_span_are_found(both, span):
    curve = rom.response_curve(both, FREQUENCY, FORCE, "frequency_A", span)
    for end in (0, -1):
        a, stable = curve.at(curve.parameter[end])
        assert np.array_equal(a, curve.amplitude[[end]])
        assert stable.tolist() == [True]
    assert len(curve.at(curve.parameter[5])[0]) == 1


def test_a_branch_with_too_many_points_is_said_to_go_on(both, monkeypatch):
    monkeypatch.setattr(continuation, "MOST_POINTS", 10)
    with pytest.warns(rom.ValidityWarning, match=r"^curve is incomplete beyond frequency_A = 0\."):
        curve = rom.response_curve(both, FREQUENCY, FORCE, "frequency_A", (0.9, 1.05))
    ends = np.array([curve.parameter.min(), curve.parameter.max()])
    assert curve.cut_off.size >= 1
    assert np.all((curve.cut_off >= ends[0]) & (curve.cut_off <= ends[1]))
    monkeypatch.undo()
    whole = rom.response_curve(both, FREQUENCY, FORCE, "frequency_A", (0.9, 1.05))
    assert whole.cut_off.size == 0


@pytest.mark.slow
def test_the_table_makes_no_oscillations():
    """Where a contact begins to slip, narrow cells damped one mode negatively over 1e-5 of it."""
    reduced = rom.reduce(rom.two_mass(beta=0.002), (0,))
    model = rom.tabulate(reduced, rom.Coulomb(2.0), (12.0,), warned=False)
    for force in (0.02, 0.04, 0.06, 0.08):
        curve = rom.response_curve(model, (0.98,), ({0: force},), "frequency_A", (0.9, 1.05))
        assert not curve.special
        assert curve.stable.all()
