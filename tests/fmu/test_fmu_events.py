"""Model Exchange: what discontinuities of the forces do to the states; moving inputs, angles."""

import fmpy
import numpy as np
import pytest
from fmu_exchange import STATES, Master
from fmu_fixtures import START, VERSIONS, component, instance

AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")
TOLERANCE = 1e-9
RATES = {"frequency_rate_A": -6e-4, "force_rate_B": 2e-3, "phase_rate_A": 3e-3}
TURN = 2 * np.pi
FMI_ERRORS = fmpy.fmi1.FMICallException
CHANGE_AT, END = 40.5, 70.5
CHANGE = {"force_A": 0.3, "phase_B": 1.2, "frequency_B": 1.66}


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def by_component(model, *pieces):
    """Amplitudes after pieces of (end, inputs that hold until then)."""
    stepped = component(model, tolerance=TOLERANCE)
    for end, inputs in pieces:
        stepped.set_inputs(**inputs)
        stepped.do_step(stepped.time, end - stepped.time)
    out = stepped.outputs()
    return np.array([out[name] for name in AMPLITUDES])


def test_a_discontinuity_is_that_of_co_simulation(unzipped, fmi, two_mode_model):
    """Of forces, phases and frequencies at once."""
    expected = by_component(two_mode_model, (CHANGE_AT, {}), (END, CHANGE))
    with instance(unzipped[fmi], fmi) as slave:
        slave.start(tolerance=TOLERANCE).step(0.0, CHANGE_AT)
        slave.set(**CHANGE)
        slave.step(CHANGE_AT, END - CHANGE_AT)
        np.testing.assert_array_equal(slave.get(*AMPLITUDES), expected)
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        master = Master(made).start()
        master.integrate_to(CHANGE_AT)
        before = master.states()
        assert master.event(**CHANGE)
        moved = master.states() - before
        assert np.abs(moved[:4]).min() > 1e-3  # measured 0.0019 to 0.032
        assert not moved[4:].any()
        master.integrate_to(END)
        np.testing.assert_allclose(made.get(*AMPLITUDES), expected, rtol=0, atol=1e-7)  # 5.0e-8


def test_what_changes_between_events_is_no_discontinuity(unzipped, fmi):
    """An importer may set inputs at any time; the event that comes after holds them."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        master = Master(made).start()
        master.integrate_to(10.0)
        states = master.states()
        made.set(force_A=0.4, phase_B=1.0)
        np.testing.assert_array_equal(master.states(), states)
        assert not master.event()
        assert not master.event(force_A=0.4, frequency_B=1.7)
        np.testing.assert_array_equal(master.states(), states)


def test_the_initial_event_has_no_discontinuity(unzipped, fmi):
    """Whatever acts first did before, as in Co-Simulation."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        made.start(A_re=0.3)
        made.set(force_A=0.4)
        assert not Master(made).update()
        assert made.get(*AMPLITUDES).tolist() == [0.3, 0.0, 0.0, 0.0]


def test_each_iteration_of_an_event_starts_from_the_one_before(unzipped, fmi):
    """There and back, and past a second call to enter the mode."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        master = Master(made).start()
        master.integrate_to(10.0)
        states = master.states()
        made.fmu.enterEventMode()
        made.set(force_A=0.4)
        made.fmu.enterEventMode()
        assert master.update()
        assert not master.update()
        assert np.abs(master.states() - states).max() > 0.02  # measured 0.0217
        made.set(force_A=START["force_A"])
        assert master.update()
        np.testing.assert_allclose(master.states(), states, rtol=0, atol=1e-15)


def test_a_state_saved_within_an_event_knows_what_was_held(unzipped, fmi):
    with (
        instance(unzipped[fmi], fmi, exchange=True) as made,
        instance(unzipped[fmi], fmi, exchange=True) as twin,
    ):
        master = Master(made).start()
        master.integrate_to(10.0)
        made.fmu.enterEventMode()
        made.set(force_A=0.4)
        saved = made.serialize()
        twin.restore(saved)
        assert twin.serialize() == saved
        assert master.update()
        assert Master(twin).update()
        np.testing.assert_array_equal(made.get(*STATES), twin.get(*STATES))
        assert made.serialize() == twin.serialize()


def test_a_discontinuity_beyond_all_numbers_is_refused(unzipped, fmi):
    """The states are as before it, and the importer may take it back."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        master = Master(made).start(A_re=0.1)
        states = master.states()
        made.set(force_A=1.7e308)
        made.fmu.enterEventMode()
        made.set(force_A=-1.7e308)
        with pytest.raises(FMI_ERRORS):
            master.update()
        assert "the discontinuity of a force is too large" in made.messages[-1][1]
        made.set(force_A=1.7e308)
        assert not master.update()
        made.set(force_A=START["force_A"])
        made.fmu.enterContinuousTimeMode()
        np.testing.assert_array_equal(master.states(), states)


