"""What the method assumes: refused where nothing could follow, warned of where it is strained."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from slipmode import rom, runner
from slipmode.fmu import Component, export
from slipmode.rom import Accuracy
from slipmode.runner import load_scene, make_plan, parse_scene, plan_scene, shipped_scenes

FORCE = ({0: 0.15}, {1: 0.25})


@pytest.mark.parametrize(
    ("frequency", "words"),
    [
        ((0.61, 1.65), "frequency: must be 0.62 to 10 rad/s, because mode A resonates at 1 rad/s"),
        (
            (0.98, 17.1),
            "frequency: must be 1.06 to 17 rad/s, because mode B resonates at 1.7 rad/s",
        ),
        ((0.98, 0.2626), "got 0.2626; if that is in Hz, give 1.65 rad/s"),
    ],
)
def test_steady_states_and_components_refuse_the_same(two_mode_model, frequency, words):
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.steady(two_mode_model, frequency, FORCE)
    assert words in str(refusal.value)
    with pytest.raises(rom.SlipmodeError) as refusal:
        rom.resonance(two_mode_model, FORCE, frequency[:1], frequency[1:])
    assert words in str(refusal.value)
    inputs = dict(zip(("frequency_A", "frequency_B"), frequency, strict=True))
    with pytest.raises(rom.SlipmodeError) as refusal:
        Component(two_mode_model).set_inputs(**inputs)
    assert words.removeprefix("frequency: ") in str(refusal.value)
    assert str(refusal.value).startswith(
        ("frequency_A: must be 0.62", "frequency_B: must be 1.06")
    )


def test_what_is_allowed_is_computed(two_mode_model):
    found = rom.steady(two_mode_model, [(0.62, 1.06), (10.0, 17.0)], FORCE)
    assert np.all(np.abs(found) > 1e-4)


def test_the_frequency_of_a_mode_at_rest_does_not_matter(two_mode_model):
    a = rom.steady(two_mode_model, (0.98, 0.1), (FORCE[0], {1: 0.0}))
    assert abs(a[0]) > 3.0
    assert a[1] == 0.0


def test_a_sweep_is_refused_where_it_leaves_the_range(two_mode_model):
    component = Component(two_mode_model)
    component.set_inputs(frequency_rate_A=-0.01)
    component.do_step(0.0, 30.0)
    with pytest.raises(rom.SlipmodeError, match=r"frequency_A: must be 0.62 .* end of the step"):
        component.do_step(30.0, 10.0)
    assert component.time == 30.0
    rows = np.zeros((3, len(component.input_names)))
    rows[:, component.input_names.index("frequency_A")] = (0.7, 0.65, 0.6)
    rows[:, component.input_names.index("frequency_B")] = 1.7
    with pytest.raises(rom.SlipmodeError, match=r"frequency_A: must be 0.62 .* got 0.6") as stop:
        component.run(np.ones(3), rows)
    assert len(stop.value.outputs) == 2
    assert component.time == 32.0


def test_steady_states_and_components_refuse_equal_frequencies(two_mode_model):
    with pytest.raises(
        rom.SlipmodeError, match=r"^frequency: the frequencies of modes A and B must"
    ):
        rom.steady(two_mode_model, [(0.98, 1.65), (1.3, 1.3)], FORCE)
    assert np.isfinite(rom.steady(two_mode_model, (1.3, 1.3), (FORCE[0], {1: 0.0}))).all()
    component = Component(two_mode_model, FORCE)
    component.set_inputs(frequency_A=1.5, frequency_B=1.3)  # either may be the higher one
    for inputs in ({"frequency_A": 1.3}, {"frequency_B": 1.5, "force_B": 0.0}):
        with pytest.raises(rom.SlipmodeError, match=MEET):
            component.set_inputs(**inputs)
    component.do_step(0.0, 1.0)


MEET = r"^(stopped at t = .* s: )?frequency_A, frequency_B: must differ at all times"


@pytest.mark.parametrize("duration", [20.0, 30.0])  # equal at the end; on the way
def test_a_sweep_is_refused_where_frequencies_meet(two_mode_model, duration):
    component = Component(two_mode_model, FORCE)
    inputs = {"frequency_A": 1.25, "frequency_rate_A": 0.0125, "frequency_B": 1.5}
    component.set_inputs(**inputs)
    row = np.array([[inputs.get(name, 0.0) for name in component.input_names]])
    with pytest.raises(rom.SlipmodeError, match=MEET):
        component.do_step(0.0, duration)
    with pytest.raises(rom.SlipmodeError, match=MEET):
        component.run(np.array([duration]), row)
    with pytest.raises(rom.SlipmodeError, match=MEET):
        list(component.trace(np.array([duration]), row))
    assert component.time == 0.0
    component.do_step(0.0, 19.0)


def test_a_resonance_curve_ends_where_no_slow_flow_follows(one_mode_model):
    curve = rom.resonance_curve(one_mode_model, 0, {0: 0.15}, [[0.1], [0.2]])
    assert np.isnan(curve.below).tolist() == [True, False]
    assert np.isfinite(curve.above).all()


# Warnings


def scene(**changes):
    text = load_scene("two-mode").text
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    return parse_scene(text, ".")


def of_scene(**changes):
    decisions = make_plan(scene(**changes)).decisions
    return [f"{d.subject} {d.choice}: {d.reason}" for d in decisions if d.level != "info"]


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] if name == "blade" else [])
        for name in shipped_scenes()
    ],
)
def test_shipped_scenes_have_no_warning(name):
    assert all(d.level == "info" for d in plan_scene(load_scene(name)).decisions)


LIMIT, ALPHA = "limit = 2.0 ", "alpha = 0.02 "


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("amplitude = 0.15", "amplitude = 150.0"), "friction hardly acts: the limit of "),
        ((LIMIT, "limit = 1.5e-7 "), "friction hardly acts: the limit of contact 1 "),
        ((ALPHA, "alpha = 2.0 "), "friction acts as a dashpot: alpha = 2 m/s is "),
        ((ALPHA, "alpha = 1e-14 "), "friction changes too sharply: alpha = 1e-14 m/s is "),
    ],
)  # fmt: skip
def test_nonsense_is_told_in_the_plan(change, words):
    assert any(line.startswith(words) for line in of_scene(change=change))


def test_nonsense_is_told_among_the_events_of_a_recording(tmp_path):
    recording = runner.run(
        scene(
            limit=(LIMIT, "limit = 1.5e-7 "),
            short=("duration = 1500.0", "duration = 250.0"),
            window=("[1400.0, 1450.0]", "[240.0, 242.0]"),
        ),
        tmp_path,
    )
    told = [event for event in recording.read().events if event.level == "warning"]
    assert any(
        event.message.startswith("friction hardly acts: the limit of contact") for event in told
    )


@pytest.mark.parametrize("law", [rom.Coulomb(2.0), rom.Tanh(2.0, 1e-8), rom.Tanh(2.0, 0.1)])
def test_hard_cases_have_no_warning(law):
    reduced = rom.reduce(rom.two_mass())
    with warnings.catch_warnings():
        warnings.simplefilter("error", rom.ValidityWarning)
        model = rom.tabulate(reduced, law, (4.0, 2.0), tolerance=0.05)
        for force in (FORCE, ({0: 0.0}, {1: 0.25})):
            rom.steady(model, (0.98, 1.65), force)


@pytest.mark.parametrize(
    ("law", "amplitude", "words"),
    [
        (rom.Tanh(1.5e-7, 0.02), 4.0, "friction hardly acts: .* is 1.9e-08 times"),
        (rom.Tanh(2.0, 2.0), 4.0, "friction acts as a dashpot: .* is 5.2 times"),
        (rom.Tanh(2.0, 0.02), 4000.0, "friction hardly acts: .* is 2.5e-04 times"),
    ],
)
def test_python_is_warned_too(law, amplitude, words):
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    with pytest.warns(rom.ValidityWarning, match=words) as issued:
        rom.tabulate(reduced, law, (amplitude,), tolerance=0.05)
    assert issued[0].filename == __file__


def test_a_table_that_is_off_by_more_than_asked_for_says_so():
    stated = Accuracy(1e-3, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 64, 1, 100)
    assert stated.findings() == []
    (found,) = replace(stated, interpolation=4e-3).findings()
    assert (found.subject, found.level) == ("friction table", "warning")
    assert "relative error is up to 0.4 % (tolerance 0.1 %). " in found.reason


def test_an_alpha_that_is_advised_is_accepted():
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    with pytest.warns(rom.ValidityWarning) as issued:
        rom.tabulate(reduced, rom.Tanh(2.0, 2.0), (4.0,), tolerance=0.05)
    advised = float(str(issued[0].message).split("Use alpha = ")[1].split()[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error", rom.ValidityWarning)
        rom.tabulate(reduced, rom.Tanh(2.0, advised), (4.0,), tolerance=0.05)


@pytest.mark.parametrize("saved", [False, True])
def test_a_component_warns_of_what_its_model_strains(saved, tmp_path):
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    with pytest.warns(rom.ValidityWarning, match="friction acts as a dashpot"):
        model = rom.tabulate(reduced, rom.Tanh(2.0, 2.0), (4.0,), tolerance=0.05)
    if saved:
        model.save(tmp_path / "one_mass.rom")
        model = rom.Model.load(tmp_path / "one_mass.rom")
    with pytest.warns(
        rom.ValidityWarning, match="friction acts as a dashpot: .* is 5.2 times"
    ) as issued:
        Component(model)
    assert [warning.filename for warning in issued] == [__file__]
    with pytest.warns(
        rom.ValidityWarning, match="friction acts as a dashpot: .* is 5.2 times"
    ) as issued:
        export(model, tmp_path / "one_mass.fmu")
    assert [warning.filename for warning in issued] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error", rom.ValidityWarning)
        Component(model, warned=False)


def test_forces_that_the_table_does_not_have_are_refused(two_mode_model, tmp_path):
    """The force on contact DOF 2 does not move the contacts as mode B does."""
    patterns = ({0: 1.0}, {1: 1.0, 2: 1.0})
    refused = pytest.raises(rom.SlipmodeError, match=r"^force_patterns: .* give rom\.reduce")
    with refused:
        Component(two_mode_model, patterns)
    with refused:
        export(two_mode_model, tmp_path / "two.fmu", force_patterns=patterns)
    with refused:
        rom.steady(two_mode_model, (0.98, 1.65), ({0: 0.15}, {1: 0.25, 2: 0.25}))
    Component(two_mode_model, ({0: 1.0}, {1: 1.0}))


def test_a_scene_has_its_warnings_in_the_plan_alone():
    with warnings.catch_warnings():
        warnings.simplefilter("error", rom.ValidityWarning)
        assert of_scene(change=(ALPHA, "alpha = 2.0 "))
