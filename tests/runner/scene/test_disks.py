"""Scenes of disks and tones: engine orders, nodal diameters, files of one sector, refusals."""

import pickle

import numpy as np
import pytest
from cyclic.ring import save_sector
from runs import replaced

from slipmode import rom
from slipmode.runner import parse_scene, plan_scene, shipped_scenes

SCENES = shipped_scenes()
DISK, MISTUNED, PLATE = (
    SCENES[name].read_text(encoding="utf-8").replace('"square', f'"{SCENES[name].parent}/square')
    for name in ("bladed-disk", "mistuned-disk", "square-plate")
)
ORDER, SPEED, MODEL = "engine_order = 3", "[[0, 3780], [4, 4040]]", 'model = "lumped-disk"'
DRAWN = "standard_deviation = 0.02\nseed = 3\n"
FILE = 'matrices = "sector.npz"\nnext_contacts = [[0, 13, "z"]]\n'


@pytest.fixture(scope="module")
def sector(tmp_path_factory):
    """A folder with the lumped disk as a file of one sector: nodes 11 to 13, and next 21."""
    folder = tmp_path_factory.mktemp("sector")
    save_sector(folder, [[0.0], [0.0], [1.0], [0.0]])
    return folder


@pytest.mark.oracle
def test_the_forcing_frequency_is_the_engine_order_times_the_rotor_speed():
    frequency = parse_scene(DISK, ".").forcing["A"].frequency
    np.testing.assert_allclose(frequency.values, [3 * 63 * 2 * np.pi, 3 * 4040 / 60 * 2 * np.pi])
    text = SCENES["one-mode"].read_text(encoding="utf-8")
    text = replaced(text, ("frequency = 0.9825", "engine_order = 2\nrotor_speed = 4.6792"))
    (value,) = parse_scene(text, ".").forcing["A"].frequency.values
    assert value == pytest.approx(2 * 4.6792 / 60 * 2 * np.pi)


@pytest.mark.parametrize(
    ("order", "diameter", "words"),
    [
        (3, 3, "; engine order 3 excites it; it travels forward"),
        (27, 3, "engine order 27 = 3 + 1 x 24 sectors is aliased to it; it travels f"),
        (21, -3, "engine order 21 = -3 + 1 x 24 sectors is aliased to it; it travels b"),
    ],
)
def test_the_plan_says_which_wave_an_engine_order_excites(order, diameter, words):
    ends = f"[[0, {3780 * 3 / order}], [4, {4040 * 3 / order}]]"
    text = replaced(DISK, (ORDER, f"engine_order = {order}"), (SPEED, ends))
    plan = plan_scene(parse_scene(text, "."))
    (wave,) = (each for each in plan.decisions if each.subject == "wave A")
    assert wave.choice == f"nodal diameter {diameter}, mode 0"
    assert wave.reason.startswith("natural frequency 196.963 Hz")
    assert words in f"; {wave.reason}"


@pytest.mark.parametrize("sides", ["interface = [[11, 21]]", "left = [0]\nright = [3]"])
def test_a_file_of_one_sector_makes_the_same_disk(sides, sector):
    text = replaced(DISK, (MODEL, FILE + sides), ("dof = 2", 'node = 13\ndirection = "z"'))
    plan, expected = (plan_scene(parse_scene(each, sector)) for each in (text, DISK))
    sent = pickle.loads(pickle.dumps(plan.excited)).reduced  # as studies send it to workers
    np.testing.assert_allclose(sent.frequency, expected.excited.reduced.frequency, rtol=1e-12)
    assert plan.amplitude == pytest.approx(expected.amplitude)
    np.testing.assert_array_equal(plan.excited.force_patterns, expected.excited.force_patterns)


WRONG_WAVES = [
    ([(ORDER, "frequency = 197.0")], "forcing.A.rotor_speed: needs engine_order, which is"),
    ([("rotor_speed", "# rotor_speed")], "forcing.A.rotor_speed: is missing"),
    ([("A = 0", "A = 0\nnodal_diameters = [5]")], "forcing.A.engine_order = 3: excites nodal dia"),
    ([("A = 0", "A = 0\nnodal_diameters = [13]")], "modes.nodal_diameters: must be -12 to 12 of"),
    ([(MODEL, 'model = "two-mass"')], "structure.sectors: must be left out; it is for model"),
    ([("[run]", "[limits]\nscale = 2.0\n[run]")], "limits: must be left out with structu"),
    ([(SPEED, "300")], "forcing.A.engine_order * rotor_speed: must be 123 to 1960 Hz, because"),
    ([(MODEL, FILE + "interface = [[11, 99]]")], "structure.interface: nodes 11 and 99 have no"),
    ([(MODEL, FILE), ("sectors = 24", "")], "structure.next_contacts: needs matrices of one sect"),
]
WRONG_BLADES = [
    ([(DRAWN, "")], "mistuning.deviation: give exactly one of deviation and standard_dev"),
    ([("0.02", "0.3")], "mistuning.standard_deviation: must be 1e-06 to 0.2, got 0.3"),
    ([("[run]", "[modes]\nA = 0\n[run]")], "modes: must be left out, because all modes of a"),
    ([("[[elastic]]", "[[contact]]")], "contact: must be left out, because a mistuned disk "),
    ([(ORDER, "frequency = 200.0"), ("rotor_speed", "# ")], "forcing.A.engine_order: is missing"),
    ([("3780", "3000")], "forcing.A.engine_order * rotor_speed: must stay within 10 % of the mid"),
]
WRONG_TONES = [
    ([("[1, 2]", "[1, 1]")], "modes.A: must be one mode or several different ones"),
    ([("[1, 2]", "[1, 2]\nB = 3")], "forcing.B: is missing; with several modes on a tone each"),
    ([("[1, 2]", "[1, 2]\nB = [2, 3]")], "modes.B: must be other modes than A"),
    ([("[1, 2]", "[0, 1]")], "modes: tones: mode 0 at 710.89 rad/s and mode 1 at"),
    ([("[run]", "[initial]\nA = [0.0, 1e-5]\n[run]")], "initial: must be left out with several"),
    ([("[run]", "[limits]\nscale = 2.0\n[run]")], "limits: must be left out with several modes"),
    ([("[run]", '[model]\ntable = "none"\n[run]')], 'model.table: must be "whole" with several'),
    ([("[0, 268]", "[0, 200]")], "forcing.A.frequency: must stay within 10 % of 276.701 Hz"),
    ([("quadrature = 8", "quadrature = 36")], "forcing.A.quadrature: force: DOF 36 is out of"),
    ([("A = [1, 2]", "A = 1")], "forcing.A.quadrature: needs several modes on a tone"),
    ([("elastic = [10, 13]", "elastic = [36]")], "output.elastic: DOF 36 is out of range"),
]


@pytest.mark.parametrize(
    ("text", "changes", "line"),
    [(DISK, *each) for each in WRONG_WAVES]
    + [(MISTUNED, *each) for each in WRONG_BLADES]
    + [(PLATE, *each) for each in WRONG_TONES],
)
def test_refuses_in_one_line_that_names_the_key(text, changes, line, sector):
    with pytest.raises(rom.SlipmodeError) as refused:
        plan_scene(parse_scene(replaced(text, *changes), sector))
    (said,) = str(refused.value).splitlines()
    assert said.startswith(line)
