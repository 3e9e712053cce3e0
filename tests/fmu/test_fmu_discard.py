"""Steps that leave the friction table: discarded, explained, and not tried for ever."""

import re

import fmpy
import pytest
from fmpy.fmi2 import fmi2LastSuccessfulTime, fmi2Terminated
from fmu_exchange import Master
from fmu_fixtures import START, VERSIONS, instance

FMI_ERRORS = fmpy.fmi1.FMICallException


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


def test_an_amplitude_beyond_the_table_is_discarded(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start(force_A=3.0).step(0.0, 1.0)
        before = made.serialize()
        with pytest.raises(FMI_ERRORS) as refused:
            made.step(1.0, 100.0)
        assert refused.value.status == 2  # discard: a shorter step may do
        assert "outside the friction table" in made.messages[-1][1]
        assert made.serialize() == before
        made.step(1.0, 1.0)
        made.fmu.terminate()


def discarded(made, time, duration):
    """Whether a step is discarded, and whether the FMU then asks for the end."""
    try:
        made.step(time, duration)
    except FMI_ERRORS as refused:
        assert refused.status == 2
    else:
        return False, False
    assert made.fmu.getRealStatus(fmi2LastSuccessfulTime) == time == made.get("time")[0]
    return True, made.fmu.getBooleanStatus(fmi2Terminated)


def test_steps_are_halved_up_to_the_table_s_end_and_no_further(unzipped):
    """As importers do that keep away from a step that was discarded."""
    with instance(unzipped[2], 2) as made:
        made.start(force_A=3.0).step(0.0, 1.0)
        time, step, terminated = 1.0, 100.0, False
        for _ in range(30):
            refused, terminated = discarded(made, time, step)
            if terminated:
                break
            time, step = (time, 0.5 * step) if refused else (time + step, step)
        assert terminated
        assert "however short the step" in made.messages[-1][1]
        end = re.search(r"A_abs is ([\d.]+), the table ends at ([\d.]+)", made.messages[-1][1])
        assert 0.99 < float(end[1]) / float(end[2]) <= 1.0
        made.set(force_A=0.0)  # another input, and it goes on
        assert discarded(made, time, 1.0) == (False, False)


def test_a_step_that_is_tried_again_ends_the_simulation(unzipped):
    with instance(unzipped[2], 2) as made:
        made.start(force_A=3.0).step(0.0, 1.0)
        assert discarded(made, 1.0, 100.0) == (True, False)
        assert discarded(made, 1.0, 100.0) == (True, True)
        made.step(1.0, 1.0)
        assert made.fmu.getBooleanStatus(fmi2Terminated) is False


def test_a_refused_range_is_told_with_what_would_help(unzipped, fmi, two_mode_model):
    with instance(unzipped[fmi], fmi) as made:
        made.start(force_A=3.0)
        with pytest.raises(FMI_ERRORS):
            made.step(0.0, 100.0)
        message = made.messages[-1][1]
        ends = float(f"{two_mode_model.table.amplitude_range[0]:.4g}")
        assert f"the table ends at {ends:g}; lower force_A, now 3, or export" in message
        assert "--range of slipmode fmu" in message


def test_a_time_at_which_an_input_has_moved_too_far_is_discarded(unzipped, fmi):
    """An integrator may try it, and then another; what is set too far is an error."""
    with instance(unzipped[fmi], fmi, exchange=True) as made:
        Master(made).start(frequency_rate_A=-1e-3)
        for time in (1e4, 1e308):
            made.fmu.setTime(time)
            with pytest.raises(FMI_ERRORS) as refused:
                made.get("der(A_re)")
            assert refused.value.status == 2
            assert "frequency_A: must be" in made.messages[-1][1]
        made.fmu.setTime(1.0)
        assert made.get("frequency_A")[0] == pytest.approx(START["frequency_A"] - 1e-3)
        made.set(frequency_rate_A=0.0, frequency_A=1e3)
        with pytest.raises(FMI_ERRORS) as refused:
            made.get("der(A_re)")
        assert refused.value.status == 3
