"""What scene files say: keys, defaults, laws, files, units; refusals are in test_refusals.py."""

import numpy as np
import pytest
from runs import changed

from slipmode import rom
from slipmode.rom import Tanh, two_mass
from slipmode.runner import load, load_scene, make_plan, parse_scene, run, shipped_scenes

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
"""
COULOMB = '[friction]\nlaw = "coulomb"\nlimit = 2.0\n'
JENKINS = '[[contacts]]\nlaw = "jenkins"\nlimit = {}\nstiffness = 30.0\n'
FRICTIONAL = (
    '[[contacts]]\nlaw = "frictional"\nmu = 0.5\npreload = {}\n'
    "tangential_stiffness = 20.0\nnormal_stiffness = 30.0\n"
)


def test_defaults():
    scene = parse_scene(START + COULOMB, ".")
    assert scene.structure.build().beta == two_mass().beta
    assert scene.forcing["A"].phase.values == (0.0,)
    assert (scene.run.tolerance, scene.model.tolerance) == (1e-6, 1e-3)
    assert (scene.model.formulation, scene.model.amplitude) == ("consistent", None)
    assert (scene.contact, scene.output.elastic, scene.limit_scale) == ((), (), None)
    assert (scene.log.mcap, scene.log.rerun) == (True, True)


@pytest.mark.oracle
def test_scripts_are_recorded_as_piecewise_linear_functions(tmp_path):
    """Right-continuous: NumPy's interpolation on each side of the jump."""
    force = "amplitude = [[50, 0.1], [200, 0.2], [200, 0.05], [300, 0.15]]"
    frequency = ("0.98", "[[0, 0.96], [600, 1.0]]")
    scene = changed(("amplitude = 0.15", force), frequency, ("[600.0, 700.0]", "[0, 1]"))
    forcing = load(run(scene, tmp_path).mcap)["/forcing"]
    t, force = forcing.time, forcing.column("A_force")
    before, after = t < 200.0, t >= 200.0
    expected = np.interp(t[before], [50.0, 200.0], [0.1, 0.2])
    np.testing.assert_allclose(force[before], expected, rtol=1e-12)
    expected = np.interp(t[after], [200.0, 300.0], [0.05, 0.15])
    np.testing.assert_allclose(force[after], expected, rtol=1e-12)
    expected = np.interp(t, [0.0, 600.0], [0.96, 1.0])
    np.testing.assert_allclose(forcing.column("A_frequency"), expected, rtol=1e-12)
    assert {50.0, 200.0, 300.0, 600.0} <= {*t.tolist()}


@pytest.mark.oracle
def test_steps_end_at_breakpoints_and_at_the_multiples_of_the_step_that_are_none():
    """On steps that do, nearly do, and do not divide the times of the breakpoints."""
    random = np.random.default_rng(1)
    for step in [0.3, 1.0, 7.0, *random.uniform(0.01, 20.0, 5)]:
        nearly = 7 * step + 1e-10 * step
        times = np.unique([0.7, nearly, 5 * step, *random.uniform(0.0, 30.0, 3)])
        points = [[t, 0.1 + 0.05 * (k % 2)] for k, t in enumerate(times.tolist())]
        text = START.replace("amplitude = 0.15", f"amplitude = {points}")
        text = text.replace("100\nstep = 1", f"20.0\nstep = {step}")
        schedule = make_plan(parse_scene(text + COULOMB, ".")).schedule
        fixed = np.array([0.0, *times[times < 20.0], 20.0])
        regular = step * np.arange(np.ceil(20.0 / step))
        apart = np.abs(regular[:, np.newaxis] - fixed).min(axis=1)
        expected = np.sort(np.append(fixed, regular[apart > 1e-9 * step]))
        np.testing.assert_array_equal(schedule.time(), expected)


