"""Performance curves: the peak of a response curve for each friction limit."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import SlipmodeError

FORCE = {0: 0.15}


@pytest.fixture(scope="module")
def model():
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,))
    return rom.tabulate(reduced, rom.Coulomb(2.0), (12.0,), 1e-3)


def test_each_point_is_the_peak_of_a_response_curve(model):
    curve = rom.performance_curve(model, FORCE)
    for limit in (0.6, 1.0, 2.0):
        peaks = rom.response_curve(
            model, [1.0], [{0: 0.15 / limit}], "frequency_A", (0.9, 1.05)
        ).amplitude
        expected = limit * np.abs(peaks).max()
        found = np.interp(limit, curve.limit, curve.peak)
        assert found == pytest.approx(expected, rel=3e-3)


def test_contacts_that_stick_leave_the_peak_to_structural_damping(model):
    curve = rom.performance_curve(model, FORCE)
    F = abs(model.reduced.modal_force(0, FORCE))
    assert curve.peak[-1] == pytest.approx(F / (4.0 * 0.005), rel=1e-3)
    assert curve.limit[-1] > 10.0


@pytest.mark.quick
def test_between_slip_and_stick_there_is_a_best_limit(model):
    curve = rom.performance_curve(model, FORCE)
    limit, peak = curve.optimum
    assert peak < 0.65 * min(curve.peak[0], curve.peak[-1])
    low, high = curve.within(1.1)
    assert low < limit < high
    inside = (curve.limit >= low) & (curve.limit <= high)
    assert np.all(curve.peak[inside] <= 1.1 * peak)
    assert np.all(curve.peak[~inside] > 1.1 * peak)
    twice = rom.performance_curve(model, {0: 0.3})
    assert twice.optimum == pytest.approx((2.0 * limit, 2.0 * peak))
    assert twice.displacement(0) == pytest.approx(2.0 * curve.displacement(0))


def test_the_end_of_a_curve_that_still_falls_is_no_optimum(model):
    """At the best limit |a| is 1.97 kg^1/2 m in the table."""
    short = rom.tabulate(model.reduced, model.law, (1.6,), 1e-3)
    with pytest.warns(rom.ValidityWarning, match="peak still falls at limit = .* larger range"):
        cut = rom.performance_curve(short, FORCE)
    assert cut.is_cut_at_lowest()
    assert cut.optimum[0] > 1.1 * rom.performance_curve(model, FORCE).optimum[0]
    assert not rom.performance_curve(model, FORCE).is_cut_at_lowest()


def test_the_optimum_is_drawn(model):
    ax = pytest.importorskip("matplotlib.figure").Figure().subplots()
    curve = rom.performance_curve(model, FORCE)
    curve.plot(ax)
    assert (ax.lines[1].get_xdata()[0], ax.lines[1].get_ydata()[0]) == curve.optimum


def test_where_nothing_slips_no_limit_is_best():
    """Contacts of the two masses slip from |a| = 1 on."""
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,))
    stuck = rom.tabulate(reduced, rom.Coulomb(2.0), (0.9,), 1e-2)
    with pytest.raises(SlipmodeError, match=r"^amplitude: up to 0\.898 .* hardly slip") as said:
        rom.performance_curve(stuck, FORCE)
    assert str(said.value).endswith("the first contact slips at 1; tabulate to 4 or more")
    model = rom.tabulate(reduced, rom.Coulomb(2.0), (4.0,), 1e-2)
    curve = rom.performance_curve(model, FORCE)
    assert curve.limit.min() < curve.optimum[0] < curve.limit.max()


@pytest.mark.parametrize("dof", [1, 3])
def test_a_force_that_mainly_acts_on_the_contacts_is_refused(dof):
    force = {0: 0.15, dof: 15.0}
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,), force_patterns=[force])
    model = rom.tabulate(reduced, rom.Coulomb(2.0), (12.0,), 1e-2)
    message = r"^amplitude: the frequency .* does not converge .* on the contacts"
    with pytest.raises(SlipmodeError, match=message):
        rom.performance_curve(model, force)


def test_what_has_no_such_curve_is_named(model):
    smooth = rom.tabulate(model.reduced, rom.Tanh(2.0, 0.02), (4.0,), 1e-2)
    with pytest.raises(SlipmodeError, match="law: the motion must scale"):
        rom.performance_curve(smooth, FORCE)
    with pytest.raises(SlipmodeError, match="mode: must be 0 to 0, got 1"):
        rom.performance_curve(model, FORCE, mode=1)
    with pytest.raises(SlipmodeError, match="force: does not excite mode A"):
        rom.performance_curve(model, {0: 0.0})
