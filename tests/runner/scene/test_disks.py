"""Scenes of bladed disks: engine orders, nodal diameters, files of one sector, refusals."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.__main__ import main
from slipmode.rom import Labels, SlipmodeError
from slipmode.runner import make_plan, parse_scene, shipped_scenes

DISK = shipped_scenes()["bladed-disk"].read_text(encoding="utf-8")
ORDER = "engine_order = 3"
RPM = 2.0 * np.pi / 60.0
TWO_WAVES = """
[forcing.B]
dof = 2
amplitude = 20.0
engine_order = 19
rotor_speed = 1957
"""


def changed(*changes, text=DISK):
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def planned(text, folder="."):
    return make_plan(parse_scene(text, folder))


def refusal(text, folder="."):
    with pytest.raises(SlipmodeError) as refused:
        planned(text, folder)
    (line,) = str(refused.value).splitlines()
    return line


def of(plan, subject):
    (found,) = (d for d in plan.decisions if d.subject == subject)
    return f"{found.choice}: {found.reason}"


def test_the_forcing_frequency_is_the_engine_order_times_the_rotor_speed():
    frequency = parse_scene(DISK, ".").forcing["A"].frequency
    np.testing.assert_allclose(frequency.values, 3 * RPM * np.array([3780.0, 4040.0]), rtol=1e-14)
    assert frequency.times == (0.0, 4.0)


def test_a_structure_without_sectors_has_engine_orders_too():
    text = changed(
        ("frequency = 0.9825", "engine_order = 2\nrotor_speed = 4.6792"),
        text=shipped_scenes()["one-mode"].read_text(encoding="utf-8"),
    )
    (value,) = parse_scene(text, ".").forcing["A"].frequency.values
    assert value == pytest.approx(2 * RPM * 4.6792)


@pytest.mark.parametrize(
    ("order", "speed", "diameter", "words"),
    [
        (3, "", 3, "; engine order 3 excites it; it travels forward"),
        (
            27,
            "0.1111111",
            3,
            "engine order 27 = 3 + 1 x 24 sectors is aliased to it; it travels f",
        ),
        (
            21,
            "0.1428571",
            -3,
            "engine order 21 = -3 + 1 x 24 sectors is aliased to it; it travels b",
        ),
    ],
)
def test_the_plan_says_which_wave_an_engine_order_excites(order, speed, diameter, words):
    factor = float(speed or 1.0)
    ends = f"[[0, {3780 * factor}], [4, {4040 * factor}]]"
    text = changed((ORDER, f"engine_order = {order}"), ("[[0, 3780], [4, 4040]]", ends))
    said = of(planned(text), "wave A")
    assert said.startswith(f"nodal diameter {diameter}, mode 0: natural frequency 196.963 Hz")
    assert words in said


@pytest.mark.slow
def test_two_engine_orders_excite_two_waves():
    text = changed(("A = 0", "A = 0\nB = 1")) + TWO_WAVES + "[model]\ntolerance = 0.01\n"
    plan = planned(text)
    assert of(plan, "wave A").startswith("nodal diameter 3, mode 0")
    assert of(plan, "wave B").startswith("nodal diameter -5, mode 1")
    assert plan.excited.reduced.frequency == pytest.approx(
        [2 * np.pi * 196.963, 2 * np.pi * 619.914], rel=1e-5
    )


def test_forces_on_several_dofs_do_the_work_of_their_pattern():
    """The model has the sizes of the shape alone; [0, -1, 1] would do no work by these."""
    plan = planned(changed(("dof = 2", "vector = [0.0, -1.0, 1.0]"), ("= 4.0  ", "= 20.0")))
    disk = rom.lumped_disk(24, 1e-5)
    wave = rom.travelling_wave(disk, rom.Jenkins(1.0, 5e4), 3)
    modal = abs(wave.modal_force([0.0, -1.0, 1.0]))
    assert plan.excited.modal_force == pytest.approx([modal], rel=1e-3)  # dampers couple modes


@pytest.fixture(scope="module")
def sector(tmp_path_factory):
    """The lumped disk as a file of one sector: DOFs 0 and 3 each have half a disk mass."""
    folder = tmp_path_factory.mktemp("sector")
    disk = rom.lumped_disk(24, 1e-5)
    mass = np.diag([0.6, 0.35, 0.25, 0.6])
    stiffness, tip = disk.stiffness.toarray(), np.array([[0.0], [0.0], [1.0], [0.0]])
    # nodes 11 to 13, and 21 of the next sector, which move along z
    labels = Labels(np.array([11, 12, 13, 21]), np.full(4, 3))
    # the file has it stored in the form of other programs
    np.savez(
        folder / "sector.npz", mass=mass, stiffness=stiffness, contact=tip, labels=labels.table
    )
    return folder


FILE = (
    'model = "lumped-disk"',
    'matrices = "sector.npz"\nnext_contacts = [[0, 13, "z"]]',
)


@pytest.mark.parametrize("sides", ["interface = [[11, 21]]", "left = [0]\nright = [3]"])
def test_a_file_of_one_sector_makes_the_same_disk(sides, sector):
    text = changed((FILE[0], f"{FILE[1]}\n{sides}"), ("dof = 2", 'node = 13\ndirection = "z"'))
    plan, expected = planned(text, sector), planned(DISK)
    np.testing.assert_allclose(
        plan.excited.reduced.frequency, expected.excited.reduced.frequency, rtol=1e-12
    )
    assert plan.amplitude == expected.amplitude
    np.testing.assert_array_equal(plan.excited.force_patterns, expected.excited.force_patterns)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ([(ORDER, "engine_order = 0")], "forcing.A.engine_order: must be an integer (> 0), got 0"),
        (
            [(ORDER, "frequency = 197.0")],
            "forcing.A.rotor_speed: needs engine_order, which is",
        ),
        ([(ORDER, f"{ORDER}\nfrequency = 197.0")], "forcing.A.frequency: must be left out; it is"),
        ([("rotor_speed", "# rotor_speed")], "forcing.A.rotor_speed: is missing"),
        (
            [("A = 0", "A = 0\nnodal_diameters = [5]")],
            "forcing.A.engine_order = 3: excites nodal diameter 3 of 24 sectors, but "
            "modes.nodal_diameters is 5 for mode A; engine orders 5, 29, ... excite 5",
        ),
        (
            [("A = 0", "A = 0\nnodal_diameters = [13]")],
            "modes.nodal_diameters: must be -12 to 12 of 24 sectors, got 13",
        ),
        (
            [("A = 0", "A = 0\nnodal_diameters = [3, 4]")],
            "modes.nodal_diameters: must be 1, one per mode",
        ),
        ([("A = 0", "A = 0\nB = 1")], "modes.nodal_diameters: is missing, and no engine order gi"),
        ([("A = 0", "A = 7")], "modes: must be 0 to 2, got 7; modes of a nodal"),
        ([("sectors = 24", "sectors = 2")], "structure.sectors: must be an integer (>= 3), got 2"),
        (
            [('model = "lumped-disk"', 'model = "two-mass"')],
            'structure.sectors: must be left out; it is for model = "lumped-disk" or',
        ),
        ([("dof = 2", "dof = 3")], "forcing.A.dof: must be 0 to 2, got 3"),
        ([("[run]", "[limits]\nscale = 2.0\n[run]")], "limits: must be left out with structu"),
        (
            [("[run]", '[model]\ntable = "none"\n[run]')],
            'model.table: must be "whole" with struct',
        ),
        (
            [
                ("[[contacts]]", "[friction]"),
                ('"jenkins"', '"coulomb"'),
                ("stiffness = 5.0e4", "#"),
            ],
            "friction: sectors need elastic contacts, [[contacts]]",
        ),
        (
            [("[[0, 3780], [4, 4040]]", "300")],
            "forcing.A.engine_order * rotor_speed: must be 123 to 1960 Hz, because mode A",
        ),
    ],
)
def test_refuses_in_one_line_that_names_the_key(changes, line):
    assert refusal(changed(*changes)).startswith(line)


@pytest.mark.parametrize(
    ("addition", "line"),
    [
        (
            "interface = [[11, 12, 13]]",
            "structure.interface[0]: must be a [left node, right node]",
        ),
        (
            "interface = [[11, 99]]",
            "structure.interface: nodes 11 and 99 have no direction in com",
        ),
        ("left = [0, 1]\nright = [3]", "structure: left, right: must be as many DOFs on either"),
        ("interface = [[11, 21]]\nleft = [0]", "structure.interface: give either left and right"),
    ],
)
def test_refuses_sectors_that_do_not_fit(addition, line, sector):
    assert refusal(changed((FILE[0], f"{FILE[1]}\n{addition}")), sector).startswith(line)


def test_equal_frequencies_are_refused():
    text = changed(("A = 0", "A = 0\nB = 0")) + TWO_WAVES.replace("19", "21")
    assert refusal(text).startswith("modes.B: must be another mode than A, or of another nodal")


def test_keys_of_sectors_need_sectors(sector):
    text = changed((FILE[0], FILE[1]), ("sectors = 24", ""))
    assert refusal(text, sector) == (
        "structure.next_contacts: needs matrices of one sector, and sectors"
    )
    assert refusal(changed(("sectors = 24", "left = [0]"))) == (
        "structure.left: needs matrices of one sector, and sectors"
    )


def test_what_needs_a_whole_structure_says_so(capsys):
    for command in ("modes", "design"):
        assert main([command, "bladed-disk"]) == 1
        line = capsys.readouterr().err
        assert line.startswith("slipmode: structure.sectors: this needs a whole structure")
