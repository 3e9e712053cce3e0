"""Limit cycles of self-excited modes beside full order, and what is refused."""

import numpy as np
import pytest
from cycles import settled
from elastic.cantilever import LAWS, cantilever

from slipmode import fmu, rom
from slipmode.rom import full
from slipmode.rom.slow.slow_flow import ForcedFlow

BOUND = 2e-3  # of the amplitude; asked for: 5e-3
FREQUENCY_BOUND = 1e-4
STRUCTURE = rom.two_mass(beta=0.01)


def model(law=None, aerodynamics=(-0.02j,), reach=(6.0,), tolerance=1e-3, **given):
    law = law or rom.Coulomb(2.0)
    reduced = rom.reduce(STRUCTURE, range(len(reach)), aerodynamics=aerodynamics, **given)
    return rom.tabulate(reduced, law, reach, tolerance, combinations=())


def assert_full_order_agrees(structure, of, cycle, force=None, periods=400):
    amplitude, frequency = settled(structure, of.law, of.reduced, cycle, force, periods=periods)
    np.testing.assert_allclose(np.abs(amplitude), np.abs(cycle.amplitude), rtol=BOUND)
    np.testing.assert_allclose(frequency, cycle.frequency, rtol=FREQUENCY_BOUND)


@pytest.mark.parametrize("law", [rom.Coulomb(2.0), rom.Tanh(2.0, 0.02)], ids=["coulomb", "tanh"])
@pytest.mark.parametrize("coefficient", [-0.02j, 0.05 - 0.024j])
def test_amplitude_and_frequency_are_those_of_full_order(law, coefficient):
    of = model(
        law, (coefficient,), tolerance=1e-4
    )  # 0.1 % of friction may be 1 % of the amplitude
    stable, unstable = rom.limit_cycles(of)
    assert stable.stable and not unstable.stable
    assert_full_order_agrees(STRUCTURE, of, stable, periods=3000)


def test_full_order_leaves_the_unstable_one_to_either_side():
    of = model()
    stable, unstable = rom.limit_cycles(of)
    between = 0.5 * (np.abs(stable.amplitude) + np.abs(unstable.amplitude))
    for off, grows in ((0.93, False), (1.07, True)):
        amplitude, _ = settled(
            STRUCTURE, of.law, of.reduced, unstable, periods=60, steps=32, off=off
        )
        assert (np.abs(amplitude) > np.abs(unstable.amplitude)) == grows
        assert np.all(np.abs(amplitude) > between)  # it has not settled yet


def test_of_elastic_contacts():
    law = LAWS["Jenkins"]
    structure = cantilever(law)
    coefficient = -0.05j * rom.reduce(structure, (0,), law=law).frequency[0] ** 2
    reduced = rom.reduce(structure, (0,), law=law, aerodynamics=(coefficient,))
    of = rom.tabulate(reduced, law, (0.02,))
    (cycle,) = rom.limit_cycles(of)
    assert cycle.stable
    assert cycle.frequency < 0.98 * reduced.frequency  # its contacts slip
    assert_full_order_agrees(structure, of, cycle, periods=200)


@pytest.mark.slow
def test_beside_a_forced_mode():
    """A forced near resonance; B excites itself, and has three times the error of the others."""
    force, frequency = ({0: 0.15}, {}), (0.98, 1.7)
    of = model(aerodynamics=(0.0, -0.1j), reach=(4.0, 2.0), carrier=frequency)
    stable, unstable = rom.limit_cycles(of, frequency, force)
    assert stable.stable and not unstable.stable
    assert stable.frequency[0] == 0.98 and stable.frequency[1] < 0.995 * 1.7
    amplitude, own = settled(STRUCTURE, of.law, of.reduced, stable, force, periods=600)
    np.testing.assert_allclose(np.abs(amplitude), np.abs(stable.amplitude), rtol=4e-3)
    np.testing.assert_allclose(own, stable.frequency, rtol=FREQUENCY_BOUND)


@pytest.fixture(scope="module")
def two_modes():
    """Coarse: for what holds on any table."""
    reduced = rom.reduce(STRUCTURE, aerodynamics=(-0.024j, -0.12j))
    return rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), 0.02, combinations=())


