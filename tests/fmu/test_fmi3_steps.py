"""FMI 3.0: reading within steps, early returns, event mode, tunable parameters, arrays."""

from contextlib import contextmanager

import fmpy
import numpy as np
import pytest
from fmu_exchange import AMPLITUDES, Master
from fmu_fixtures import DISCARD, FMI_ERRORS, instance

READ = ("A_re", "B_im", "A_abs", "dissipated_energy", "contact_0_x", "contact_1_f")
END = 200.0


@contextmanager
def observed(folder, at, required=READ, **allowed):
    """An instance that calls at(instance, time, may_return) within its steps.

    Where `at` returns a time, the step is to end there.
    """
    failed, made = [], []  # nobody hears of what is raised in a callback

    def update(_, time, set_requested, get_allowed, finished, may_return, early, until):
        try:
            assert get_allowed and finished and not set_requested
            wanted = at(made[0], time, may_return)
        except Exception as error:
            failed.append(error)
            return
        if wanted is not None:
            early[0], until[0] = True, wanted

    variables = fmpy.read_model_description(folder).modelVariables
    references = [v.valueReference for v in variables if v.name in required]
    allowed |= {"requiredIntermediateVariables": references, "intermediateUpdate": update}
    with instance(folder, 3, **allowed) as one:
        made.append(one)
        yield one
    if failed:
        raise failed[0]


def test_internal_steps_are_read_as_communication_points_are(unzipped):
    """In order, up to the end of the step, with the amplitudes of other steps of this length."""
    seen = {}

    def read(made, time, may_return):
        assert not may_return
        seen[time] = made.get(*READ)

    with observed(unzipped[3], read) as made:
        assert made.start().step(0.0, END) == (False, False, False, END)
        np.testing.assert_array_equal(seen[END], made.get(*READ))
    times = list(seen)
    assert len(times) > 5 and times == sorted(times) and times[-1] == END
    with observed(unzipped[3], lambda *_: None) as plain:
        plain.start()
        for before, time in zip([0.0, *times], times, strict=False):
            plain.step(before, time - before)
            np.testing.assert_allclose(plain.get(*READ[:4]), seen[time][:4], rtol=0, atol=1e-9)


@pytest.mark.parametrize("ahead", [-1.0, 0.0, 3.0])
def test_a_step_ends_where_the_importer_wants(unzipped, ahead):
    """At once, or at a later time that it names."""
    seen = []

    def stop(made, time, may_return):
        seen.append(time)
        return time + ahead if len(seen) == 3 else None

    with observed(unzipped[3], stop, earlyReturnAllowed=True) as made:
        event, terminate, early, last = made.start().step(0.0, END)
        assert early and not event and not terminate and last == seen[-1]
        assert last == pytest.approx(seen[2] + max(ahead, 0.0), rel=1e-15)
        assert made.step(last, 0.1)[:3] == (False, False, False)
    with observed(unzipped[3], lambda made, time, _: time) as made:  # not allowed: not heard
        assert made.start().step(0.0, END) == (False, False, False, END)


def variables_of(folder):
    return {v.name: v for v in fmpy.read_model_description(folder).modelVariables}


def test_a_discarded_step_leaves_no_trace_though_internal_steps_were_shown(scalable):
    seen = []
    with observed(scalable[3], lambda made, time, _: seen.append(time), ("A_re",)) as made:
        before = made.start(force_A=2.0).serialize()
        status, message = made.refused(made.step, 0.0, 400.0)
        assert status == DISCARD and "outside the friction table" in message
        assert len(seen) > 2 and made.serialize() == before


def test_forces_jump_at_events_as_they_do_between_steps(scalable):
    forces = {"force_A": 0.3, "force_B": 0.1}
    with (
        instance(scalable[3], 3) as plain,
        instance(scalable[3], 3, eventModeUsed=True) as made,
    ):
        plain.start()
        made.start()
        assert "while the instance is in event mode" in made.refused(made.step, 0.0, 1.0)[1]
        assert "made without event mode" in plain.refused(plain.fmu.enterEventMode)[1]
        state = made.serialize()
        assert "an instance with an event mode" in plain.refused(plain.restore, state)[1]
        made.fmu.updateDiscreteStates()
        made.fmu.enterStepMode()
        for one in (plain, made):
            one.step(0.0, 20.0)
        plain.set(**forces)
        made.fmu.enterEventMode()
        made.set(**forces)
        again, terminate, *_ = made.fmu.updateDiscreteStates()
        assert not again and not terminate
        made.fmu.enterStepMode()
        for one in (plain, made):
            one.step(20.0, 20.0)
        np.testing.assert_array_equal(made.get(*AMPLITUDES), plain.get(*AMPLITUDES))