def test_reset_forgets_what_was_held(unzipped, fmi):
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        Master(made).start().event(force_A=0.4)
        made.fmu.enterEventMode()
        made.fmu.reset()
        assert not Master(made).start(force_A=0.7).event()


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_fmpy_steps_an_input_as_the_component_does(fmus, fmi, kind, two_mode_model):
    """Two samples of an input at one time are an event to FMPy: left value, then the right one."""
    before = START | {"phase_B": 0.0}
    points = (
        (0.0, before),
        (CHANGE_AT, before),
        (CHANGE_AT, before | CHANGE),
        (END, before | CHANGE),
    )
    rows = [(time, *inputs.values()) for time, inputs in points]
    result = fmpy.simulate_fmu(
        fmus[fmi],
        fmi_type=kind,
        stop_time=END,
        output_interval=0.5,
        relative_tolerance=TOLERANCE,
        input=np.array(rows, dtype=[(name, float) for name in ("time", *before)]),
        output=AMPLITUDES,
    )
    expected = by_component(two_mode_model, (CHANGE_AT, {}), (END, CHANGE))
    last = [result[name][-1] for name in AMPLITUDES]
    np.testing.assert_allclose(last, expected, rtol=0, atol=3e-7)  # measured 7.7e-8


def test_a_sweep_by_rates_alone_is_that_of_co_simulation(unzipped, fmi):
    with (
        instance(unzipped[fmi], fmi) as slave,
        instance(unzipped[fmi], fmi, exchange=True) as made,
    ):
        slave.start(tolerance=1e-9, **RATES).step(0.0, 40.0)
        slave.set(phase_rate_A=-1e-3)
        slave.step(40.0, 20.0)
        master = Master(made).start(**RATES)
        before = master.states()
        master.integrate_to(40.0)
        made.set(phase_rate_A=-1e-3)
        master.integrate_to(60.0)
        moved = ("frequency_A", "force_B", "phase_A")
        np.testing.assert_allclose(made.get(*moved), slave.get(*moved), rtol=1e-13)
        assert made.get("frequency_A")[0] == pytest.approx(START["frequency_A"] - 0.036)
        assert np.abs(master.states() - before).min() > 1e-3
        np.testing.assert_allclose(master.states(), slave.get(*STATES), rtol=0, atol=2e-7)


def test_inputs_move_from_where_and_when_they_were_set(unzipped, fmi):
    """Back in time too, as integrators go."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        made.start(time=5.0, force_A=0.1, force_rate_A=0.01)
        Master(made).update()
        made.fmu.enterContinuousTimeMode()
        made.fmu.setTime(7.0)
        assert made.get("force_A")[0] == pytest.approx(0.12, rel=1e-14)
        made.fmu.setTime(5.5)
        assert made.get("force_A")[0] == pytest.approx(0.105, rel=1e-14)
        saved = made.serialize()
        made.fmu.setTime(9.0)
        made.set(force_A=0.2)
        made.fmu.setTime(11.0)
        assert made.get("force_A")[0] == pytest.approx(0.22, rel=1e-14)
        made.set(force_rate_A=0.0)
        made.fmu.setTime(13.0)
        assert made.get("force_A")[0] == pytest.approx(0.22, rel=1e-14)
        made.restore(saved)
        made.fmu.setTime(6.0)
        assert made.get("force_A")[0] == pytest.approx(0.11, rel=1e-14)


@pytest.mark.parametrize("exchange", [False, True])
def test_carrier_angles_are_read_within_one_turn(unzipped, fmi, exchange):
    with instance(unzipped[fmi], fmi, exchange=exchange) as made:
        if exchange:
            Master(made).start().integrate_to(50.0)
        else:
            made.start().step(0.0, 50.0)
        turned = 50.0 * np.array([START["frequency_A"], START["frequency_B"]])
        assert turned.min() > 7 * TURN
        np.testing.assert_allclose(made.get("theta_A", "theta_B"), turned % TURN, atol=1e-9)
