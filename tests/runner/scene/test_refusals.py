"""What scenes are refused for: one line that begins with the key, what is allowed, what to do."""

import numpy as np
import pytest
import scipy.io
from runs import TANH_ON_BOTH_MODES

from slipmode import rom
from slipmode.rom import SlipmodeError
from slipmode.runner import load_scene, make_plan, parse_scene

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
FRICTION = SCENE[SCENE.index("[friction]") : SCENE.index("[modes]")]
JENKINS = '[[contacts]]\nlaw = "jenkins"\nlimit = [2.0, 1.0]\nstiffness = 30.0\n'
FRICTIONAL = (
    '[[contacts]]\nlaw = "frictional"\nmu = 0.5\npreload = 1.0\n'
    "tangential_stiffness = 20.0\nnormal_stiffness = 30.0\n"
)
PRESSED = FRICTIONAL.replace("preload = 1.0", "preload = 0.0") + "[preload]\n"
ELASTIC = SCENE.replace(FRICTION, JENKINS)
CUBIC = "[nonlinear_stiffness]\nAAAA = 0.1\n"
COULOMB = '[friction]\nlaw = "coulomb"\nlimit = 2.0\n'


def in_scene(old, new):
    assert old in SCENE
    return SCENE.replace(old, new, 1)


def with_contacts(text):
    return SCENE.replace(FRICTION, f"{text}\n")