def test_two_self_excited_modes_settle_together(two_modes):
    """Where each alone would settle the other grows, or friction lets both go."""
    found = rom.limit_cycles(two_modes)
    moving = [tuple(cycle.amplitude != 0.0) for cycle in found]
    assert {moving.count(some) for some in ((True, False), (False, True))} == {2}
    (settled_to,) = (cycle for cycle in found if cycle.stable)
    assert np.all(settled_to.amplitude.real > 0.0)
    now = stepped(two_modes, settled_to, 0.99, 20000.0)
    np.testing.assert_allclose(np.abs(now), np.abs(settled_to.amplitude), rtol=1e-4)


def stepped(of, cycle, off, duration, **inputs):
    """Amplitudes of a component that starts beside a limit cycle, at its frequencies."""
    slow = fmu.Component(of, ({0: 1.0}, {1: 1.0}), warned=False)
    slow.set_inputs(frequency_A=cycle.frequency[0], frequency_B=cycle.frequency[1], **inputs)
    slow.reset(amplitude=off * cycle.amplitude)
    slow.do_step(0.0, duration)
    now = slow.outputs()
    return np.array([now["A_re"] + 1j * now["A_im"], now["B_re"] + 1j * now["B_im"]])


@pytest.fixture(scope="module")
def forced_beside():
    reduced = rom.reduce(rom.two_mass(), aerodynamics=(-0.02j, 0.0), carrier=(0.98, 1.65))
    return rom.tabulate(reduced, rom.Coulomb(2.0), (12.0, 4.0), 1e-2)


def test_a_forced_mode_that_leaves_the_table_is_refused_or_reported(forced_beside):
    """B reaches the end of the table at a force of 0.56, if A is small; at 0.575 in all cases."""
    arguments = forced_beside, (None, 1.65)
    with pytest.raises(rom.SlipmodeError, match=r"^force: forced modes do not become steady"):
        rom.limit_cycles(*arguments, ({}, {1: 0.6}))
    with pytest.warns(rom.ValidityWarning, match=r"limit cycles may be missing: .* 0\.629 kg"):
        (cycle,) = rom.limit_cycles(*arguments, ({}, {1: 0.55}))
    assert not cycle.stable


def test_the_slow_flow_settles_beside_a_forced_mode():
    force, frequency = ({0: 0.1}, {}), (0.985, None)
    reduced = rom.reduce(STRUCTURE, carrier=(0.985, 1.69), aerodynamics=(0.0, -0.1j))
    of = rom.tabulate(reduced, rom.Tanh(2.0, 0.02), (4.0, 2.0), 0.02, combinations=())
    stable, unstable = rom.limit_cycles(of, frequency, force)
    assert stable.stable and not unstable.stable
    now = stepped(of, stable, 0.99, 8000.0, force_A=0.1)
    np.testing.assert_allclose(np.abs(now), np.abs(stable.amplitude), rtol=1e-5)
    assert now[0] == pytest.approx(stable.amplitude[0], rel=1e-5)  # in phase with its force


@pytest.mark.parametrize("law", [rom.Coulomb(2.0), rom.Tanh(2.0, 0.02)], ids=["coulomb", "tanh"])
def test_what_aerodynamics_put_in_leaves_by_friction_and_dampers(law):
    """Of what leaves at the contacts dampers have a share: friction takes what it does in full."""
    of = model(law, (0.05 - 0.024j,), (2.0,))
    (cycle,) = rom.limit_cycles(of)
    slow = fmu.Component(of, warned=False)
    slow.set_inputs(frequency_A=cycle.frequency[0])
    slow.reset(amplitude=0.95 * cycle.amplitude)
    slow.do_step(0.0, 40.0 / abs(cycle.growth))
    now = slow.outputs()
    a = np.array([now["A_re"] + 1j * now["A_im"]])
    assert np.abs(a) == pytest.approx(np.abs(cycle.amplitude), rel=1e-6)
    assert now["input_power"] == 0.0
    put_in = -2.0 * of.reduced.aerodynamic_damping @ np.square(cycle.frequency * np.abs(a))
    kept = 2.0 * (of.reduced.modal_damping - of.reduced.aerodynamic_damping)
    dampers = kept @ np.square(cycle.frequency * np.abs(a))
    flow = ForcedFlow.of(of, cycle.frequency[np.newaxis])
    force = flow.balance(a[np.newaxis]).friction[0]
    contacts = -2.0 * np.sum(cycle.frequency * np.imag(a.conj() * force))
    assert put_in == pytest.approx(dampers + contacts, rel=1e-6)
    body = full.aeroelastic(STRUCTURE, of.reduced)
    period = 2.0 * np.pi / cycle.frequency[0]
    excitation = full.Excitation.harmonic(body, [{}], cycle.frequency)
    shape = of.reduced.mode_shapes[:, 0] * 2.0 * cycle.amplitude.real
    start = full.State(0.0, shape, 0.0 * shape)
    times = period * np.array([399.0, 400.0])
    end = full.integrate(body, law, excitation, times, steps_per_period=256, start=start)
    power = np.diff(end.dissipated)[0] / period
    assert now["dissipated_power"] == pytest.approx(power, rel=2e-3)


