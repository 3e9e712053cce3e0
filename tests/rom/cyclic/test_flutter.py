"""Waves that aerodynamic forces excite: growth, limit cycles, stability, beside forced waves."""

from functools import cache

import numpy as np
import pytest
from cyclic.ring import (
    AIR_FREQUENCY,
    SHROUD,
    around,
    carriers,
    fluttering_disk,
    growth,
    in_time,
    in_wave,
    ring,
)
from oracles.time_integration import state_matrix

from slipmode import rom

LAW = rom.Jenkins(1.0, 5e4)


@pytest.mark.oracle
def test_growth_rates_are_the_eigenvalues_of_all_sectors():
    fluttering, air = fluttering_disk(7)
    poles = np.linalg.eigvals(state_matrix(ring(7, LAW, 2e-6, air=air)))
    families = [rom.flutter_growth(fluttering, LAW, mode) for mode in range(3)]
    found = np.concatenate([each.growth + 1j * each.frequency for each in families])
    apart = np.abs(found[:, np.newaxis] - poles[poles.imag > 0.0]).min(axis=1)
    assert np.all(apart < 1e-9 * np.abs(found))
    assert families[0].unstable == [-3, -2, 3, -1, 2, 0]
    assert not families[1].unstable


@pytest.mark.oracle
def test_stuck_waves_have_the_coupling_between_families():
    fluttering, air = fluttering_disk(7)
    system, force = ring(7, LAW, 2e-6, air=air), np.array([0.0, 1e-6, 3e-6])
    wave = rom.travelling_wave(fluttering, LAW, -2, mode=1)
    omega = 1.01 * wave.frequency
    (state,) = wave.steady_states(omega, force)
    dynamic = system.stuck() - omega**2 * system.M + 1j * omega * system.C
    expected = np.linalg.solve(dynamic, 0.5 * around(force, -2, 7))
    np.testing.assert_allclose(around(state.displacement, -2, 7), expected, rtol=1e-8)


