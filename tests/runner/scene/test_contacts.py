"""Elastic contacts in scenes: what [[contacts]] and [limits] say, how they are refused."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import SlipmodeError
from slipmode.runner import make_plan, parse_scene
from slipmode.runner.scene.contacts import check_scale, law_of, loaded_law
from slipmode.runner.scene.script import Script

pytestmark = pytest.mark.quick

START = """
[structure]
model = "two-mass"
[modes]
A = 0
[forcing.A]
dof = 0
amplitude = 0.15
frequency = 0.98
[run]
duration = 100
step = 1
[[contact]]
window = [90, 95]
"""
JENKINS = """
[[contacts]]
law = "jenkins"
limit = [2.0, 1.0]
stiffness = 30.0
"""
FRICTIONAL = """
[[contacts]]
law = "frictional"
mu = 0.5
preload = 1.0
tangential_stiffness = 20.0
normal_stiffness = 30.0
"""
COULOMB = """
[friction]
law = "coulomb"
limit = 2.0
"""


def law(text):
    return law_of(parse_scene(START + text, "."), 2)


def refusal_of(text):
    with pytest.raises(SlipmodeError) as refusal:
        make_plan(parse_scene(START + text, "."))
    message = str(refusal.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (JENKINS, rom.Jenkins((2.0, 1.0), 30.0)),
        (FRICTIONAL, rom.FrictionalContact(0.5, 1.0, 20.0, 30.0)),
        (
            '[[contacts]]\nlaw = "iwan"\nforce = 2\nstiffness = 30\nchi = -0.5\nbeta = 0.1',
            rom.Iwan(2.0, 30.0, -0.5, 0.1),
        ),
        (
            '[[contacts]]\nlaw = "sliders"\nlimit = [1, 2]\nstiffness = [3, 4]\ncontacts = [0, 1]',
            rom.Contacts([(rom.Sliders((1.0, 2.0), (3.0, 4.0)), (0, 1))]),
        ),
    ],
)
def test_laws_are_those_of_python(text, expected):
    assert law(text) == expected


def test_groups_have_their_laws_on_their_contact_dofs():
    first = JENKINS.replace("[2.0, 1.0]", "2.0") + "contacts = [1]\n"
    second = JENKINS.replace("[2.0, 1.0]", "3.0") + "contacts = [0]\n"
    expected = [(rom.Jenkins(2.0, 30.0), (1,)), (rom.Jenkins(3.0, 30.0), (0,))]
    assert law(first + second) == rom.Contacts(expected)
    np.testing.assert_array_equal(law(first + second).elements(2).limit, [3.0, 2.0])


def test_limits_are_scripted():
    scene = parse_scene(START + JENKINS + "[limits]\nscale = [[0, 1.0], [50, 0.5]]", ".")
    assert scene.limit_scale == Script((0.0, 50.0), (1.0, 0.5))
    assert parse_scene(START + JENKINS, ".").limit_scale is None


PRESSED = FRICTIONAL.replace("preload = 1.0", "preload = 0.0") + "[preload]\n"
REFUSED = [
    ("", "friction: is missing; give [friction] or [[contacts]]"),
    (JENKINS + COULOMB, 'contacts: are elastic and [friction] is rigid; give one of them. law'),
    (COULOMB.replace("coulomb", "jenkins"), "friction.law: is an elastic law; use a group [["),
    (JENKINS.replace("jenkins", "coulomb"), "contacts[0].law: is a rigid law and goes in [fri"),
    (JENKINS.replace("jenkins", "spring"), 'contacts[0].law: must be one of "jenkins", "iwan", "'),
    (JENKINS.replace("limit", "limits", 1), "contacts[0].limits: unknown key; allowed: beta, chi"),
    (JENKINS + "window = [1, 2]", "contacts[0].window: unknown key; allowed: beta, chi, contacts"),
    (JENKINS + "mu = 1", 'contacts[0].mu: is not a parameter of law = "jenkins"; it has lim'),
    (JENKINS.replace("stiffness = 30.0", ""), "contacts[0].stiffness: is missing"),
    (JENKINS.replace("30.0", "0"), "contacts[0].stiffness: must be > 0, got 0"),
    (JENKINS.replace("2.0", "-2.0"), "contacts[0].limit[0]: must be >= 0, got -2.0"),
    (JENKINS.replace("2.0", "nan"), "contacts[0].limit[0]: must be >= 0, got NaN"),
    (JENKINS.replace("1.0]", "1.0, 3.0]"), "contacts[0].limit: must be one number or 2 numbers"),
    (JENKINS + "contacts = [0]", "contacts[0].limit: must be one number or 1 numbers"),
    (JENKINS.replace("[2.0, 1.0]", "2") + "contacts = [0]", "contacts: every contact DOF, 0 to 1"),
    (JENKINS + "contacts = [0, 0]", "contacts: every contact DOF, 0 to 1, must be in one group"),
    (JENKINS + "contacts = [-1, 0]", "contacts[0].contacts[0]: must be an integer (>= 0), got -1"),
    (JENKINS + JENKINS, "contacts[0].contacts: is missing; each of several groups needs"),
    (FRICTIONAL.replace("0.5", "-0.5"), "contacts[0].mu: must be >= 0, got -0.5"),
    (FRICTIONAL.replace("= 1.0", "= -1"), "contacts[0].preload: must be >= 0, got -1"),
    (FRICTIONAL.replace("30.0", "0.0"), "contacts[0].normal_stiffness: must be > 0, got 0.0"),
    (FRICTIONAL + "gap = 0.1", "contacts[0].gap: must be 0 where preload > 0"),
    (FRICTIONAL + "tangents = 3", "contacts[0].tangents: must be 1 or 2, got 3"),
    (FRICTIONAL + "tangents = 2", "contacts[0].contacts: a frictional contact has 3 DOFs"),
    (FRICTIONAL.replace("preload = 1.0", "preload = 0.0\ngap = 0.1"), "gap: all contacts"),
    (FRICTIONAL.replace("0.5", "nan"), "contacts[0].mu: must be >= 0, got NaN"),
    (FRICTIONAL + "contacts = [1]", "contacts[0].contacts: a frictional contact has 2 DOFs"),
    (FRICTIONAL + "contacts = [1, 1]", "contacts: every contact DOF, 0 to 1, must be in one grou"),
    (JENKINS + '[model]\nformulation = "paper"', 'model.formulation: must be "consistent" with'),
    (JENKINS + "[limits]\nscale = 0", "limits.scale: must be > 0, got 0"),
    (JENKINS + "[limits]\nscale = [[0, 1], [9, -1]]", "limits.scale[1]: must be > 0, got -1"),
    (JENKINS + "[limits]\nscales = 1", "limits.scales: unknown key; allowed: scale"),
    (COULOMB.replace("coulomb", "tanh") + "alpha = 1\n[limits]\nscale = 2", "limits.scale: the"),
    (COULOMB + "[preload]\ndof = 3\nforce = 1", "preload: must be left out, because the contacts"),
    (JENKINS + "[preload]\ndof = 3\nforce = 1", "preload: must be left out, because the contacts"),
    (PRESSED + "", "preload.dof: give exactly one of dof and vector"),
    (PRESSED + "dof = 3\nvector = [1]", "preload.dof: give exactly one of dof and vector"),
    (PRESSED + "dof = 3", "preload.force: is missing"),
    (PRESSED + "dof = 3\nforce = nan", "preload.force: must be finite, got NaN"),
    (PRESSED + "dof = -3\nforce = 1", "preload.dof: must be an integer (>= 0), got -3"),
    (PRESSED + "dof = 4\nforce = 1", "preload.dof: must be 0 to 3, got 4"),
    (PRESSED + "dof = [3, 3]\nforce = 1", "preload.dof: must be one DOF or several different"),
    (PRESSED + "dof = []\nforce = 1", "preload.dof: must be one DOF or several different ones"),
    (PRESSED + "dof = [2, 3]\nforce = [1]", "preload.force: must be one number or 2 numbers"),
    (PRESSED + "vector = [0, 1]", "preload.vector: must have 4 numbers, one per DOF, got 2"),
    (PRESSED + "vector = [0, 1, 2, 3]\nforce = 1", "preload.force: must be left out with vector,"),
    (PRESSED + 'vector = "none.npy"', "preload.vector: no such file or folder: 'none.npy'"),
    (PRESSED + 'vector = "pyproject.toml"', "preload.vector: must be an .npy file of one number"),
    (PRESSED + "dof = 3\nforce = -1", "preload: all contacts are open under this force; at least"),
    (PRESSED + "dof = 3\nforces = 1", "preload.forces: unknown key; allowed: dof, force, vector"),
    ("[[contact]]\nlaw = 3\n" + JENKINS, "contact[1].law: unknown key; allowed: samples_per_peri"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_refuses_in_one_line_that_names_the_key(text, message):
    assert refusal_of(text).startswith(message)


def test_refuses_contacts_that_are_no_tables():
    with pytest.raises(SlipmodeError, match="contacts: must be an array of tables"):
        parse_scene("contacts = 3\n" + START, ".")


def test_a_key_of_the_other_section_is_shown_its_place():
    message = refusal_of(JENKINS + "window = [1, 2]")
    assert message.endswith("windows of contact motion are [[contact]]")
    assert refusal_of("[[contact]]\nlaw = 3\n" + JENKINS).endswith("contacts are in [[contacts]]")


def test_a_gap_does_not_scale():
    groups = (FRICTIONAL + "contacts = [0, 1]") + (
        FRICTIONAL.replace("preload = 1.0", "preload = [0.0, 0.0]\ngap = [0.0, 0.1]")
        + "contacts = [2, 3, 4, 5]"
    )
    scene = parse_scene(START + groups + "\n[limits]\nscale = 2", ".")
    with pytest.raises(SlipmodeError, match=r"limits\.scale: .* contacts\[1\]\.gap is a length"):
        check_scale(scene, law_of(scene, 6), 6)


def test_a_static_force_makes_preloads_and_gaps(tmp_path):
    """Those of rom.preload; the plan says what it found."""
    scene = parse_scene(START + PRESSED + "dof = [3, 0]\nforce = [2.0, 0.5]", ".")
    plan = make_plan(scene)
    force = {3: 2.0, 0: 0.5}
    with pytest.warns(rom.ValidityWarning, match="loads contacts tangentially"):
        found = rom.preload(plan.structure, rom.FrictionalContact(0.5, 0.0, 20.0, 30.0), force)
    assert plan.excited.law == found.law
    assert found.law.preload[0] > 0.5
    said = {decision.subject: decision for decision in plan.decisions}
    assert said["contacts at rest"].choice == "1 stuck"
    assert said["contacts at rest"].reason.startswith("normal forces 0.8")
    assert said["static force"].level == "warning"
    np.save(tmp_path / "static.npy", np.array([0.5, 0.0, 0.0, 2.0]))
    for vector in ("[0.5, 0, 0, 2]", '"static.npy"'):
        same = parse_scene(START + PRESSED + f"vector = {vector}", tmp_path)
        assert make_plan(same).excited.law == found.law


def test_contacts_that_a_static_force_opens_do_not_scale():
    law = 'law = "frictional"\nmu = 0.5\npreload = 1.0\ntangential_stiffness = 2.0\n'
    law += "normal_stiffness = 2.0\n"
    sides = "".join(f"[[contacts]]\n{law}contacts = {c}\n" for c in ([0, 1], [2, 3]))
    text = START + sides + "[limits]\nscale = 2\n[preload]\ndof = 3\nforce = -9"
    body = rom.Structure(np.eye(6), np.eye(6) + 0.1, contact=np.eye(6)[:, :4])
    scene = parse_scene(text, ".")
    _, found = loaded_law(scene, body)
    assert set(found.state) == {0, 2}
    with pytest.raises(SlipmodeError, match=r"limits\.scale: .* that \[preload\] opens is a"):
        check_scale(scene, found.law, 4)


def test_the_plan_tells_of_skewed_directions(tmp_path, recwarn):
    given, W = rom.two_mass(), np.eye(4)[:, 2:]
    for slant in (0.0, 0.5):
        W[2, 1] = slant
        body = rom.Structure(given.mass, given.stiffness, 0.01, contact=W)
        body.save(tmp_path / "body.npz")
        text = START.replace('model = "two-mass"', 'matrices = "body.npz"')
        plan = make_plan(parse_scene(text + FRICTIONAL, tmp_path))
        told = [d for d in plan.decisions if d.choice == "have skewed directions"]
        assert [d.level for d in told] == ["warning"] * (slant > 0.0)
    assert not recwarn.list