CHANGED = [
    # unknown and missing keys
    ("phase = 0.5", "fase = 0.5", "forcing.A.fase: unknown key; allowed: amplitude, direction"),
    ("phase = 0.5", '"a\\nb" = 1', 'forcing.A."a\\nb": unknown key'),
    ("duration = 1500.0", "", "run.duration: is missing"),
    (FRICTION, "", "friction: is missing; give [friction] or [[contacts]]"),
    # kinds
    ("amplitude = 0.15", "amplitude = true", "forcing.A.amplitude: must be a number (>= 0"),
    ("dof = 1", f"dof = 0x{'f' * 5000}", "forcing.B.dof: must be an integer (>= 0), got a huge"),
    ('title = "Both', 'title = "Both\\u0001', "title: must be one line of letters, digits, punct"),
    # ranges
    ("limit = 2.0", "limit = nan", "friction.limit: must be >= 0, got NaN"),
    ('"tanh"', '"coulomb"', 'friction.alpha: needs law = "tanh"'),
    ('"tanh"', '"stick"', 'friction.law: must be one of "tanh", "coulomb"; got "stick"'),
    ("amplitude = 0.15", "amplitude = -1", "forcing.A.amplitude: must be >= 0 (use phase"),
    # breakpoints
    ("[200, 0.25]", "[100, 0.25]", "forcing.B.amplitude: breakpoints must be sorted in time"),
    ("[200, 0.25]", "[200, 1], [200, 2]", "forcing.B.amplitude: must have at most two break"),
    # modes and forces
    ("B = 1\n", "B = 0\n", "modes.B: must be another mode than A"),
    ("B = 1\n", "", "forcing.B: must be left out, because [modes] or model.file has only mo"),
    ("B = 1\n", "B = 1\nratio = 3\n", "forcing.B: must be left out, because mode B follows"),
    ("B = 1\n", "B = 1\nratio = 3.3\n", "modes: ratio: must be a ratio of integers up to 9"),
    ("dof = 1", "dof = 0", "forcing.B: this force does no work on mode B"),
    ("dof = 1\n", "", "forcing.B.dof: give exactly one of dof and vector"),
    ("dof = 1", "vector = [1.0]", "forcing.B.vector: must have 4 numbers"),
    ("[[0, 0.96], [1000, 1.0]]", "[[0, 1.0], [1500, 2.0]]",
     "forcing.A.frequency, forcing.B.frequency: must differ"),
    ("[log]", "[initial]\nA = [1]\n[log]", "initial.A: must be a list of 2 numbers, got 1"),
    # run, model, windows
    ("step = 1.0", "step = 1501", "run.step: must be at most run.duration = 1500, got 1501"),
    ('"consistent"', '"best"', 'model.formulation: must be one of "consistent", "paper"'),
    ("[1400.0, 1450.0]", "[1400.0, 1501]", "contact[0].window: must be [t0, t1] with t0 < t1 <= "),
    ("[output]", "[[elastic]]\nwindow = [1, 1401]\n[output]", "elastic.window, contact.window: "
     "windows must not overlap, got [1, 1401] and [1400, 1450]"),
    # a scene without a table
    ("tolerance = 1e-3", 'table = "none"\nbudget = 3.0', "model.budget: must be left out"),
    ('tolerance = 1e-3\nformulation = "consistent"', 'table = "none"\nformulation = "paper"',
     "model.table: "),
    # units and structure
    ("[log]", '[units]\nfrequency = "rpm"\n[log]', "units.frequency: must be "),
    ('"two-mass"', '"beam"', 'structure.model: must be one of "two-mass", "lumped-disk"; '),
]  # fmt: skip
CONTACTS = [
    (JENKINS + COULOMB, "contacts: are elastic and [friction] is rigid; give one of them. law"),
    (JENKINS.replace("jenkins", "coulomb"), "contacts[0].law: is a rigid law and goes in [fri"),
    (JENKINS + "mu = 1", 'contacts[0].mu: is not a parameter of law = "jenkins"; it has lim'),
    (JENKINS.replace("2.0", "-2.0"), "contacts[0].limit[0]: must be >= 0, got -2.0"),
    (JENKINS.replace("1.0]", "1.0, 3.0]"), "contacts[0].limit: must be one number or 2 numbers"),
    (JENKINS + JENKINS, "contacts[0].contacts: is missing; each of several groups needs"),
    (FRICTIONAL + "gap = 0.1", "contacts[0].gap: must be 0 where preload > 0"),
    (FRICTIONAL + "contacts = [1]", "contacts[0].contacts: a frictional contact has 2 DOFs"),
    (FRICTIONAL.replace("preload = 1.0", "preload = 0.0\ngap = 0.1"), "gap: all contacts"),
    (FRICTION + "[limits]\nscale = 2", "limits.scale: the"),
    (COULOMB + "[preload]\ndof = 3\nforce = 1", "preload: must be left out, because the contacts"),
    (PRESSED + 'vector = "none.npy"', "preload.vector: no such file or folder: 'none.npy'"),
    (PRESSED + "dof = 3\nforce = -1", "preload: all contacts are open under this force; at least"),
]
TEXTS = [
    ("run = 3", "run: must be a table, got 3"),
    (SCENE[: SCENE.index("[forcing.A]")] + SCENE[SCENE.index("[run]") :], "forcing: no mode mov"),
    (ELASTIC.replace("tolerance = 1e-3", 'table = "none"') + "[limits]\nscale = 2", "model.table"),
    (ELASTIC.replace('"consistent"', '"paper"'), 'model.formulation: must be "consistent" with'),
    (SCENE + CUBIC + "ABBA = 1", "nonlinear_stiffness.ABBA: unknown key"),
    (SCENE + CUBIC.replace("0.1", "-0.1"), "amplitude: cubic coefficients soften mode A to insta"),
    (ELASTIC.replace("tolerance = 1e-3", 'table = "none"') + CUBIC, "model.table: must be"),
    (SCENE.replace("\nB = 1\n", "\n") + CUBIC + "BBBB = 1", "forcing.B: must be left out"),
]
REFUSED = [
    *((in_scene(old, new), message) for old, new, message in CHANGED),
    *((with_contacts(text), message) for text, message in CONTACTS),
    *TEXTS,
]


def refusal_of(text, folder="."):
    with pytest.raises(SlipmodeError) as refusal:
        make_plan(parse_scene(text, folder))
    (line,) = str(refusal.value).splitlines()
    return line


@pytest.mark.parametrize(("text", "message"), REFUSED, ids=[message for _, message in REFUSED])
def test_a_refusal_is_one_line_that_names_the_key(text, message):
    assert refusal_of(text).startswith(message)


def test_remedies_are_named():
    assert refusal_of(in_scene("amplitude = 0.15", "amplitud = 1")).endswith("mean amplitude?")
    line = refusal_of(with_contacts(JENKINS + "window = [1, 2]"))
    assert line.endswith("window is a key of [[contact]] and [[elastic]]")
    line = refusal_of(ELASTIC.replace("samples_per_period = 32", "law = 3"))
    assert line.endswith("law is a key of [friction] and [[contacts]]")


