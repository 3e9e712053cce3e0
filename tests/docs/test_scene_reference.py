"""The scene reference: every key that the reader takes, with what the reader says and does."""

import json
import tomllib

import pytest
from runs import SCENE

from slipmode.rom import SlipmodeError
from slipmode.runner import parse_scene, shipped_scenes
from slipmode.runner.cli import main
from slipmode.runner.commands.scenes import scene_reference
from slipmode.runner.scene.structure_keys import ELASTIC_LAWS

ELASTIC_WINDOW = "[[elastic]]\nwindow = [30.0, 40.0]\n[output]\nelastic = [0]\n[log]"
RIGID = SCENE[SCENE.index("[structure]") :].replace("[log]", ELASTIC_WINDOW)
MISTUNED = """
[structure]
model = "lumped-disk"
[mistuning]
standard_deviation = 0.1
[[contacts]]
law = "jenkins"
limit = 1.0
stiffness = 5e4
[forcing.A]
dof = 2
amplitude = 4.0
engine_order = 3
rotor_speed = 3900.0
[run]
duration = 4.0
step = 0.01
"""
LAWS = {
    "jenkins": "limit = 1.0\nstiffness = 2.0",
    "sliders": "limit = [1.0]\nstiffness = [2.0]",
    "iwan": "force = 1.0\nstiffness = 2.0\nchi = -0.5\nbeta = 0.1",
    "frictional": (
        "mu = 0.3\npreload = 1.0\ntangential_stiffness = 2.0\nnormal_stiffness = 2.0\n"
    ),
}
WITH_MATRICES = ("mass", "contacts", "rayleigh", "matrices")
SECTIONS = scene_reference()
KEYS = [(header, key) for header, section in SECTIONS.items() for key in section.keys]
WRONG = "1979-05-27"  # no key is a date


def elastic(law):
    """The scene with elastic contacts instead."""
    head, rest = RIGID.split("[friction]")
    return f'{head}[[contacts]]\nlaw = "{law}"\n{LAWS[law]}\n[modes]{rest.split("[modes]")[1]}'


def has(law, key):
    """Whether an elastic law has a parameter; those left to their defaults are not in its text."""
    others = {"iwan": ["sliders"], "frictional": ["gap", "tangents"]}
    return f"{key} =" in LAWS[law] or key in others.get(law, [])


def scene_for(header, key):
    """A scene in which a key may be."""
    if header == "[[contacts]]":
        return elastic(next((law for law in LAWS if has(law, key)), "jenkins"))
    if header == "[mistuning]":
        drawn = "[mistuning]\nstandard_deviation = 0.1\n"
        return MISTUNED.replace(drawn, "") if key == "deviation" else MISTUNED
    return elastic("frictional") if header == "[preload]" else RIGID


def with_value(header, key, value):
    """A scene with a key set to a TOML value, whatever else is in that table."""
    text = scene_for(header, key)
    if header == "":
        return f"{key} = {value}\n{text}"
    if header not in text:
        return f"{text}{header}\n{key} = {value}\n"
    before, after = text.split(f"{header}\n", 1)
    own, mark, later = after.partition("\n[")
    kept = [line for line in own.splitlines() if line and not line.startswith(f"{key} =")]
    return f"{before}{header}\n" + "\n".join([*kept, f"{key} = {value}"]) + f"\n{mark}{later}"


def refusal(text, folder):
    with pytest.raises(SlipmodeError) as refused:
        parse_scene(text, folder)
    return str(refused.value)


def ids(case):
    header, key = case
    return f"{header}{key.name}"


@pytest.mark.parametrize("case", KEYS, ids=ids)
def test_the_reader_takes_the_key_and_says_what_is_allowed(case, tmp_path):
    header, key = case
    pair = key.kind.words in ("list of 2 numbers", "list of one number per mode")
    lists = key.kind.words.startswith("list of") and key.kind.allowed
    wrong = f"[{WRONG}, {WRONG}]" if pair else f"[{WRONG}]" if lists else WRONG
    text = with_value(header, key.name, wrong)
    if key.name in WITH_MATRICES and header == "[structure]":
        (tmp_path / "m.npz").touch()
        text = text.replace('model = "two-mass"', 'matrices = "m.npz"' * (key.name != "matrices"))
    if header == "[preload]" and key.name == "force":
        text = text.replace("[preload]\n", "[preload]\ndof = 0\n")
    if header == "[forcing.A]" and key.name in ("node", "vector"):
        text = text.replace("dof = 0\n", "")
    if key.name == "direction":
        text = text.replace("dof = 0\n", "node = 3\n")
    said = refusal(text, tmp_path)
    table = {"[forcing.A]": "forcing.A", "[[contact]]": "contact[0]", "[[elastic]]": "elastic[0]"}
    prefix = table.get(header, header.strip("[]") + "[0]" * header.startswith("[["))
    name = f"{prefix}.{key.name}" if prefix else key.name
    assert said.startswith((f"{name}: ", f"{name}[0]: "))
    assert "unknown key" not in said
    assert key.kind.allowed in said
    assert key.meaning


@pytest.mark.parametrize("header", SECTIONS)
def test_the_reader_takes_no_other_key(header, tmp_path):
    said = refusal(with_value(header, "nothing", "1"), tmp_path)
    allowed = said.split("allowed: ")[1].split("; did you mean")[0].split(", ")
    tables = {title.strip("[]").split(".")[0] for title in SECTIONS if title}
    named = {key.name for key in SECTIONS[header].keys}
    assert set(allowed) == named | (tables if header == "" else set())


def test_parameters_of_contacts_name_their_laws():
    for key in SECTIONS["[[contacts]]"].keys[2:]:
        laws = [name for name, law in ELASTIC_LAWS.items() if key.name in law.__annotations__]
        assert key.meaning.endswith(f"Laws: `{'`, `'.join(laws)}`.")


def test_shipped_scenes_satisfy_the_json_schema(capsys):
    jsonschema = pytest.importorskip("jsonschema")
    assert main(["scenes", "--schema"]) == 0
    check = jsonschema.Draft4Validator(json.loads(capsys.readouterr().out))
    check.check_schema(check.schema)
    for path in shipped_scenes().values():
        check.validate(tomllib.loads(path.read_text()))
    for old, new in (("step =", "stepp ="), ("step = ", "step = -"), ('"tanh"', '"stick"')):
        assert old in RIGID and not check.is_valid(tomllib.loads(RIGID.replace(old, new)))