def test_a_step_that_may_return_early_ends_where_the_table_does(scalable):
    with (
        instance(scalable[3], 3, earlyReturnAllowed=True, loggingOn=True) as made,
        instance(scalable[3], 3) as plain,
    ):
        event, terminate, early, last = made.start(force_A=2.0).step(0.0, 400.0)
        assert early and not event and not terminate and 5.0 < last < 400.0
        assert any("early, where the friction table ends" in text for _, text in made.messages)
        assert np.hypot(*made.get("A_re", "A_im")) == pytest.approx(3.0, rel=1e-3)
        plain.start(force_A=2.0).step(0.0, 0.999 * last)  # so far it goes
        with pytest.raises(FMI_ERRORS):
            plain.step(0.999 * last, 1.0)
        assert "however short the step" in made.refused(made.step, last, 1.0)[1]
        made.set(force_A=0.0)
        assert not made.step(last, 1.0)[2]  # and goes on from there


@pytest.mark.oracle
def test_damping_may_be_tuned_at_events_and_changes_the_decay_alone(scalable, fmi):
    """d(der(a))/d(damping) is -a / 2, and a co-simulation goes on at the tuned rate."""
    at = {"A_re": 1.1, "A_im": -0.4, "B_re": 0.3, "B_im": 0.5}
    names = ("der(A_re)", "der(A_im)", "der(B_re)", "der(B_im)")
    with instance(scalable[fmi], fmi, exchange=True) as tuned:
        master = Master(tuned).start(**at, damping_A=0.01)
        before = tuned.get(*names)
        assert "damping_A: not allowed while" in tuned.refused(tuned.set, damping_A=0.05)[1]
        master.event(damping_A=0.05)
        change = tuned.get(*names) - before
        expected = -0.5 * (0.05 - 0.01) * np.array([1.1, -0.4])
        # up to the loss factor, 0.05, and the detuning, 0.02
        assert np.linalg.norm(change[:2] - expected) < 0.07 * np.linalg.norm(expected)
        assert np.abs(change[2:]).max() < 1e-3 * np.abs(change).max()
    with instance(scalable[fmi], fmi) as stepped:
        stepped.start(**at).step(0.0, 10.0)
        a, h = stepped.get("A_re", "A_im"), 1e-4
        stepped.set(damping_A=0.05)
        np.testing.assert_array_equal(stepped.get("A_re", "A_im"), a)
        rate = stepped.get("der(A_re)", "der(A_im)")
        stepped.step(10.0, h)
        np.testing.assert_allclose((stepped.get("A_re", "A_im") - a) / h, rate, rtol=1e-3)


def test_a_tighter_tolerance_takes_effect_between_steps(scalable, fmi):
    """A long step and many short ones differ by less."""
    with instance(scalable[fmi], fmi) as long, instance(scalable[fmi], fmi) as short:
        start = [long.start(tolerance=1e-2).step(0.0, 50.0), long.serialize()][1]
        short.start()
        errors = []
        for tolerance in (1e-2, 1e-11):
            for one in (long, short):
                one.restore(start)
                one.set(tolerance=tolerance)
            long.step(50.0, 50.0)
            for k in range(200):
                short.step(50.0 + 0.25 * k, 0.25)
            errors.append(np.abs(long.get(*AMPLITUDES) - short.get(*AMPLITUDES)).max())
        assert errors[0] > 1e-5 and errors[1] < 1e-9, errors


def test_arrays_are_the_motion_of_all_contacts(unzipped, fmus):
    """Also in FMPy; they cannot be set, and FMI 2.0 does not have them."""
    with instance(unzipped[3], 3) as made:
        made.start().step(0.0, 30.0)
        for letter in "xvf":
            values = made.fmu.getFloat64([made.reference[f"contact_{letter}"]], nValues=2)
            scalars = made.get(f"contact_0_{letter}", f"contact_1_{letter}")
            assert np.abs(values).min() > 0.0
            np.testing.assert_array_equal(values, scalars)
        x = [made.reference["contact_x"]]
        message = made.refused(made.fmu.getFloat64, x, nValues=3)[1]
        assert "must be 2 for these variables, got 3" in message
        assert "contact_x: is an array" in made.refused(made.fmu.setFloat64, x, [0.0])[1]
    names = ["contact_x", "contact_0_x", "contact_1_x"]
    result = fmpy.simulate_fmu(fmus[3], stop_time=5.0, output_interval=0.5, output=names)
    scalars = np.column_stack([result[name] for name in names[1:]])
    np.testing.assert_array_equal(result["contact_x"], scalars)
    assert "contact_x" not in variables_of(unzipped[2])
