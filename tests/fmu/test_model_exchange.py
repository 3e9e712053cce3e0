"""Model Exchange: against Co-Simulation, discontinuities of forces, inputs that move."""

import fmpy
import numpy as np
import pytest
from fmu_exchange import AMPLITUDES, STATES, Master
from fmu_fixtures import DISCARD, ERROR, START, component, instance

TOLERANCE = 1e-9
CHANGE_AT, END = 40.5, 70.5
CHANGE = {"force_A": 0.3, "phase_B": 1.2, "frequency_B": 1.66}
RATES = {"frequency_rate_A": -6e-4, "force_rate_B": 2e-3, "phase_rate_A": 3e-3}


@pytest.mark.oracle
def test_states_by_an_integrator_of_high_order_are_those_of_co_simulation(unzipped, fmi):
    """Through a sweep, a ramp and a discontinuity of forces, phases and frequencies.

    The integrator is SciPy's. A jump moves the amplitudes, not the carriers or the energy.
    """
    with (
        instance(unzipped[fmi], fmi) as slave,
        instance(unzipped[fmi], fmi, exchange=True) as made,
    ):
        slave.start(tolerance=TOLERANCE, **RATES).step(0.0, CHANGE_AT)
        master = Master(made).start(**RATES)
        master.integrate_to(CHANGE_AT)
        np.testing.assert_allclose(master.states()[:4], slave.get(*AMPLITUDES), atol=2e-7)
        before = master.states()
        slave.set(**CHANGE)
        assert master.event(**CHANGE)
        moved = master.states() - before
        assert np.abs(moved[:4]).min() > 1e-3 and not moved[4:].any()
        slave.step(CHANGE_AT, END - CHANGE_AT)
        master.integrate_to(END)
        np.testing.assert_allclose(made.get(*STATES), slave.get(*STATES), rtol=0, atol=5e-7)
        inputs = ("frequency_A", "force_B", "phase_A")
        np.testing.assert_allclose(made.get(*inputs), slave.get(*inputs), rtol=1e-13)


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_fmpy_steps_an_input_as_the_component_does(fmus, fmi, kind, two_mode_model):
    """Two samples of an input at one time are an event to FMPy: left value, then the right one."""
    before = START | {"phase_B": 0.0}
    after = before | CHANGE
    rows = [(0.0, before), (CHANGE_AT, before), (CHANGE_AT, after), (END, after)]
    result = fmpy.simulate_fmu(
        fmus[fmi],
        fmi_type=kind,
        stop_time=END,
        output_interval=0.5,
        relative_tolerance=0.1 * TOLERANCE,  # with 1e-9, CVode's own error is up to 2e-4
        input=np.array(
            [(time, *inputs.values()) for time, inputs in rows],
            dtype=[(name, float) for name in ("time", *before)],
        ),
        output=(*AMPLITUDES, "contact_0_x", "contact_0_f"),
    )
    stepped = component(two_mode_model, tolerance=TOLERANCE)
    for end, inputs in ((CHANGE_AT, {}), (END, CHANGE)):
        stepped.set_inputs(**inputs)
        stepped.do_step(stepped.time, end - stepped.time)
    expected = stepped.outputs()
    for name in AMPLITUDES:
        assert result[name][-1] == pytest.approx(expected[name], abs=3e-7)
    for name in ("contact_0_x", "contact_0_f"):  # marched in other steps
        scale = float(np.abs(result[name]).max())
        assert result[name][-1] == pytest.approx(expected[name], abs=0.01 * scale)


def test_what_changes_between_events_or_initially_is_no_discontinuity(unzipped, fmi):
    """An importer may set inputs at any time; the event that comes after holds them."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        made.start(A_re=0.3)
        made.set(force_A=0.2)
        master = Master(made)
        assert not master.update()
        made.fmu.enterContinuousTimeMode()
        assert made.get(*AMPLITUDES).tolist() == [0.3, 0.0, 0.0, 0.0]
        master.integrate_to(10.0)
        states = master.states()
        made.set(force_A=0.4, phase_B=1.0)
        np.testing.assert_array_equal(master.states(), states)
        assert not master.event()
        assert not master.event(force_A=0.4, frequency_B=1.7)
        np.testing.assert_array_equal(master.states(), states)


def test_iterations_of_an_event_go_there_and_back_and_may_be_saved(unzipped, fmi):
    with (
        instance(unzipped[fmi], fmi, exchange=True) as made,
        instance(unzipped[fmi], fmi, exchange=True) as twin,
    ):
        master = Master(made).start()
        master.integrate_to(10.0)
        states = master.states()
        made.fmu.enterEventMode()
        made.set(force_A=0.4)
        made.fmu.enterEventMode()
        twin.restore(made.serialize())
        assert master.update() and Master(twin).update()
        assert made.serialize() == twin.serialize()
        assert not master.update()
        assert np.abs(master.states() - states).max() > 1e-3
        made.set(force_A=START["force_A"])
        assert master.update()
        np.testing.assert_allclose(master.states(), states, rtol=0, atol=1e-15)
        made.fmu.reset()
        assert not Master(made).start(force_A=0.7).event()  # it forgets what was held


@pytest.mark.oracle
def test_inputs_move_at_their_rate_from_where_and_when_they_were_set(unzipped, fmi):
    """Back in time too, as integrators go: value + rate (t - t_set)."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        made.start(time=5.0, force_A=0.1, force_rate_A=0.01)
        Master(made).update()
        made.fmu.enterContinuousTimeMode()

        def force_at(time):
            made.fmu.setTime(time)
            return made.get("force_A")[0]

        assert [force_at(7.0), force_at(5.5)] == pytest.approx([0.12, 0.105], rel=1e-14)
        saved = made.serialize()
        force_at(9.0)
        made.set(force_A=0.2)
        assert force_at(11.0) == pytest.approx(0.22, rel=1e-14)
        made.set(force_rate_A=0.0)
        assert force_at(13.0) == pytest.approx(0.22, rel=1e-14)
        made.restore(saved)
        assert force_at(6.0) == pytest.approx(0.11, rel=1e-14)


def test_a_time_at_which_an_input_has_moved_too_far_is_discarded(unzipped, fmi):
    """An integrator may try it, and then another; what is set too far is an error."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        Master(made).start(frequency_rate_A=-1e-3)
        for time in (1e4, 1e308):
            made.fmu.setTime(time)
            status, message = made.refused(made.get, "der(A_re)")
            assert status == DISCARD and "frequency_A: must be" in message
        made.fmu.setTime(1.0)
        assert np.isfinite(made.get("der(A_re)")).all()
        made.set(frequency_rate_A=0.0, frequency_A=1e3)
        assert made.refused(made.get, "der(A_re)")[0] == ERROR