NODES = """
[structure]
matrices = "beam.npz"
contacts = [[31, "y"]]
rayleigh = [0.001, 0.05]
[[contacts]]
law = "jenkins"
limit = 50.0
stiffness = 200.0
[modes]
A = 0
[forcing.A]
node = 34
direction = "y"
amplitude = 0.02
frequency = 0.3
[run]
duration = 100.0
step = 10.0
[[elastic]]
window = [50.0, 60.0]
[output]
elastic = [0]
nodes = [[33, "y"]]
"""


@pytest.fixture(scope="module", name="folder")
def folder_of_matrices(tmp_path_factory):
    folder = tmp_path_factory.mktemp("matrices")
    stiffness = 2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
    stiffness[-1, -1] = 1.0
    labels = rom.Labels(np.arange(30, 35), np.full(5, 2))
    rom.Structure(np.eye(5), stiffness, contact=[0], labels=labels).save(folder / "beam.npz")
    K = {"K1": stiffness, "K2": 4.0 * stiffness}
    scipy.io.savemat(folder / "w.mat", K | {"M": np.eye(5), "contact": [[0]]})
    return folder


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("node = 34", "node = 99", "forcing.A: node 99: is not in the structure"),
        ('direction = "y"', 'direction = "z"', "node 34: has no free direction z, allowed: y"),
        ('[[33, "y"]]', '[[30, "y"]]', "output.nodes: DOFs must differ from"),
        ('[[31, "y"]]', '[[7, "y"]]', "beam.npz: node 7: is not in the structure"),
        ('"beam.npz"\ncontacts = [[31, "y"]]', '"w.mat"', "w.mat"),
        ("[[contacts]]", "loss_factor = 0.02\n[[contacts]]", "one of rayleigh and loss_factor"),
    ],
)
def test_refusals_of_nodes_and_matrices_name_them(folder, old, new, message):
    assert old in NODES
    assert message in refusal_of(NODES.replace(old, new, 1), folder)


@pytest.mark.oracle
def test_nodes_and_names_of_matrices_lead_to_the_dofs_and_matrices(folder):
    """Read by SciPy and by the labels: the frequency of the stuck structure."""
    plan = make_plan(parse_scene(NODES, folder))
    assert plan.scene.output.elastic == (0, 3)
    np.testing.assert_array_equal(plan.excited.force_patterns, [[0, 0, 0, 0, 1.0]])
    stiffness = scipy.io.loadmat(folder / "w.mat")["K1"]
    for text, factor, dof in (
        (NODES, 1.0, 1),
        (
            NODES.replace('"beam.npz"\ncontacts = [[31, "y"]]', '"w.mat"\nstiffness_name = "K2"')
            .replace('node = 34\ndirection = "y"', "dof = 4")
            .replace("frequency = 0.3", "frequency = 0.6")
            .replace('nodes = [[33, "y"]]', ""),
            4.0,
            0,
        ),
    ):
        stuck = factor * stiffness
        stuck[dof, dof] += 200.0
        found = make_plan(parse_scene(text, folder)).excited.reduced.frequency
        assert found == pytest.approx([np.sqrt(np.linalg.eigvalsh(stuck)[0])], rel=1e-9)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[run]\nduration == 3\n", "TOML syntax: .*line 2"),
        (b"title = '\xff'", "must be text in UTF-8"),
        (b"[run]\nlength = 1", "run.length: unknown key"),
        (b"a = " + b"[" * 5000, "TOML syntax"),
    ],
)
def test_refusals_of_a_file_name_it_in_one_line(content, message, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_bytes(content)
    with pytest.raises(SlipmodeError, match=f"wrong.toml: {message}") as refusal:
        load_scene(path)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("name", ["absent.toml", SCENE, "x" * 5000, "nul\0"])
def test_a_name_of_no_file_lists_the_shipped_scenes(name):
    with pytest.raises(SlipmodeError, match=r"no such scene file.*beating, blade") as refusal:
        load_scene(name)
    assert "\n" not in str(refusal.value)
