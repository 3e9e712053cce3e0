"""What Model Exchange has in common with Co-Simulation: moving inputs, carrier angles."""

import numpy as np
import pytest
from fmu_exchange import STATES, Master
from fmu_fixtures import START, VERSIONS, instance

RATES = {"frequency_rate_A": -6e-4, "force_rate_B": 2e-3, "phase_rate_A": 3e-3}
TURN = 2 * np.pi


@pytest.fixture(params=VERSIONS)
def fmi(request):
    return request.param


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
