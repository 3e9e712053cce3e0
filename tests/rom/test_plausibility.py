"""Implausible frequencies, carriers and friction limits are reported wherever they are given."""

import warnings
import zipfile
from math import pi

import fmpy
import numpy as np
import pytest
from fmu_fixtures import VERSIONS, instance

from slipmode import rom
from slipmode.fmu import Component, export
from slipmode.rom.frequencies import carrier_findings, carrier_refusal, mode_frequency_findings
from slipmode.rom.validity import friction_findings
from slipmode.runner import export_fmu, load_scene, make_plan, parse_scene

FORCE = ({0: 0.15}, {1: 0.25})
LAW = rom.Coulomb(2.0)


def plan_of(name, *changes, appended=""):
    """The plan of a shipped scene after changes of its text."""
    text = load_scene(name).text
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return make_plan(parse_scene(text + appended, "."))


def warned_by(plan):
    return [f"{d.subject} {d.choice}: {d.reason}" for d in plan.decisions if d.level == "warning"]


def silent(call, *arguments, **named):
    """What a call returns that must not warn."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", rom.ValidityWarning)
        return call(*arguments, **named)


def two_mass_table(carrier=None, law=LAW, amplitude=(4.0, 2.0), warned=False):
    reduced = rom.reduce(rom.two_mass(), carrier=carrier)
    return rom.tabulate(reduced, law, amplitude, tolerance=0.1, warned=warned)


# Frequencies of the forcing


def of_forcing(ratio, unit="rad/s", per_unit=1.0):
    omega = np.array([50.0 * per_unit])
    return carrier_findings("frequency", "A", omega, ratio * omega, unit)


@pytest.mark.parametrize(("ratio", "far"), [(1.49, 0), (1.51, 1), (1 / 1.49, 0), (1 / 1.51, 1)])
def test_forcing_is_far_beyond_a_ratio_of_1_5(ratio, far):
    assert len(of_forcing(ratio)) == far


@pytest.mark.parametrize(
    ("ratio", "unit", "hint"),
    [
        (2 * pi, "Hz", "if that is in rad/s, give 50 Hz"),
        (1 / (2 * pi), "Hz", "if a factor 2 pi was applied twice, give 50 Hz"),
        (1 / (2 * pi), "rad/s", "if that is in Hz, give 50 rad/s"),
        (2 * pi, "rad/s", "if a factor 2 pi was applied twice, give 50 rad/s"),
        (2 * pi * 1.24, "Hz", "give 62 Hz"),
        (2 * pi * 1.26, "Hz", ""),
        (3.0, "rad/s", ""),
    ],
)
def test_a_factor_2_pi_is_named_in_the_unit_of_the_input(ratio, unit, hint):
    per_unit = 2 * pi if unit == "Hz" else 1.0
    (found,) = of_forcing(ratio, unit, per_unit)
    assert f"times the natural frequency of 50 {unit}" in found.reason
    assert found.reason.endswith(hint or "or compare with slipmode validate")


def test_a_refusal_is_in_the_unit_of_the_input():
    refusal = carrier_refusal("forcing.A.frequency", "A", 100 * pi, 16 * pi, "Hz")
    assert refusal == (
        "forcing.A.frequency: must be 31 to 500 Hz, because mode A resonates at 50 Hz; got 8; "
        "if a factor 2 pi was applied twice, give 50.27 Hz"
    )


# One mode at 50 Hz.
AT_50_HZ = (
    (
        'model = "two-mass"',
        'model = "two-mass"\n'
        f"k1 = {(100 * pi) ** 2}\nk2 = {(170 * pi) ** 2}\nk_c1 = 2e6\nk_c2 = 4e6",
    ),
    ("damping = 0.01 ", "damping = 1e-4 "),
    ("limit = 2.0 ", "limit = 5e3 "),
    ("amplitude = 0.15 ", "amplitude = 200.0 "),
    ('law = "tanh"', 'law = "coulomb"'),
    ("alpha = 0.02", "# alpha"),
    ("duration = 800.0", "duration = 2.0"),
    ("step = 1.0", "step = 0.01"),
    ("window = [750.0, 800.0]", "window = [1.9, 2.0]"),
)
IN_HZ = '\n[units]\nfrequency = "Hz"\n'


@pytest.mark.parametrize("table", ["whole", "none"])
@pytest.mark.parametrize(
    ("given", "unit", "words"),
    [
        (49.5, "Hz", None),
        (
            316.0,
            "Hz",
            "forcing.A.frequency is far from mode A: 316 Hz is 6.32 times the natural frequency "
            "of "
            "50 Hz, outside 0.67 to 1.5 times; if that is in rad/s, give 50.29 Hz",
        ),
        (
            1900.0,
            "rad/s",
            "forcing.A.frequency is far from mode A: 1900 rad/s is 6.05 times the natural "
            "frequency "
            "of 314.2 rad/s, outside 0.67 to 1.5 times; if a factor 2 pi was applied twice, give "
            "302.4 rad/s",
        ),
    ],
)
def test_a_scene_reports_forcing_in_the_wrong_unit(given, unit, words, table):
    plan = plan_of(
        "one-mode",
        *AT_50_HZ,
        ("frequency = 0.9825 ", f"frequency = {given} "),
        appended=(IN_HZ if unit == "Hz" else "") + f'\n[model]\ntable = "{table}"\n',
    )
    far = [line for line in warned_by(plan) if "far from mode" in line]
    assert far == ([] if words is None else [words])


def test_a_scene_refuses_a_unit_in_its_own_unit():
    with pytest.raises(rom.SlipmodeError, match=r"must be 31 to 500 Hz, .*give 50\.27 Hz"):
        plan_of("one-mode", *AT_50_HZ, ("frequency = 0.9825", "frequency = 8.0"), appended=IN_HZ)


def test_steady_states_report_forcing_far_from_its_mode(two_mode_model):
    silent(rom.steady, two_mode_model, (0.98, 1.65), FORCE)
    silent(rom.steady, two_mode_model, (0.98, 9.9), (FORCE[0], {}))  # mode B is at rest
    with pytest.warns(rom.ValidityWarning, match="frequency is far from mode B: 9.9 .*give 1.576"):
        rom.steady(two_mode_model, (0.98, 9.9), FORCE)
    with pytest.warns(
        rom.ValidityWarning, match="frequency is far from mode A: 1.6 rad/s is 1.6 "
    ):
        rom.response_curve(two_mode_model, (0.98, 1.75), FORCE, "frequency_A", (0.95, 1.6))


def test_a_steady_state_without_a_table_reports_the_same():
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    silent(rom.steady_state, reduced, LAW, [0.98], [{0: 0.15}])
    with pytest.warns(rom.ValidityWarning) as issued:
        rom.steady_state(reduced, LAW, [1.6], [{0: 0.15}])
    first, second = [str(each.message) for each in issued]
    assert first.startswith("frequency is far from mode A: 1.6 rad/s is 1.6 times")
    assert second.startswith("friction does not act: ")
    assert {each.filename for each in issued} == {__file__}


@pytest.mark.parametrize("way", ["set_inputs", "do_step", "run", "trace"])
def test_a_component_warns_once_of_a_frequency_far_from_its_mode(two_mode_model, way):
    component = silent(Component, two_mode_model)

    def take(frequency):
        if way == "set_inputs":
            component.set_inputs(frequency_A=frequency)
        elif way == "do_step":
            rate = frequency - 1.0
            component.set_inputs(frequency_A=1.0, frequency_rate_A=rate)
            component.do_step(component.time, 1.0)
        else:
            named = {"frequency_A": frequency, "frequency_B": 1.7}
            row = np.array([[named.get(name, 0.0) for name in component.input_names]])
            list(getattr(component, way)(np.ones(1), row))

    silent(take, 1.3)
    with pytest.warns(
        rom.ValidityWarning, match="^frequency_A is far from mode A: 1.6 "
    ) as issued:
        take(1.6)
    assert [warning.filename for warning in issued] == [__file__]
    silent(take, 1.65)


# Carriers


def test_carriers_far_from_their_mode_are_reported_and_refused():
    reduced = silent(rom.reduce, rom.two_mass(), carrier=(0.98, 2.5))
    silent(rom.tabulate, reduced, LAW, (4.0, 2.0), tolerance=0.1)
    with pytest.warns(
        rom.ValidityWarning, match="carrier is far from mode B: 10.2 rad/s is 6 times"
    ) as issued:
        model = two_mass_table((0.98, 10.2), warned=True)
    with pytest.warns(rom.ValidityWarning, match="carrier is far from mode B"):
        Component(model)
    refused = r"^carrier: must be 1\.06 to 17 rad/s, because .* at 1\.7 rad/s; got 0\.26"
    with pytest.raises(rom.SlipmodeError, match=refused):
        rom.reduce(rom.two_mass(), carrier=(0.98, 0.26))
    with pytest.raises(rom.SlipmodeError, match=refused):
        rom.tabulate(rom.reduce(rom.two_mass()).at_carrier((0.98, 0.26)), LAW, (4.0, 2.0))
    assert issued[0].filename == __file__


UNFORCED = (
    ("amplitude = [[0, 0.0], [200, 0.0], [200, 0.25]] ", "amplitude = 0.0 "),
    ("[run]", "[initial]\nB = [0.5, 0.0]\n\n[run]"),
)


def test_a_scene_reports_the_carrier_of_an_unforced_mode():
    assert warned_by(plan_of("two-mode", *UNFORCED)) == []
    plan = plan_of("two-mode", *UNFORCED, ("frequency = 1.65 ", "frequency = 10.2 "))
    assert any(
        line.startswith(
            "forcing.B.frequency is far from mode B: 10.2 rad/s is 6 times the natural "
        )
        for line in warned_by(plan)
    )
    with pytest.raises(rom.SlipmodeError, match=r"forcing\.B\.frequency: must be 1\.06 to 17"):
        plan_of("two-mode", *UNFORCED, ("frequency = 1.65 ", "frequency = 17.5 "))


# Frequencies of the modes


def test_frequencies_of_modes_are_reported_that_no_structure_has():
    assert mode_frequency_findings("AB", 2 * pi * np.array([1.1e-3, 0.9e6])) == []
    low, high = mode_frequency_findings("AB", 2 * pi * np.array([0.9e-3, 1.1e6]))
    assert (low.subject, high.subject) == ("mode A", "mode B")
    assert low.reason.startswith("0.0009 Hz is outside 0.001 to 1e+06 Hz. Check whether mass and ")


def swapped(scale=1e6):
    """Matrices of the two masses at 160 and 270 Hz, with mass and stiffness swapped."""
    given = rom.two_mass()
    return rom.Structure(scale * given.stiffness, given.mass, 0.0, contact=np.eye(4)[:, 2:])


def test_swapped_matrices_are_reported_by_python():
    silent(rom.reduce, rom.two_mass())
    with pytest.warns(
        rom.ValidityWarning, match="has an implausible frequency: .* swapped"
    ) as issued:
        rom.reduce(swapped())
    assert {each.filename for each in issued} == {__file__}
    slow = rom.reduce(rom.two_mass(k1=1e-5), modes=(0,), warned=False)
    model = rom.tabulate(slow, LAW, (4e5,), tolerance=0.1, warned=False)
    with pytest.warns(
        rom.ValidityWarning, match="mode A has an implausible frequency: 0.000503 Hz"
    ):
        Component(model)


@pytest.mark.parametrize("table", ["whole", "none"])
def test_swapped_matrices_are_reported_by_scenes(table):
    stiff = (('model = "two-mass"', 'model = "two-mass"\nk1 = 1e-5'), ("0.9825 ", "3.1e-3 "))
    plan = plan_of(
        "one-mode",
        *stiff,
        ("duration = 800.0", "duration = 2e5"),
        ("step = 1.0", "step = 1e3"),
        ("window = [750.0, 800.0]", "window = [1.8e5, 2e5]"),
        appended=f'\n[model]\ntable = "{table}"\n',
    )
    assert any(
        line.startswith("mode A has an implausible frequency: 0.000503 Hz")
        for line in warned_by(plan)
    )


# Friction limits


LIMIT = "limit = 2.0 "


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        ("limit = 0.5", None),
        ("limit = 0.004", "friction hardly acts: the limit of contact "),
        ("limit = 1e9", "friction does not act: no contact slips or opens. "),
        ("limit = 0.0", "friction is zero: the friction limit is 0 at all contacts"),
        ("limit = [0.0, 2.0]", "friction is zero: the friction limit is 0 at contact 0"),
    ],
)
def test_scenes_report_implausible_limits(limit, words):
    found = warned_by(plan_of("two-mode", (LIMIT, limit)))
    assert [line for line in found if line.startswith("friction ")] == [
        line for line in found if words and line.startswith(words)
    ]
    assert bool(words) == any(line.startswith("friction ") for line in found)


def test_a_scene_without_a_table_reports_no_friction():
    integrated = ("formulation =", 'table = "none"\nformulation =')
    assert warned_by(plan_of("two-mode", integrated)) == []
    (line,) = warned_by(plan_of("two-mode", integrated, (LIMIT, "limit = 0.0 ")))
    assert line.startswith("friction is zero: ")


def test_python_reports_friction_that_does_nothing_at_the_forces():
    model = silent(two_mass_table, warned=True)
    silent(rom.steady, model, (0.98, 1.65), FORCE)
    with pytest.warns(rom.ValidityWarning, match="friction does not act: ") as issued:
        a = rom.steady(model, (0.98, 1.65), ({0: 0.001}, {1: 0.001}))
    assert issued[0].filename == __file__
    factor = float(str(issued[0].message).split("contacts slip from ")[1].split()[0])
    reduced = model.reduced
    elastic = 2.0 * np.abs(a) @ np.abs(reduced.coupling)
    assert factor == pytest.approx(2.0 / elastic.max(), rel=1e-2)


@pytest.mark.parametrize(("limit", "nothing"), [(4.0, False), (4e3, True)])
def test_tanh_contacts_that_creep_below_their_limit_have_friction(limit, nothing):
    """At a limit of 4 N, creep loses half as much energy as structural damping does."""
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    found = friction_findings(reduced, rom.Tanh(limit, 0.02), np.array([0.9]))
    assert [each.choice for each in found] == (["does not act"] if nothing else [])


def test_python_reports_a_table_in_which_friction_does_nothing():
    with pytest.warns(rom.ValidityWarning, match="friction does not act: "):
        model = two_mass_table(law=rom.Coulomb(2e3), warned=True)
    with pytest.warns(rom.ValidityWarning, match="friction does not act: "):
        Component(model)


@pytest.mark.parametrize(("part", "words"), [(0.011, None), (0.009, "friction hardly acts: ")])
def test_python_reports_limits_that_are_exceeded_a_hundred_times(part, words):
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    limit = part * 2.0 * 4.0 * float(np.abs(reduced.coupling).max())
    if words is None:
        silent(rom.tabulate, reduced, rom.Coulomb(limit), (4.0,), tolerance=0.1)
        return
    with pytest.warns(rom.ValidityWarning, match=words):
        rom.tabulate(reduced, rom.Coulomb(limit), (4.0,), tolerance=0.1)


def test_contacts_of_an_iwan_joint_that_slip_a_little_have_friction():
    """The first slider gives way at 1e-4 of the displacement of macro-slip."""
    law = rom.Iwan(force=2.0, stiffness=20.0, chi=-0.5, beta=1.0)
    reduced = rom.reduce(rom.two_mass(), modes=(0,), law=law)
    macro = 2.0 / float(np.abs(2.0 * reduced.coupling[0] * reduced.contacts.reference).max())
    silent(rom.tabulate, reduced, law, (0.01 * macro,), tolerance=0.1)
    with pytest.warns(rom.ValidityWarning, match="friction does not act: "):
        rom.tabulate(reduced, law, (1e-5 * macro,), tolerance=0.1)


@pytest.mark.parametrize("law", [rom.Coulomb(0.0), rom.Jenkins(0.0, 20.0)])
def test_python_reports_that_there_is_no_friction(law):
    elastic = None if isinstance(law, rom.Coulomb) else law
    reduced = rom.reduce(rom.two_mass(), modes=(0,), law=elastic)
    with pytest.warns(rom.ValidityWarning, match="friction is zero: .* all contacts"):
        rom.tabulate(reduced, law, (4.0,), tolerance=0.1)


# FMUs


def documentation(path):
    with zipfile.ZipFile(path) as archive:
        return archive.read("documentation/index.html").decode()


def test_the_documentation_of_an_fmu_lists_what_is_implausible(tmp_path):
    model = two_mass_table()
    path = silent(export, model, tmp_path / "fine.fmu", FORCE)
    assert "<h2>Warnings</h2>" not in documentation(path)
    with pytest.warns(rom.ValidityWarning) as issued:
        path = export(
            two_mass_table((0.98, 10.2), law=rom.Coulomb((0.0, 2.0))),
            tmp_path / "strained.fmu",
            FORCE,
            start={"frequency_A": 6.0},
        )
    page = documentation(path)
    for words in (
        "carrier is far from mode B: 10.2 rad/s",
        "frequency_A is far from mode A: 6 rad/s",
        "friction is zero: ",
    ):
        assert any(str(each.message).startswith(words) for each in issued)
        assert words in page


def test_the_fmu_of_a_scene_reports_its_forcing(tmp_path):
    text = load_scene("one-mode").text.replace("frequency = 0.9825 ", "frequency = 1.6 ")
    text = text.replace("amplitude = 0.15 ", "amplitude = 15.0 ")
    scene = parse_scene(text, ".")
    with pytest.warns(rom.ValidityWarning, match="^frequency_A is far from mode A: 1.6 rad/s"):
        export_fmu(scene, tmp_path / "far.fmu")


@pytest.mark.parametrize("fmi", VERSIONS)
def test_an_fmu_logs_once_that_a_frequency_is_far_from_its_mode(unzipped, fmi):
    with instance(unzipped[fmi], fmi) as made:
        made.start().step(0.0, 1.0)
        assert made.messages == []
        made.set(frequency_B=10.2)
        made.step(1.0, 1.0)
        made.set(frequency_B=10.3)
        made.step(2.0, 1.0)
        ((status, message),) = made.messages
        assert status == 1
        assert message == (
            "frequency_B: is far from its mode: 10.2 rad/s is 6 times the natural frequency of "
            "1.7 "
            "rad/s, outside 0.67 to 1.5 times; if a factor 2 pi was applied twice, give 1.623 "
            "rad/s"
        )
        made.set(frequency_B=0.27)
        with pytest.raises(fmpy.fmi1.FMICallException):
            made.step(3.0, 1.0)
        assert made.messages[-1][1].endswith("got 0.27; if that is in Hz, give 1.696 rad/s")
