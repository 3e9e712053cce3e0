"""Scene files: what they say, and how they are refused."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runs import TANH_ON_BOTH_MODES

from slipmode.rom import SlipmodeError, Tanh, two_mass
from slipmode.runner import load_scene, parse_scene, shipped_scenes
from slipmode.runner.scene.script import Script
from slipmode.runner.scene.sections import Modes, Run, Window
from slipmode.runner.scene.structures import MatrixFile, TwoMass

pytestmark = pytest.mark.quick

SCENE = f"""
title = "Both modes"
[structure]
model = "two-mass"
damping = 0.01
{TANH_ON_BOTH_MODES}[forcing.A]
dof = 0
amplitude = 0.15
frequency = [[0, 0.96], [1000, 1.0]]
phase = 0.5
[forcing.B]
dof = 1
amplitude = [[0, 0.0], [200, 0.0], [200, 0.25]]
frequency = 1.65
[run]
duration = 1500.0
step = 1.0
[model]
tolerance = 1e-3
formulation = "consistent"
[[contact]]
window = [1400.0, 1450.0]
samples_per_period = 32
[output]
elastic = [0, 1]
[log]
mcap = true
rerun = false
"""

MINIMAL = """
[structure]
model = "two-mass"
[friction]
law = "coulomb"
limit = 2.0
[modes]
A = 0
[forcing.A]
dof = 0
amplitude = 0.15
frequency = 0.98
[run]
duration = 100
step = 1
"""


def changed(old, new, text=SCENE):
    assert old in text
    return text.replace(old, new, 1)


def refusal_of(text, folder="."):
    with pytest.raises(SlipmodeError) as refusal:
        parse_scene(text, folder)
    message = str(refusal.value)
    assert "\n" not in message
    return message


# What a scene says


def test_reads_every_section(tmp_path):
    scene = parse_scene(SCENE, tmp_path)
    assert scene.title == "Both modes"
    assert scene.structure == TwoMass({"beta": 0.01})
    assert scene.friction == Tanh(limit=2.0, alpha=0.02)
    assert scene.modes == Modes(A=0, B=1)
    assert scene.forcing["A"].amplitude == Script.constant(0.15)
    assert scene.forcing["A"].frequency == Script((0.0, 1000.0), (0.96, 1.0))
    assert scene.forcing["A"].phase == Script.constant(0.5)
    assert scene.forcing["B"].amplitude == Script((0.0, 200.0, 200.0), (0.0, 0.0, 0.25))
    assert scene.run == Run(duration=1500.0, step=1.0, tolerance=1e-6)
    assert (scene.model.tolerance, scene.model.formulation) == (1e-3, "consistent")
    assert scene.contact == (Window(1400.0, 1450.0, 32),)
    assert scene.output.elastic == (0, 1)
    assert (scene.log.mcap, scene.log.rerun) == (True, False)
    assert scene.text == SCENE


def test_defaults():
    scene = parse_scene(MINIMAL, ".")
    assert scene.structure.build().beta == two_mass().beta
    assert scene.modes.numbers == {"A": 0}
    assert scene.forcing["A"].phase == Script.constant(0.0)
    assert scene.run.tolerance == 1e-6
    assert scene.model.tolerance == 1e-3
    assert scene.model.formulation == "consistent"
    assert scene.model.amplitude is None
    assert scene.contact == ()
    assert scene.output.elastic == ()
    assert (scene.log.mcap, scene.log.rerun) == (True, True)


def test_two_mass_parameters_reach_the_structure():
    text = changed("damping = 0.01", "damping = 0.02\nk_p = -5\ncontact_mass = 0.1")
    structure = parse_scene(text, ".").structure.build()
    expected = two_mass(beta=0.02, k_p=-5.0, contact_mass=0.1)
    np.testing.assert_array_equal(structure.stiffness, expected.stiffness)
    np.testing.assert_array_equal(structure.mass, expected.mass)
    assert structure.beta == 0.02


def test_matrices_are_found_beside_the_scene(tmp_path):
    two_mass(beta=0.03).save(tmp_path / "beam.npz")
    scene = parse_scene(changed('model = "two-mass"', 'matrices = "beam.npz"'), tmp_path)
    assert scene.structure == MatrixFile(tmp_path / "beam.npz", damping=0.01)
    assert scene.structure.build().beta == 0.01
    stored = changed('model = "two-mass"\ndamping = 0.01', 'matrices = "beam.npz"')
    assert parse_scene(stored, tmp_path).structure.build().beta == 0.03


def test_forcing_by_dof_is_a_unit_vector_and_by_vector_is_itself():
    scene = parse_scene(changed("dof = 1", "vector = [0, 1, 0, -1]"), ".")
    np.testing.assert_array_equal(scene.forcing["A"].vector(4), [1, 0, 0, 0])
    np.testing.assert_array_equal(scene.forcing["B"].vector(4), [0, 1, 0, -1])


def test_forcing_that_does_not_fit_the_structure_is_refused():
    scene = parse_scene(changed("dof = 1", "vector = [0, 1]"), ".")
    with pytest.raises(SlipmodeError, match=r"forcing\.B\.vector: must have 4 numbers"):
        scene.forcing["B"].vector(4)
    scene = parse_scene(changed("dof = 0", "dof = 4"), ".")
    with pytest.raises(SlipmodeError, match=r"forcing\.A\.dof: must be 0 to 3, got 4"):
        scene.forcing["A"].vector(4)


def test_a_free_decay_needs_no_forcing():
    start = MINIMAL.index("[forcing.A]")
    text = MINIMAL[:start] + "[initial]\nA = [1.0, -0.5]\n" + MINIMAL[MINIMAL.index("[run]") :]
    scene = parse_scene(text, ".")
    assert scene.forcing == {}
    assert scene.initial == {"A": 1.0 - 0.5j}


def test_limits_may_differ_between_contacts_and_be_zero():
    assert parse_scene(changed("limit = 2.0", "limit = [0, 3]"), ".").friction.limit == (0.0, 3.0)


def test_windows_are_sorted_and_may_touch():
    more = "[[contact]]\nwindow = [1380, 1400]\n[output]"
    windows = parse_scene(changed("[output]", more), ".").contact
    assert [(window.start, window.end) for window in windows] == [(1380, 1400), (1400, 1450)]
    assert windows[0].samples_per_period == 64


def test_the_first_frequency_may_lie_above_the_second():
    text = changed("frequency = 1.65", "frequency = 0.5")
    assert parse_scene(text, ".").forcing["B"].frequency == Script.constant(0.5)


def test_frequencies_may_meet_after_the_run():
    text = changed("[1000, 1.0]]", "[1500, 1.0], [3000, 2.0]]")
    assert parse_scene(text, ".").forcing["A"].frequency.value(3000.0) == 2.0


# Refusals

REFUSED = [
    # unknown and missing keys
    ("phase = 0.5", "fase = 0.5", "forcing.A.fase: unknown key; allowed: amplitude, direction"),
    ("amplitude = 0.15", "amplitud = 1", "forcing.A.amplitud: unknown key; allowed: amplitude, "
     "direction, dof, engine_order, frequency, node, phase, rotor_speed, vector; did you mean "
     "amplitude?"),
    ("[log]", "[logs]", "logs: unknown key; allowed: aerodynamics, contact, contacts"),
    ("[forcing.B]", "[forcing.C]", "forcing.C: unknown key; allowed: A, B"),
    ("samples_per_period", "samples", "contact[0].samples: unknown key"),
    ("phase = 0.5", '"a\\nb" = 1', 'forcing.A."a\\nb": unknown key'),
    ("damping = 0.01", "beta = 0.01", "structure.beta: unknown key"),
    ("duration = 1500.0", "", "run.duration: is missing"),
    ("law =", "#", "friction.law: is missing"),
    ("A = 0\n", "", "modes.A: is missing"),
    ("frequency = 1.65", "", "forcing.B.frequency: is missing"),
    # wrong kinds
    ("amplitude = 0.15", "amplitude = true", "forcing.A.amplitude: must be a number (>= 0"),
    ("amplitude = 0.15", 'amplitude = "1"', 'forcing.A.amplitude: must be a number (>= 0'),
    ("dof = 1", "dof = 1.0", "forcing.B.dof: must be an integer (>= 0), got 1.0"),
    ("dof = 1", "dof = true", "forcing.B.dof: must be an integer (>= 0), got true"),
    ("dof = 1", f"dof = 0x{'f' * 5000}", "forcing.B.dof: must be an integer (>= 0), got a huge"),
    ("mcap = true", "mcap = 1", "log.mcap: must be true or false, got 1"),
    ('title = "Both modes"', "title = 3", "title: must be a string, got 3"),
    ("[run]", "[rum]", "rum: unknown key; allowed: aerodynamics, contact, contacts"),
    ("[[contact]]", "[contact]", "contact: must be an array of tables, [[contact]]"),
    ("elastic = [0, 1]", "elastic = 0", "output.elastic: must be a list of integers, got 0"),
    ("elastic = [0, 1]", "elastic = [0.5]", "output.elastic[0]: must be an integer (>= 0)"),
    # numbers
    ("limit = 2.0", "limit = nan", "friction.limit: must be >= 0, got NaN"),
    ("limit = 2.0", "limit = inf", "friction.limit: must be >= 0, got Infinity"),
    ("limit = 2.0", f"limit = 1{'0' * 400}", "friction.limit: must be >= 0, got 1000"),
    ("limit = 2.0", "limit = -2.0", "friction.limit: must be >= 0, got -2.0"),
    ("limit = 2.0", "limit = [2.0, -1]", "friction.limit[1]: must be >= 0, got -1"),
    ("limit = 2.0", "limit = []", "friction.limit: must be a list of numbers, got 0"),
    ("alpha = 0.02", "alpha = 0", "friction.alpha: must be > 0, got 0"),
    ("alpha = 0.02", "", "friction.alpha: is missing"),
    ('"tanh"', '"coulomb"', 'friction.alpha: needs law = "tanh"'),
    ('"tanh"', '"stick"', 'friction.law: must be one of "tanh", "coulomb"; got "stick"'),
    ("damping = 0.01", "damping = -1", "structure.damping: must be >= 0, got -1"),
    ("frequency = 1.65", "frequency = 0", "forcing.B.frequency: must be > 0, got 0"),
    ("frequency = 1.65", "frequency = -1.65", "forcing.B.frequency: must be > 0, got -1.65"),
    ("[1000, 1.0]", "[1000, 0]", "forcing.A.frequency[1]: must be > 0, got 0"),
    ("amplitude = 0.15", "amplitude = -1", "forcing.A.amplitude: must be >= 0 (use phase"),
    ("[200, 0.25]", "[200, -1]", "forcing.B.amplitude[2]: must be >= 0 (use phase"),
    # breakpoints
    ("[200, 0.25]", "[100, 0.25]", "forcing.B.amplitude: breakpoints must be sorted in time"),
    ("[200, 0.25]", "[200]", "forcing.B.amplitude[2]: must be a list of 2 numbers, got 1"),
    ("[200, 0.25]", "7", "forcing.B.amplitude[2]: must be a list of 2 numbers, got 7"),
    ("[200, 0.25]", "[200, true]", "forcing.B.amplitude[2][1]: must be a number"),
    ("phase = 0.5", "phase = []", "forcing.A.phase: must have at least one breakpoint"),
    # modes and forcing
    ("B = 1\n", "B = 0\n", "modes.B: must be another mode than A"),
    ("B = 1\n", "", "forcing.B: must be left out, because [modes] or model.file has only mo"),
    ("A = 0\n", "A = -1\n", "modes.A: must be an integer (>= 0), got -1"),
    ("dof = 1\n", "", "forcing.B.dof: give exactly one of dof and vector"),
    ("dof = 1", "dof = 1\nvector = [1.0]", "forcing.B.dof: give exactly one of dof and vector"),
    ("[log]", "[initial]\nA = [1]\n[log]", "initial.A: must be a list of 2 numbers, got 1"),
    # run, model, windows
    ("duration = 1500.0", "duration = 0", "run.duration: must be > 0, got 0"),
    ("step = 1.0", "step = -1.0", "run.step: must be > 0, got -1.0"),
    ("step = 1.0", "step = 1501", "run.step: must be at most run.duration = 1500, got 1501"),
    ("step = 1.0", "step = 1.0\ntolerance = 0", "run.tolerance: must be > 0, got 0"),
    ("tolerance = 1e-3", "tolerance = -1", "model.tolerance: must be > 0, got -1"),
    ('"consistent"', '"best"', 'model.formulation: must be one of "consistent", "paper"'),
    ("tolerance = 1e-3", "amplitude = [4.0]", "model.amplitude: must be a list of 2 numbers"),
    ("tolerance = 1e-3", "amplitude = [4.0, 0]", "model.amplitude[1]: must be > 0, got 0"),
    ("1450.0]", "1501.0]", "contact[0].window: must be [t0, t1] with t0 < t1 <= run.duration"),
    ("1450.0]", "1400.0]", "contact[0].window: must be [t0, t1] with t0 < t1"),
    ("[1400.0, 1450.0]", "[-1, 3]", "contact[0].window[0]: must be >= 0, got -1"),
    ("= 32", "= 4", "contact[0].samples_per_period: must be an integer (8 to 4096), got 4"),
    ("= 32", "= 5000", "contact[0].samples_per_period: must be an integer (8 to 4096), got 5000"),
    ("[output]", "[[contact]]\nwindow = [1, 1401]\n[output]", "contact.window: windows must not "
     "overlap, got [1, 1401] and [1400, 1450]"),
    ("[output]", "[[elastic]]\nwindow = [1, 1401]\n[output]", "elastic.window, contact.window: "
     "windows must not overlap, got [1, 1401] and [1400, 1450]"),
    ("[output]\nelastic = [0, 1]", "[[elastic]]\nwindow = [1, 2]", "elastic.window: needs "
     "output.elastic, the DOFs to reconstruct"),
    ("elastic = [0, 1]", "elastic = [1, 1]", "output.elastic: DOFs must be distinct"),
    # structure
    ('model = "two-mass"', "", "structure.model: give exactly one of model and matrices"),
    ('model = "two-mass"', 'model = "two-mass"\nmatrices = "m.npz"', "structure.model: give "
     "exactly one of model and matrices"),
    ('"two-mass"', '"beam"', 'structure.model: must be one of "two-mass", "lumped-disk"; '
     'got "beam"'),
    ("damping = 0.01", 'k1 = "stiff"', "structure.k1: must be a number (finite)"),
    ('model = "two-mass"', 'matrices = "m.npz"', "structure.matrices: no such file or folder"),
    ('model = "two-mass"', 'matrices = "m.npz"\nk1 = 2.0', "structure.k1: is a parameter of "
     'model = "two-mass"'),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), REFUSED)
def test_refuses_in_one_line_that_names_the_key(old, new, message):
    assert refusal_of(changed(old, new)).startswith(message)


@pytest.mark.parametrize(
    "frequency",
    [
        "1.65",
        "[[0, 1.0], [1500, 1.65]]",
        "[[0, 1.0], [1500, 2.0]]",
        "[[0, 1.0], [700, 1.0], [700, 2.0]]",
        "[[0, 1.0], [700, 1.65], [700, 1.0]]",
        "[[0, 1.65], [0, 1.0], [1, 1.0], [1, 1.7]]",
    ],
)
def test_refuses_frequencies_that_meet(frequency):
    message = refusal_of(changed("[[0, 0.96], [1000, 1.0]]", frequency))
    assert message.startswith("forcing.A.frequency, forcing.B.frequency: must differ")


@pytest.mark.parametrize("escape", [r"\u0001", r"\n", r"\t", r"\u007f", r"\u0085", r"\uffff"])
def test_refuses_text_with_control_characters_in_one_line(escape):
    line = re.search("^title = .*$", SCENE, re.MULTILINE)[0]
    message = refusal_of(changed(line, f'title = "Both{escape} modes"'))
    assert message.startswith("title: must be one line of letters, digits, punctuation and spaces")
    message = refusal_of(changed('model = "two-mass"', f'matrices = "a{escape}.npz"'))
    assert message.startswith("structure.matrices: must be one line")


@pytest.mark.parametrize(
    "title", ["Größe: μN = 2 N, α → 0", "振動 & <blade>", "é\u00a0\U0001f527"]
)
def test_titles_of_any_script_are_taken(title):
    line = re.search("^title = .*$", SCENE, re.MULTILINE)[0]
    assert parse_scene(changed(line, f'title = "{title}"'), ".").title == title


def test_refuses_a_scene_in_which_nothing_moves():
    start, end = MINIMAL.index("[forcing.A]"), MINIMAL.index("[run]")
    at_rest = MINIMAL[:start] + MINIMAL[end:]
    assert refusal_of(at_rest).startswith("forcing: no mode moves")
    assert refusal_of(at_rest + "[initial]\nA = [0, 0]").startswith("forcing: no mode moves")


def test_refuses_an_initial_amplitude_of_a_mode_that_is_not_there():
    assert refusal_of(MINIMAL + "[initial]\nB = [1, 0]").startswith("initial.B: must be left out")


def test_refuses_elastic_output_without_a_window():
    assert refusal_of(MINIMAL + "[output]\nelastic = [0]").startswith("output.elastic: ")


@pytest.mark.parametrize("key", ["structure", "run", "forcing", "log"])
def test_refuses_a_section_that_is_no_table(key):
    assert refusal_of(f"{key} = 3") == f"{key}: must be a table, got 3"


def test_refuses_a_forcing_that_is_no_table():
    text = "forcing.A = 3\n[modes]\nA = 0\n[run]\nduration = 1\nstep = 1\n"
    assert refusal_of(text) == "forcing.A: must be a table, got 3"


# Files


def test_shipped_scenes_load_and_their_structures_build():
    names = {"one-mode", "two-mode", "sweep", "force-step", "beating", "blade", "lap-joint"}
    names |= {"bladed-disk", "mistuned-disk"}
    assert set(shipped_scenes()) == names
    for name in names:
        scene = load_scene(name)
        assert (scene.name, scene.path) == (name, shipped_scenes()[name])
        assert scene.title
        structure = scene.structure.build()
        dofs = structure.n_dofs if scene.disk is None else structure.structure.free_dofs.size
        for forcing in scene.forcing.values():
            assert forcing.vector(dofs).any()


def test_the_shipped_sweep_passes_both_frictional_peaks():
    scene = load_scene("sweep")
    for mode, peak in {"A": 1.0 - 0.0175, "B": 1.7 - 0.046}.items():
        low, high = scene.forcing[mode].frequency.range(0.0, scene.run.duration)
        assert low < peak - 0.02
        assert peak + 0.02 < high


def test_loads_a_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(MINIMAL)
    scene = load_scene(path)
    assert (scene.name, scene.path, scene.text) == ("mine", path, MINIMAL)


def test_a_missing_file_lists_the_shipped_scenes():
    with pytest.raises(
        SlipmodeError, match=r"absent.toml': no such .*beating, blade, bladed-disk, force"
    ):
        load_scene("absent.toml")


@pytest.mark.parametrize("name", [MINIMAL, "x" * 5000, "nul\0"])
def test_refuses_names_that_no_file_can_have(name):
    with pytest.raises(SlipmodeError, match="no such scene file") as refusal:
        load_scene(name)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[run]\nduration == 3\n", "TOML syntax: .*line 2"),
        (b"title = '\xff'", "must be text in UTF-8"),
        (b"[run]\nlength = 1", "run.length: unknown key"),
        (b"a = " + b"[" * 5000, "TOML syntax"),
        (b"a = 1" + b"0" * 5000, "TOML syntax"),
    ],
)
def test_refusals_of_a_file_name_it_in_one_line(content, message, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_bytes(content)
    with pytest.raises(SlipmodeError, match=f"wrong.toml: {message}") as refusal:
        load_scene(path)
    assert "\n" not in str(refusal.value)


# Anything else

FRAGMENTS = st.sampled_from(
    ["[", "]", "=", "\n", '"', "-", "1e999", "nan", "true", "{}", "[[0, 1], [0, 2]]", "0", "'\\n'",
     "1979-05-27", "A", "B", "[forcing]", "[[run]]", "\x00", "0xffffffffffffffffffff"]
)  # fmt: skip


@given(st.data())
def test_no_mutation_of_a_scene_raises_anything_but_a_refusal(data):
    text = SCENE
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        end = data.draw(st.integers(start, min(len(text), start + 12)))
        text = text[:start] + data.draw(FRAGMENTS | st.text(max_size=5)) + text[end:]
    try:
        parse_scene(text, ".")
    except SlipmodeError as refusal:
        assert "\n" not in str(refusal)


VALUES = st.recursive(
    st.booleans() | st.integers() | st.floats() | st.just('"x"'),
    lambda values: st.lists(values, max_size=3),
    max_leaves=6,
)


@given(st.integers(0, SCENE.count(" = ") - 1), VALUES)
def test_no_value_of_a_key_raises_anything_but_a_refusal(number, value):
    lines = SCENE.splitlines()
    assignments = [i for i, line in enumerate(lines) if " = " in line]
    key = lines[assignments[number]].split(" = ")[0]
    shown = str(value).replace("True", "true").replace("False", "false").replace("'", "")
    lines[assignments[number]] = f"{key} = {shown}"
    try:
        parse_scene("\n".join(lines), ".")
    except SlipmodeError as refusal:
        assert "TOML syntax" not in str(refusal)
        assert "\n" not in str(refusal)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_scenes_may_begin_with_a_byte_order_mark(encoding, tmp_path):
    text = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
    (tmp_path / "bom.toml").write_text(text, encoding=encoding, newline="\r\n")
    assert load_scene(tmp_path / "bom.toml").run == load_scene("one-mode").run


@pytest.mark.parametrize(
    ("spelled", "usual"), [("hz", "Hz"), ("Hertz", "Hz"), ("RAD/SEC", "rad/s")]
)
def test_units_may_have_other_spellings(spelled, usual):
    scene = parse_scene(f'{MINIMAL}\n[units]\nfrequency = "{spelled}"\ndisplacement = "µm"\n', ".")
    assert (scene.units.frequency, scene.units.displacement) == (usual, "um")
