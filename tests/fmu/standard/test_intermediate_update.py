"""Co-Simulation of FMI 3.0: what an importer is told of within a step, and may do there."""

from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmu_fixtures import Instance

READ = ("A_re", "B_im", "A_abs", "dissipated_energy", "contact_0_x", "contact_1_f")
END = 200.0


class Observed(Instance):
    """Told of the internal steps; `at` says what is done there."""

    def __init__(self, folder, at, required=READ, **allowed):
        self.at, self.required, self.allowed = at, required, allowed
        self.failed = []  # nobody hears of what is raised in a callback
        super().__init__(folder, 3)

    def _instantiate(self):
        def log(environment, status, category, message):
            self.messages.append((status, message.decode()))

        def update(_, time, set_requested, get_allowed, finished, may_return, early, until):
            try:
                assert get_allowed and finished and not set_requested
                wanted = self.at(self, time, may_return)
            except Exception as error:
                self.failed.append(error)
                return
            if wanted is not None:
                early[0], until[0] = True, wanted

        self.fmu.instantiate(
            logMessage=log,
            loggingOn=True,
            intermediateUpdate=update,
            requiredIntermediateVariables=[self.reference[name] for name in self.required],
            **self.allowed,
        )

    def free(self):
        super().free()
        if self.failed:
            raise self.failed[0]


@pytest.fixture
def observe(unzipped):
    made = []

    def make(at, **options):
        made.append(Observed(unzipped[3], at, **options))
        return made[-1].start()

    yield make
    for one in made:
        one.free()


def test_internal_steps_are_read_as_communication_points_are(observe):
    """The last one is the step's end; amplitudes within 1e-9 whatever is read on the way."""
    seen = {}

    def read(made, time, may_return):
        assert not may_return
        seen[time] = made.get(*READ)

    made = observe(read)
    assert made.fmu.doStep(0.0, END) == (False, False, False, END)
    times = list(seen)
    assert len(times) > 5 and times == sorted(times) and times[-1] == END
    np.testing.assert_array_equal(seen[END], made.get(*READ))

    plain = observe(lambda made, time, may_return: None)
    before = 0.0
    for time in times:
        plain.step(before, time - before)
        np.testing.assert_allclose(plain.get(*READ[:4]), seen[time][:4], rtol=0, atol=1e-9)
        np.testing.assert_allclose(plain.get(*READ[4:]), seen[time][4:], rtol=0, atol=2e-2)
        before = time


def test_who_is_told_computes_what_others_do(observe, unzipped):
    """To the tolerance: internal steps are others where one is tried again. Measured 2.3e-8.

    Five steps, each of which may be off by the internal tolerance of 1e-8.
    """
    made = observe(lambda made, time, may_return: None)
    plain = Instance(unzipped[3], 3).start()
    for one in (made, plain):
        one.set(tolerance=1e-8)
        for k in range(5):
            one.step(40.0 * k, 40.0)
    np.testing.assert_allclose(made.get(*READ[:4]), plain.get(*READ[:4]), rtol=5e-8)
    plain.free()


@pytest.mark.parametrize("ahead", [-1.0, 0.0, 3.0])
def test_a_step_ends_where_the_importer_wants(observe, ahead):
    """At once, or at a later time that it names."""
    seen = []

    def stop(made, time, may_return):
        seen.append(time)
        asked = seen[2] + max(ahead, 0.0) if len(seen) > 2 else END
        assert may_return == (time < asked or len(seen) == 3)
        return time + ahead if len(seen) == 3 else None

    made = observe(stop, earlyReturnAllowed=True)
    event, terminate, early, last = made.fmu.doStep(0.0, END)
    assert early and not event and not terminate
    assert last == pytest.approx(seen[2] + max(ahead, 0.0), rel=1e-15) and last == seen[-1]
    made.at = lambda made, time, may_return: None  # the next step runs to its end
    *ended, last_again = made.fmu.doStep(last, 0.1)
    assert ended == [False, False, False]
    assert last_again == pytest.approx(last + 0.1, rel=1e-15)


def test_nobody_ends_a_step_without_early_returns(observe):
    made = observe(lambda made, time, may_return: time)
    assert made.fmu.doStep(0.0, END) == (False, False, False, END)


def test_what_is_not_allowed_within_a_step_is_refused(observe):
    """By a line that says why; the step goes on as if nothing had been asked for."""
    reasons = []

    def try_all(made, time, may_return):
        for call in (
            lambda: made.get("B_re"),
            lambda: made.set(force_A=1.0),
            lambda: made.step(time, 1.0),
            lambda: made.fmu.getFMUState(),
        ):
            with pytest.raises(fmpy.fmi1.FMICallException):
                call()
            reasons.append(made.messages[-1][1])

    made, plain = observe(try_all), observe(lambda made, time, may_return: None)
    for one in (made, plain):
        one.step(0.0, END)
    assert "B_re: is not among the required intermediate variables" in reasons[0]
    assert all("while the instance is in intermediate update mode" in r for r in reasons[1:4])
    np.testing.assert_array_equal(made.get(*READ), plain.get(*READ))


@pytest.mark.parametrize("name", ["force_A", "damping_A", "der(A_re)"])
def test_only_outputs_are_intermediate_variables(unzipped, name):
    with pytest.raises(Exception, match="Failed to instantiate"):
        Observed(unzipped[3], None, required=(name,))


def test_a_discarded_step_leaves_no_trace(scalable):
    """Though some of its internal steps were shown."""
    seen = []
    made = Observed(scalable[3], lambda made, time, _: seen.append(time), required=("A_re",))
    made.start(force_A=2.0)
    before = made.serialize()
    with pytest.raises(fmpy.fmi1.FMICallException):
        made.step(0.0, 400.0)
    assert len(seen) > 2
    assert made.serialize() == before
    made.free()


def test_the_model_description_says_so(unzipped):
    description = fmpy.read_model_description(unzipped[3])
    assert description.coSimulation.providesIntermediateUpdate
    assert description.coSimulation.canReturnEarlyAfterIntermediateUpdate
    root = ElementTree.parse(unzipped[3] / "modelDescription.xml")
    marked = {v.get("name") for v in root.find("ModelVariables") if v.get("intermediateUpdate")}
    assert marked == {v.name for v in description.modelVariables if v.causality == "output"}
