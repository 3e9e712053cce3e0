"""Co-Simulation between the steps: events, early returns, parameters that change."""

import fmpy
import numpy as np
import pytest
from fmu_exchange import Master
from fmu_fixtures import VERSIONS, Instance, instance

AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")
FORCES = {"force_A": 0.3, "force_B": 0.1}


class Modes(Instance):
    """With event mode, or early returns."""

    def __init__(self, folder, **allowed):
        self.allowed = allowed
        super().__init__(folder, 3)

    def _instantiate(self):
        def log(environment, status, category, message):
            self.messages.append((status, message.decode()))

        self.fmu.instantiate(logMessage=log, loggingOn=True, **self.allowed)


def test_forces_jump_at_events_as_they_do_between_steps(scalable):
    plain = instance(scalable[3], 3)
    made = Modes(scalable[3], eventModeUsed=True)
    with plain as expected:
        expected.start()
        made.start()
        made.fmu.updateDiscreteStates()
        made.fmu.enterStepMode()
        for one in (expected, made):
            one.step(0.0, 20.0)
        expected.set(**FORCES)
        made.fmu.enterEventMode()
        made.set(**FORCES)
        again, terminate, *_ = made.fmu.updateDiscreteStates()
        assert not again and not terminate
        made.fmu.enterStepMode()
        for one in (expected, made):
            one.step(20.0, 20.0)
        np.testing.assert_array_equal(made.get(*AMPLITUDES), expected.get(*AMPLITUDES))
    made.free()


def test_steps_are_for_step_mode_and_events_for_those_who_asked(scalable):
    made = Modes(scalable[3], eventModeUsed=True)
    made.start()
    with pytest.raises(fmpy.fmi1.FMICallException):
        made.step(0.0, 1.0)
    assert "doStep: not allowed while the instance is in event mode" in made.messages[-1][
        1
    ].replace("fmi3DoStep", "doStep")
    made.free()
    with instance(scalable[3], 3) as plain:
        plain.start()
        with pytest.raises(fmpy.fmi1.FMICallException):
            plain.fmu.enterEventMode()
        assert "made without event mode" in plain.messages[-1][1]


def test_a_step_ends_where_the_table_does(scalable):
    """Where nobody allows that it is discarded."""
    made = Modes(scalable[3], earlyReturnAllowed=True)
    made.start(force_A=2.0)
    event, terminate, early, last = made.fmu.doStep(0.0, 400.0)
    assert early and not event and not terminate and 5.0 < last < 400.0
    assert any("early, where the friction table ends" in text for _, text in made.messages)
    reached = np.hypot(*made.get("A_re", "A_im"))
    assert reached == pytest.approx(3.0, rel=1e-3)
    with instance(scalable[3], 3) as plain:
        plain.start(force_A=2.0)
        plain.step(0.0, 0.999 * last)  # so far it goes
        with pytest.raises(fmpy.fmi1.FMICallException):
            plain.step(0.999 * last, 1.0)
    with pytest.raises(fmpy.fmi1.FMICallException):
        made.fmu.doStep(last, 1.0)
    assert "however short the step" in made.messages[-1][1]
    made.set(force_A=0.0)
    assert not made.fmu.doStep(last, 1.0)[2]  # and goes on from there
    made.free()


def rates(made, damping, at):
    """Of the amplitudes with another damping, changed at an event."""
    master = Master(made).start(**at)
    master.event(damping_A=damping)
    return made.get("der(A_re)", "der(A_im)", "input_power")


@pytest.mark.parametrize("fmi", VERSIONS)
def test_damping_may_be_tuned(scalable, fmi):
    at = {"A_re": 1.1, "A_im": -0.4, "B_re": 0.3, "B_im": 0.5}
    with instance(scalable[fmi], fmi, exchange=True) as tuned:
        found = rates(tuned, 0.05, at)
    with instance(scalable[fmi], fmi, exchange=True) as other:
        Master(other).start(**at, damping_A=0.05)
        np.testing.assert_array_equal(other.get("der(A_re)", "der(A_im)", "input_power"), found)
    with instance(scalable[fmi], fmi) as stepped, instance(scalable[fmi], fmi) as plain:
        for one in (stepped, plain):
            one.start(**at)
            one.step(0.0, 10.0)
        before = stepped.get(*AMPLITUDES)
        stepped.set(damping_A=0.05)
        np.testing.assert_array_equal(stepped.get(*AMPLITUDES), before)
        assert stepped.get("damping_A") == [0.05]
        h = 1e-4
        rate = stepped.get("der(A_re)", "der(A_im)")
        stepped.step(10.0, h)
        np.testing.assert_allclose((stepped.get("A_re", "A_im") - before[:2]) / h, rate, rtol=1e-3)
        for one in (stepped, plain):
            one.step(10.0 + h * (one is stepped), 100.0)
        assert np.hypot(*stepped.get("A_re", "A_im")) < 0.9 * np.hypot(*plain.get("A_re", "A_im"))


@pytest.mark.parametrize("fmi", VERSIONS)
def test_the_tolerance_may_be_tuned(scalable, fmi):
    """Exact steps from where loose ones came to, the same whatever their length."""
    with instance(scalable[fmi], fmi) as loose, instance(scalable[fmi], fmi) as short:
        loose.start(tolerance=1e-2).step(0.0, 50.0)
        short.restore(loose.serialize())
        errors = []
        for tolerance in (1e-2, 1e-11):
            start, at = loose.serialize(), loose.get(*AMPLITUDES)
            short.restore(start)
            for one in (loose, short):
                one.set(tolerance=tolerance)
                assert one.get("tolerance") == [tolerance]
                np.testing.assert_array_equal(one.get(*AMPLITUDES), at)
            loose.step(50.0, 50.0)
            for k in range(200):
                short.step(50.0 + 0.25 * k, 0.25)
            errors.append(np.abs(loose.get(*AMPLITUDES) - short.get(*AMPLITUDES)).max())
            loose.restore(start)
        assert errors[0] > 1e-5 and errors[1] < 1e-9, errors
        for wrong in (0.0, 0.1, -1e-6):
            with pytest.raises(fmpy.fmi1.FMICallException):
                loose.set(tolerance=wrong)
            assert f"tolerance: must be 1e-13 to 0.01, got {wrong:g}" in loose.messages[-1][1]


def test_what_is_no_time_to_tune(scalable):
    with instance(scalable[3], 3, exchange=True) as made:
        Master(made).start()
        with pytest.raises(fmpy.fmi1.FMICallException):
            made.set(damping_A=0.05)
        assert "damping_A: not allowed while" in made.messages[-1][1]


def test_a_state_in_event_mode_is_for_instances_that_have_one(scalable):
    made = Modes(scalable[3], eventModeUsed=True)
    made.start()
    state = made.serialize()
    with instance(scalable[3], 3) as plain:
        plain.start()
        with pytest.raises(fmpy.fmi1.FMICallException):
            plain.restore(state)
        assert "an instance with an event mode" in plain.messages[-1][1]
    made.free()