@pytest.mark.oracle
def test_the_reference_frequency_is_the_mean_weighted_by_the_force():
    force, sweep = [[0, 0.0], [40, 0.2], [40, 0.1]], [[20, 0.97], [80, 1.0]]
    text = START.replace("amplitude = 0.15", f"amplitude = {force}")
    text = text.replace("0.98", str(sweep))
    fine = (np.arange(200_000) + 0.5) * (100.0 / 200_000)
    weights = np.where(fine < 40.0, 0.005 * fine, 0.1)
    expected = np.average(np.interp(fine, *np.transpose(sweep)), weights=weights)
    found = make_plan(parse_scene(text + COULOMB, ".")).excited.reduced.carrier
    assert found == pytest.approx([expected], rel=1e-9)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (COULOMB, rom.Coulomb(2.0)),
        (COULOMB.replace("coulomb", "tanh") + "alpha = 0.02\n", Tanh(2.0, 0.02)),
        (JENKINS.format([2.0, 1.0]), rom.Jenkins((2.0, 1.0), 30.0)),
        (FRICTIONAL.format(1.0), rom.FrictionalContact(0.5, 1.0, 20.0, 30.0)),
        (
            '[[contacts]]\nlaw = "iwan"\nforce = 2\nstiffness = 30\nchi = -0.5\nbeta = 0.1',
            rom.Iwan(2.0, 30.0, -0.5, 0.1),
        ),
        (
            '[[contacts]]\nlaw = "sliders"\nlimit = [1, 2]\nstiffness = [3, 4]\ncontacts = [0, 1]',
            rom.Contacts([(rom.Sliders((1.0, 2.0), (3.0, 4.0)), (0, 1))]),
        ),
        (
            JENKINS.format(2.0) + "contacts = [1]\n" + JENKINS.format(3.0) + "contacts = [0]\n",
            rom.Contacts([(rom.Jenkins(2.0, 30.0), (1,)), (rom.Jenkins(3.0, 30.0), (0,))]),
        ),
    ],
)
def test_laws_are_those_of_python(text, expected):
    assert make_plan(parse_scene(START + text, ".")).excited.law == expected


def test_parameters_and_matrices_reach_the_structure(tmp_path):
    text = START.replace('"two-mass"', '"two-mass"\ndamping = 0.02\nk_p = -5\ncontact_mass = 0.1')
    structure = parse_scene(text + COULOMB, ".").structure.build()
    expected = two_mass(beta=0.02, k_p=-5.0, contact_mass=0.1)
    np.testing.assert_array_equal(structure.stiffness, expected.stiffness)
    np.testing.assert_array_equal(structure.mass, expected.mass)
    expected.save(tmp_path / "beam.npz")
    for more, beta in (("", 0.02), ("\ndamping = 0.03", 0.03)):
        text = START.replace('model = "two-mass"', f'matrices = "beam.npz"{more}')
        built = parse_scene(text + COULOMB, tmp_path).structure.build()
        np.testing.assert_array_equal(built.stiffness, expected.stiffness)
        assert built.beta == beta


def test_a_static_force_makes_preloads_and_gaps(tmp_path):
    """Those of rom.preload; the plan says what it found."""
    given = START + FRICTIONAL.format(0.0) + "[preload]\n"
    plan = make_plan(parse_scene(given + "dof = [3, 0]\nforce = [2.0, 0.5]", "."))
    law = rom.FrictionalContact(0.5, 0.0, 20.0, 30.0)
    found = rom.preload(plan.structure, law, {3: 2.0, 0: 0.5})
    assert plan.excited.law == found.law
    assert found.law.preload[0] > 0.5
    said = {decision.subject: decision for decision in plan.decisions}
    assert said["contacts at rest"].choice == "1 stuck"
    assert "static force" not in said
    np.save(tmp_path / "static.npy", np.array([0.5, 0.0, 0.0, 2.0]))
    for vector in ("[0.5, 0, 0, 2]", '"static.npy"'):
        same = parse_scene(given + f"vector = {vector}", tmp_path)
        assert make_plan(same).excited.law == found.law


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_scenes_may_begin_with_a_byte_order_mark(encoding, tmp_path):
    text = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
    (tmp_path / "bom.toml").write_text(text, encoding=encoding, newline="\r\n")
    scene = load_scene(tmp_path / "bom.toml")
    assert scene.run == load_scene("one-mode").run
    assert (scene.name, scene.path) == ("bom", tmp_path / "bom.toml")


@pytest.mark.parametrize(
    ("spelled", "usual"), [("hz", "Hz"), ("Hertz", "Hz"), ("RAD/SEC", "rad/s")]
)
def test_units_may_have_other_spellings(spelled, usual):
    more = f'[units]\nfrequency = "{spelled}"\ndisplacement = "µm"\n'
    scene = parse_scene(START + COULOMB + more, ".")
    assert (scene.units.frequency, scene.units.displacement) == (usual, "um")
    factor = 2.0 * np.pi if usual == "Hz" else 1.0
    assert scene.forcing["A"].frequency.values == pytest.approx([0.98 * factor], rel=1e-14)