@pytest.mark.oracle
@pytest.mark.parametrize("sectors", [6, 7])
def test_coefficients_of_nodal_diameters_are_those_of_the_distances(sectors):
    rng = np.random.default_rng(2)
    diameters = range(-((sectors - 1) // 2), sectors // 2 + 1)
    c = {k: complex(*rng.standard_normal(2)) for k in diameters}
    influence = rom.influence_coefficients(c, sectors)
    for k, expected in c.items():
        turns = [l_d * np.exp(2j * np.pi * k * d / sectors) for d, l_d in influence.items()]
        assert abs(sum(turns) - expected) < 1e-12


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("own", "stiffness", "k"),
    [
        (-3e3j, 5e4, -1),
        (-3e3j, 5e4, 2),
        pytest.param(-1.2e4j, 2e5, -2, marks=pytest.mark.slow),
    ],
)
def test_limit_cycles_are_those_of_all_sectors(own, stiffness, k):
    fluttering, air = fluttering_disk(6, own)
    law = rom.Jenkins(1.0, stiffness)
    wave = rom.travelling_wave(fluttering, law, k)
    state, unstable = wave.limit_cycles()
    assert abs(state.amplitude) < abs(unstable.amplitude)
    size = abs(state.amplitude)
    (tabulated,) = rom.limit_cycles(wave.tabulate(1.5 * size, None, frequency=state.frequency))
    assert abs(tabulated.amplitude[0] / size - 1.0) < 1e-3  # the tolerance of the table
    system, start = ring(6, law, 2e-6, air=air), 1.02 * around(state.displacement, k, 6)
    found = []
    for steps in (128, 256):
        motion = in_time(system, 200, state.frequency, start=start, steps=steps)
        late = motion.t > 0.8 * motion.t[-1]
        a = in_wave(wave.shape, k, motion.x[late])
        frequency = np.polyfit(motion.t[late], np.unwrap(np.angle(a)), 1)[0]
        found.append((np.abs(a).mean(), frequency))
    (coarse, slow), (amplitude, frequency) = found
    expected = abs(in_wave(wave.shape, k, around(state.displacement, k, 6)))
    own_error = abs(amplitude - coarse) / amplitude + 3e-5  # of the rest of the transient
    assert abs(expected / amplitude - 1.0) < state.error / size + own_error
    assert abs(state.frequency / frequency - 1.0) < abs(slow / frequency - 1.0) + 1e-5


@pytest.mark.oracle
def test_a_wave_with_lift_off_breaks_into_another():
    """The pair grows as all sectors do; the wave loses to the other."""
    law, k, N = rom.FrictionalContact(0.3, 1.0, 2e5, 2e5), 2, 12
    disk = rom.lumped_disk(N, 1e-5, **SHROUD)
    wave, other = (rom.travelling_wave(disk, law, n) for n in (k, -4))
    omega, force = 0.985 * wave.frequency, np.array([0.0, 10.0 / 3.0, 10.0j])
    (state,) = wave.steady_states(omega, force)
    size, pair = abs(state.amplitude), state.critical_pair
    assert not state.stable
    assert pair.nodal_diameters == (-4, -4)
    start = around(state.displacement, k, N) + around(1e-3 * size * other.shape, -4, N)
    system = ring(N, law, contacts=SHROUD)
    motion = in_time(system, 64, omega, around(force, k, N), start)
    turned = motion.x * np.exp(-1j * omega * motion.t)[:, np.newaxis]
    mean = turned.reshape(16, 4 * 32, -1).mean(axis=1)
    found, lost = (
        np.abs(in_wave(each.shape, n, mean)) / size for each, n in ((other, -4), (wave, k))
    )
    rate = growth(8.0 * np.pi / omega * np.arange(2, 8), found[2:8])
    assert abs(pair.growth / rate - 1.0) < 0.02
    assert found[-1] > 0.4
    assert lost[-1] < 0.96


@pytest.mark.oracle
def test_a_limit_cycle_breaks_into_other_nodal_diameters():
    fluttering, air = fluttering_disk(6, -1.2e4j)
    wave, other = (rom.travelling_wave(fluttering, LAW, n) for n in (-1, 1))
    state, _ = wave.limit_cycles()
    assert not state.stable
    assert state.critical_pair.nodal_diameters == (1, 3)
    omega, size = state.frequency, abs(state.amplitude)
    start = around(state.displacement, -1, 6) + around(1e-3 * size * other.shape, 1, 6)
    motion = in_time(ring(6, LAW, 2e-6, air=air), 100, omega, start=start)
    parts = np.array_split(np.arange(motion.t.size), 10)[2:]
    c = np.vstack([carriers(motion.t[i], motion.x[i], [omega * motion.t[i]]) for i in parts])
    rate = growth([motion.t[i].mean() for i in parts], in_wave(other.shape, 1, c))
    assert abs(state.critical_pair.growth / rate - 1.0) < 0.03


@cache
def flutter_beside_a_forced_wave():
    """Both waves, the system, the limit cycle alone, and a table of both up to 3 N."""
    law = rom.Jenkins(1.0, 2e4)
    fluttering, air = fluttering_disk(6, -6e3j)
    flutter, forced = (
        rom.travelling_wave(fluttering, law, k, mode=m) for k, m in ((-1, 0), (2, 1))
    )
    cycle, omega = flutter.limit_cycles()[0], 0.999 * forced.frequency
    ends = (
        1.5 * abs(cycle.amplitude),
        1.2 * abs(forced.steady_states(omega, {2: 3.0})[0].amplitude),
    )
    given = (None, {2: 1.0}), 5e-3, (cycle.frequency, omega)
    model = rom.tabulate_waves((flutter, forced), ends, *given)
    return flutter, forced, ring(6, law, 2e-6, air=air), cycle, omega, model


def beside(force, amplitude, periods):
    """Motion of all sectors under a force wave, from an amplitude of the flutter."""
    flutter, _, system, cycle, omega, _ = flutter_beside_a_forced_wave()
    c = amplitude * around(flutter.shape, -1, 6)
    start = c.real + 1j * cycle.frequency / omega * c.imag  # the velocity at its own frequency
    return in_time(system, periods, omega, around([0.0, 0.0, force], 2, 6), start)


@pytest.mark.slow
@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_a_limit_cycle_beside_an_engine_order():
    flutter, forced, _, alone, omega, model = flutter_beside_a_forced_wave()
    (cycle,) = rom.limit_cycles(model, (None, omega), [{}, {2: 0.5}])
    found = np.abs(cycle.amplitude)
    assert cycle.stable
    assert found[0] < 0.75 * abs(alone.amplitude)
    motion = beside(0.5, found[0], 700)
    late = motion.t > 0.7 * motion.t[-1]
    t, x = motion.t[late], motion.x[late]
    frequency = np.polyfit(t, np.unwrap(np.angle(in_wave(flutter.shape, -1, x))), 1)[0]
    a, b = carriers(t, x, [frequency * t, omega * t])
    expected = np.abs([in_wave(flutter.shape, -1, a), in_wave(forced.shape, 2, b)])
    np.testing.assert_allclose(found, expected, rtol=5e-3)  # the tolerance of the table
    assert abs(cycle.frequency[0] / frequency - 1.0) < 2e-5


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.slow
@pytest.mark.parametrize(("force", "grows"), [(1.6, False), (3.0, True)])
def test_a_forced_wave_beyond_its_slip_threshold(force, grows):
    """It quenches the flutter, and leaves it little friction when it slips further."""
    flutter, forced, _, cycle, omega, model = flutter_beside_a_forced_wave()
    alone = abs(forced.steady_states(omega, {2: force})[0].amplitude)
    if not grows:
        assert rom.limit_cycles(model, (None, omega), [{}, {2: force}]) == ()
        at_rest, found = rom.steady(model, (flutter.frequency, omega), [{}, {2: force}])
        assert at_rest == 0.0
        assert abs(abs(found) / alone - 1.0) < 5e-3
    motion = beside(force, 0.2 * abs(cycle.amplitude), 420)
    late = motion.t > 0.75 * motion.t[-1]
    amplitude = np.abs(in_wave(flutter.shape, -1, motion.x[late]))
    rate = growth(motion.t[late], amplitude)
    (damping, _), _ = rom.decay_rates(model, [amplitude.mean(), alone])
    assert (rate > 0.0) == grows
    # the table is within 5e-3 of 4.1 1/s, the growth without slip, and of the friction against it
    assert abs(rate + damping) < 0.1


def with_air(**changed):
    given = {"directions": [2], "influence": {0: 1.0j}, "frequency": AIR_FREQUENCY} | changed
    return rom.lumped_disk(7).with_aerodynamics(**given)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: with_air(influence={7: 1.0}), "influence: distances must be integers from -6 to"),
        (lambda: with_air(influence={0: np.nan}), "influence: must be a finite number, or 1 x 1"),
        (lambda: with_air(frequency=0.0), "frequency: must be > 0 rad/s, got 0.0"),
        (lambda: with_air().annulus(), "aerodynamics: annulus does not include"),
        (
            lambda: rom.MistunedDisk(with_air(), LAW, np.zeros(7), 1e5),
            "aerodynamics: MistunedDisk does not incl",
        ),
        (
            lambda: rom.travelling_wave(with_air(influence={0: -1e7}), LAW, 1),
            "influence: the stiffness of mode 0",
        ),
        (
            lambda: rom.influence_coefficients({0: 1.0, 7: 1j}, 7),
            "by_diameter: must have each of the 7 nodal",
        ),
    ],
)
def test_aerodynamic_forces_that_do_not_fit_are_refused(call, message):
    with pytest.raises(rom.SlipmodeError, match=message):
        call()
