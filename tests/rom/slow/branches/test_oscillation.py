"""Slow limit cycles: a self-excited mode that its force does not hold beats against it."""

import numpy as np
import pytest

from slipmode import fmu, rom
from slipmode.rom import full

FORCE, SPAN = ({0: 0.04},), (0.95, 1.03)
SAMPLES = 32  # of a period


@pytest.fixture(scope="module")
def curve():
    """With its model. Friction holds the flutter at |a| = 1.1; the force catches it near by."""
    reduced = rom.reduce(rom.two_mass(beta=0.01), modes=(0,), aerodynamics=(-0.015j,))
    model = rom.tabulate(reduced, rom.Coulomb(2.0), (8.0,), 1e-3)
    return model, rom.response_curve(model, (0.98,), FORCE, "frequency_A", SPAN)


def test_what_runs_reach_is_between_them(curve):
    """Runs by the component, from rest, over beats long after they are past their beginning."""
    model, found = curve
    cycles = found.cycles
    assert cycles.parameter.size >= 10
    for k in (2, -3):
        Omega = cycles.parameter[k]
        component = fmu.Component(model, force_patterns=({0: 1.0},))
        component.set_inputs(force_A=0.04, frequency_A=Omega)
        component.do_step(0.0, 3000.0)
        size = []
        for t in np.arange(3000.0, 4000.0, 2.0):
            component.do_step(t, 2.0)
            outputs = component.outputs()
            size.append(np.hypot(outputs["A_re"], outputs["A_im"]))
        assert min(size) == pytest.approx(cycles.lowest[k, 0], rel=0.02)
        assert max(size) == pytest.approx(cycles.highest[k, 0], rel=0.02)
        assert max(size) > 1.3 * min(size)


def test_there_are_none_where_a_steady_state_attracts(curve):
    _, found = curve
    hopf = sorted(point.parameter for point in found.special if point.kind == "Hopf")
    inside = (found.cycles.parameter > 0.995) & (found.cycles.parameter < 1.005)
    assert hopf[0] < 0.995 and hopf[-1] > 1.005 and not inside.any()
    assert found.at(1.0)[1].any()


def test_they_are_in_the_picture(curve):
    ax = pytest.importorskip("matplotlib.figure").Figure().subplots()
    from matplotlib.collections import LineCollection

    _, found = curve
    found.plot(ax, units=rom.Units("Hz"))
    (bars,) = (drawn for drawn in ax.collections if isinstance(drawn, LineCollection))
    drawn = np.array(bars.get_segments())
    assert drawn[:, 0, 0] == pytest.approx(found.cycles.parameter / (2 * np.pi))
    assert drawn[:, 1, 1] == pytest.approx(found.cycles.highest[:, 0])


def test_curves_without_hopf_points_have_none():
    model = rom.tabulate(rom.reduce(rom.two_mass(beta=0.01), (0,)), rom.Coulomb(2.0), (4.0,), 1e-2)
    curve = rom.response_curve(model, (0.98,), ({0: 0.1},), "frequency_A", (0.95, 1.02))
    assert curve.cycles.parameter.size == 0


@pytest.mark.slow
def test_they_are_those_of_full_order(curve):
    """Of a run from rest, by sliding windows of two periods: 0.8 and 0.4 % of the largest.

    Of the least and the largest; but for where a steady state begins to attract.
    """
    model, found = curve
    structure, cycles = rom.two_mass(beta=0.01), found.cycles
    body = full.aeroelastic(structure, model.reduced)
    row = (structure.mass @ model.reduced.mode_shapes).T
    window = np.hanning(2 * SAMPLES + 1)[:-1] / SAMPLES
    off = []
    ends = np.array([point.parameter for point in found.special])
    for k, Omega in enumerate(cycles.parameter):
        if np.abs(ends - Omega).min() < 2e-3:
            continue
        times = np.arange(700 * SAMPLES, 1200 * SAMPLES) * 2.0 * np.pi / (Omega * SAMPLES)
        excitation = full.Excitation.harmonic(body, FORCE, [Omega])
        motion = full.integrate(
            body, model.law, excitation, times, steps_per_period=SAMPLES, outputs=row
        )
        carried = motion.displacement[:, 0] * np.exp(-1j * Omega * motion.time)
        size = np.abs(np.convolve(carried, window, "valid"))
        assert size.min() < 0.7 * size.max()
        off.append([cycles.lowest[k, 0] - size.min(), cycles.highest[k, 0] - size.max()])
        off[-1] = (np.abs(off[-1]) / size.max()).tolist()
    assert len(off) >= 10
    assert np.max(off) <= 1e-2