def test_without_a_self_excited_mode_there_is_none():
    with pytest.raises(rom.SlipmodeError, match=r"^force: no unforced mode is self-excited"):
        rom.limit_cycles(model(aerodynamics=(-0.005j,)))
    with pytest.raises(rom.SlipmodeError, match=r"^force: no unforced mode is self-excited"):
        rom.limit_cycles(model(), (0.98,), ({0: 0.1},))


def test_none_within_the_table_is_no_error():
    assert rom.limit_cycles(model(aerodynamics=(-0.04j,))) == ()


@pytest.mark.parametrize("frequency", [None, (1.0, 2.0), (np.nan,)])
def test_frequencies_that_are_missing_are_refused(frequency, two_modes):
    with pytest.raises(rom.SlipmodeError, match=r"^frequency: must be 2 numbers"):
        rom.limit_cycles(two_modes, frequency and (*frequency, 1.0), ({0: 0.1}, {}))


def test_a_steady_state_that_is_none_is_refused():
    of = model()
    with pytest.raises(rom.SlipmodeError, match=r"^aerodynamics: .* self-excited and not forced"):
        rom.steady(of, (0.98,), ({},))
    with pytest.raises(rom.SlipmodeError, match=r"and mode A is self-excited"):
        rom.steady(of, (0.98,), ({0: 0.05},))
    with pytest.raises(rom.SlipmodeError, match=r"^amplitude: self-excited mode A leaves"):
        rom.steady(of, (0.98,), ({0: 0.15},))


def test_a_steady_state_that_is_not_found_names_the_aerodynamics():
    law = rom.Jenkins(2.0, 50.0)
    reduced = rom.reduce(rom.two_mass(beta=0.01), law=law, aerodynamics=(0.0, -0.1j))
    with pytest.raises(rom.SlipmodeError, match=r"^aerodynamics: mode B is self-excited"):
        rom.steady_state(reduced, law, (0.98, 1.65), ({0: 0.15}, {1: 0.25}))


def test_a_steady_state_in_which_a_force_holds_a_self_excited_mode_is_that_of_a_table():
    law, frequency, force = rom.Jenkins(2.0, 50.0), (0.96,), ({0: 0.3},)
    reduced = rom.reduce(
        rom.two_mass(beta=0.01), (0,), law=law, carrier=frequency, aerodynamics=(-0.012j,)
    )
    assert reduced.modal_damping[0] < 0.0
    state = rom.steady_state(reduced, law, frequency, force)
    looked_up = rom.steady(rom.tabulate(reduced, law, (5.0,), 1e-3), frequency, force)
    assert state.amplitude == pytest.approx(looked_up, rel=2e-3)


def test_a_force_at_its_own_frequency_holds_a_self_excited_mode():
    of = model()
    stable, _ = rom.limit_cycles(of)
    (held,) = rom.steady(of, stable.frequency, ({0: 0.002},))
    assert np.abs(held) == pytest.approx(np.abs(stable.amplitude[0]), rel=0.05)
    assert np.abs(held) > np.abs(stable.amplitude[0])
