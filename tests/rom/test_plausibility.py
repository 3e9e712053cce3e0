"""What the method assumes: refused where nothing could follow, warned of where it is strained."""

import warnings
import zipfile

import fmpy
import numpy as np
import pytest
from fmu_fixtures import VERSIONS, instance

from slipmode import rom
from slipmode.fmu import Component, export
from slipmode.runner import load_scene, plan_scene, shipped_scenes

FORCE = ({0: 0.15}, {1: 0.25})
OMEGA = (0.98, 1.65)
ONE = rom.reduce(rom.two_mass(), modes=(0,))


def silent(call, *arguments, **named):
    """What a call returns that must not warn."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", rom.ValidityWarning)
        return call(*arguments, **named)


def tabulate(law, amplitude=4.0, reduced=ONE, **named):
    return rom.tabulate(
        reduced, law, np.broadcast_to(amplitude, len(reduced.modes)), 0.05, **named
    )


# Frequencies of the forcing: at 0.62 omega free vibration grows by gamma (3 x^2 / 16 - 1 / 2)


@pytest.mark.parametrize(
    ("frequency", "words"),
    [
        ((0.61, 1.65), "must be 0.62 to 10 rad/s, because mode A resonates at 1 rad/s"),
        ((0.98, 17.1), "must be 1.06 to 17 rad/s, because mode B resonates at 1.7 rad/s"),
        ((0.98, 0.2626), "got 0.2626; if that is in Hz, give 1.65 rad/s"),
    ],
)
def test_frequencies_that_no_slow_flow_follows_are_refused(two_mode_model, frequency, words):
    component = Component(two_mode_model)
    named = dict(zip(("frequency_A", "frequency_B"), frequency, strict=True))
    for call in (
        lambda: rom.steady(two_mode_model, frequency, FORCE),
        lambda: rom.resonance(two_mode_model, FORCE, frequency[:1], frequency[1:]),
        lambda: component.set_inputs(**named),
    ):
        with pytest.raises(rom.SlipmodeError) as refusal:
            call()
        assert str(refusal.value).startswith("frequency") and words in str(refusal.value)
    assert component.outputs() == Component(two_mode_model).outputs()


def test_frequencies_in_the_range_and_of_modes_at_rest_are_allowed(two_mode_model):
    with pytest.warns(rom.ValidityWarning, match="is far from mode A"):
        found = rom.steady(two_mode_model, [(0.62, 1.06), (10.0, 17.0)], FORCE)
    assert np.all(np.abs(found) > 1e-4)
    assert silent(rom.steady, two_mode_model, (0.98, 0.1), (FORCE[0], {}))[1] == 0.0
    assert np.isfinite(rom.steady(two_mode_model, (1.3, 1.3), (FORCE[0], {}))).all()


@pytest.mark.parametrize("duration", [20.0, 30.0])  # equal at the end; on the way
def test_frequencies_that_meet_are_refused(two_mode_model, duration):
    with pytest.raises(rom.SlipmodeError, match=r"^frequency: the frequencies of modes A and B"):
        rom.steady(two_mode_model, [OMEGA, (1.3, 1.3)], FORCE)
    component = Component(two_mode_model, FORCE)
    inputs = {"frequency_A": 1.25, "frequency_rate_A": 0.0125, "frequency_B": 1.5}
    component.set_inputs(**inputs)
    row = np.array([[inputs.get(name, 0.0) for name in component.input_names]])
    for call in (
        lambda: component.do_step(0.0, duration),
        lambda: component.run(np.array([duration]), row),
        lambda: list(component.trace(np.array([duration]), row)),
    ):
        with pytest.raises(rom.SlipmodeError, match="frequency_A, frequency_B: must differ at"):
            call()
    assert component.time == 0.0
    component.do_step(0.0, 19.0)


# Warnings of Python


SLOW = rom.two_mass(k1=1e-5)
SWAPPED = rom.Structure(1e6 * rom.two_mass().stiffness, rom.two_mass().mass, contact=[2, 3])
COUPLING = float(np.abs(ONE.coupling).max())  # elastic force on a contact: 2 |a| |L|
IWAN = rom.Iwan(force=2.0, stiffness=20.0, chi=-0.5, beta=1.0)
STUCK = rom.reduce(rom.two_mass(), modes=(0,), law=IWAN)
MACRO = 2.0 / float(np.abs(2.0 * STUCK.coupling[0] * STUCK.contacts.reference).max())


def far(frequency):
    return lambda of: rom.steady(of, frequency, FORCE)


WARNED = {
    "frequency is far from mode A: 1.6 rad/s is 1.6 times the natural": far((1.6, 1.65)),
    "frequency is far from mode B: 9.9 rad/s": far((0.98, 9.9)),
    "frequency is far from mode A: 0.65 rad/s": lambda of: rom.response_curve(
        of, (0.98, 1.75), FORCE, "frequency_A", (0.95, 0.65)
    ),
    "frequency is far from mode A: 1.55 rad/s": lambda of: rom.steady_state(
        ONE, of.law, [1.55], [{0: 3.0}]
    ),
    "carrier is far from mode B: 10.2 rad/s is 6 times": lambda of: tabulate(
        of.law, reduced=of.reduced.at_carrier((0.98, 10.2))
    ),
    "mode A has an implausible frequency: 0.000503 Hz is outside 0.001 to 1e+06 Hz":
        lambda of: rom.reduce(SLOW, modes=(0,)),
    "mode B has an implausible frequency: ": lambda of: rom.reduce(SWAPPED),
    "friction does not act: no contact slips": lambda of: tabulate(rom.Coulomb(2e3)),
    "friction does not act: ": lambda of: tabulate(rom.Tanh(4e3, 0.02)),
    "friction does not act: no contact": lambda of: tabulate(IWAN, 1e-5 * MACRO, STUCK),
    "friction hardly acts: the limit of contact": lambda of: tabulate(
        rom.Coulomb(0.009 * 2.0 * 4.0 * COUPLING)
    ),
    "friction is zero: the friction limit is 0 at all contacts":
        lambda of: tabulate(rom.Coulomb(0.0)),
    "friction is zero: the friction limit is 0 at contact 0": lambda of: tabulate(
        rom.Coulomb((0.0, 2.0)), reduced=of.reduced
    ),
    "friction acts as a dashpot: alpha = 2 m/s is 5.2 times": lambda of: tabulate(
        rom.Tanh(2.0, 2.0)
    ),
    "friction changes too sharply: alpha = 1e-14 m/s is": lambda of: tabulate(
        rom.Tanh(2.0, 1e-14)
    ),
}  # fmt: skip


@pytest.mark.parametrize("words", WARNED)
def test_python_warns_where_it_is_called(two_mode_model, words):
    with pytest.warns(rom.ValidityWarning) as issued:
        WARNED[words](two_mode_model)
    assert any(str(each.message).startswith(words) for each in issued)
    assert {each.filename for each in issued} == {__file__}


SILENT = {
    "a hundredth": lambda of: tabulate(rom.Coulomb(0.011 * 2.0 * 4.0 * COUPLING)),
    "creep of half the structural damping": lambda of: tabulate(rom.Tanh(4.0, 0.02), 0.9),
    "the first sliders of an Iwan joint": lambda of: tabulate(IWAN, 0.01 * MACRO, STUCK),
    "sharp": lambda of: tabulate(rom.Tanh(2.0, 1e-8)),
    "blurred": lambda of: tabulate(rom.Tanh(2.0, 0.1), (4.0, 2.0), of.reduced),
    "mass and stiffness": lambda of: rom.reduce(rom.two_mass()),
}


@pytest.mark.parametrize("name", SILENT)
def test_plausible_cases_have_no_warning(two_mode_model, name):
    silent(SILENT[name], two_mode_model)


@pytest.mark.oracle
def test_the_force_from_which_contacts_slip_is_stated():
    """From the amplitudes without slip: the elastic force 2 |a| |L| reaches the limit of 2 N."""
    model = tabulate(rom.Coulomb(2.0), (4.0, 2.0), rom.reduce(rom.two_mass()))
    with pytest.warns(rom.ValidityWarning, match="friction does not act: ") as issued:
        a = rom.steady(model, OMEGA, ({0: 0.001}, {1: 0.001}))
    factor = float(str(issued[0].message).split("contacts slip from ")[1].split()[0])
    elastic = 2.0 * np.abs(a) @ np.abs(model.reduced.coupling)
    assert factor == pytest.approx(2.0 / elastic.max(), rel=1e-2)


@pytest.mark.oracle
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
@pytest.mark.parametrize(("limit", "held"), [(2e-29, False), (2e29, True)])
def test_extreme_limits_leave_the_linear_response(limit, held):
    """Of the structure with free contacts, or with bonded ones."""
    s, nu, free = rom.two_mass(), 0.8, slice(0, 2 if held else 4)
    D = (s.stiffness + 1j * nu * s.damping - nu**2 * s.mass)[free, free]
    x = np.linalg.solve(D, 0.5 * np.eye(4)[0, free])
    model = rom.tabulate(ONE.at_carrier([nu]), rom.Coulomb(limit), (4.0,), 1e-4)
    assert rom.steady(model, [nu], [{0: 1.0}])[0] == pytest.approx(x[0], rel=1e-4)


# Components, FMUs and scenes


def test_components_and_fmus_warn_of_what_their_model_strains(tmp_path):
    model = tabulate(rom.Tanh(2.0, 2.0), warned=False)
    model.save(tmp_path / "one_mass.rom")
    words = "friction acts as a dashpot: .* is 5.2 times"
    for each in (model, rom.Model.load(tmp_path / "one_mass.rom")):
        with pytest.warns(rom.ValidityWarning, match=words) as issued:
            Component(each)
        assert [warning.filename for warning in issued] == [__file__]
    with pytest.warns(rom.ValidityWarning, match=words):
        path = export(model, tmp_path / "one_mass.fmu")
    with zipfile.ZipFile(path) as archive:
        assert "friction acts as a dashpot" in archive.read("documentation/index.html").decode()
    silent(Component, model, warned=False)


@pytest.mark.parametrize("fmi", VERSIONS)
def test_an_fmu_logs_once_that_a_frequency_is_far_from_its_mode(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start().step(0.0, 1.0)
        assert made.messages == []
        for start, frequency in ((1.0, 10.2), (2.0, 10.3)):
            made.set(frequency_B=frequency)
            made.step(start, 1.0)
        ((status, message),) = made.messages
        assert status == 1
        assert message.startswith("frequency_B: is far from its mode: 10.2 rad/s is 6 times the")
        assert message.endswith("if a factor 2 pi was applied twice, give 1.623 rad/s")
        made.set(frequency_B=0.27)
        with pytest.raises(fmpy.fmi1.FMICallException):
            made.step(3.0, 1.0)
        assert made.messages[-1][1].endswith("got 0.27; if that is in Hz, give 1.696 rad/s")


@pytest.mark.parametrize("name", sorted(set(shipped_scenes()) - {"blade"}))  # a large one
def test_shipped_scenes_have_no_warning(name):
    assert all(d.level == "info" for d in plan_scene(load_scene(name)).decisions)
