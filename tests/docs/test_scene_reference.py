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
BASE = SCENE[SCENE.index("[structure]") :].replace("[log]", ELASTIC_WINDOW)
BASE += '[[contacts]]\nlaw = "jenkins"\n'  # keys are checked before the rules that link them
SECTIONS = scene_reference()
KEYS = [(header, key) for header, section in SECTIONS.items() for key in section.keys]
WRONG = "1979-05-27"  # no key is a date


def with_value(header, key, value):
    """The scene with a key set to a TOML value, whatever else is in that table."""
    if header == "":
        return f"{key} = {value}\n{BASE}"
    if header not in BASE:
        return f"{BASE}{header}\n{key} = {value}\n"
    before, after = BASE.split(f"{header}\n", 1)
    own, mark, later = after.partition("\n[")
    kept = [line for line in own.splitlines() if line and not line.startswith(f"{key} =")]
    return f"{before}{header}\n" + "\n".join([*kept, f"{key} = {value}"]) + f"\n{mark}{later}"


def refusal(text):
    with pytest.raises(SlipmodeError) as refused:
        parse_scene(text, ".")
    return str(refused.value)


def ids(case):
    header, key = case
    return f"{header}{key.name}"


@pytest.mark.parametrize("case", KEYS, ids=ids)
def test_the_reader_takes_the_key_and_says_what_is_allowed(case):
    header, key = case
    pair = key.kind.words in ("list of 2 numbers", "list of one number per mode")
    lists = key.kind.words.startswith("list of") and key.kind.allowed
    wrong = f"[{WRONG}, {WRONG}]" if pair else f"[{WRONG}]" if lists else WRONG
    said = refusal(with_value(header, key.name, wrong))
    table = {"[forcing.A]": "forcing.A", "[[contact]]": "contact[0]", "[[elastic]]": "elastic[0]"}
    prefix = table.get(header, header.strip("[]") + "[0]" * header.startswith("[["))
    name = f"{prefix}.{key.name}" if prefix else key.name
    assert said.startswith((f"{name}: ", f"{name}[0]: "))
    assert "unknown key" not in said
    assert key.kind.allowed in said
    assert key.meaning


@pytest.mark.parametrize("header", SECTIONS)
def test_the_reader_takes_no_other_key(header):
    said = refusal(with_value(header, "nothing", "1"))
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
        assert old in BASE and not check.is_valid(tomllib.loads(BASE.replace(old, new)))
