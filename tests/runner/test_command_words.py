"""Messages of commands name options and scene keys, never arguments of Python functions."""

import re

import pytest

from slipmode.__main__ import main
from slipmode.runner import shipped_scenes
from slipmode.runner.commands.command_words import command_words

PYTHON = re.compile(r"rom\.\w|fmu\.\w|\w+=|[Tt]abulate")


def test_a_backbone_has_no_warning_about_its_own_table(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    assert main(["backbone", "two-mode", "-o", str(tmp_path)]) == 0
    assert "warning" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "begins"),
    [
        (
            ["curve", "--vary", "force"],
            "--span: is missing; give the first and last value of force",
        ),
        (["curve", "--vary", "force_B", "--span", "0", "1"], "--vary: the scene does not force"),
        (["curve", "--vary", "frequency_A", "--span", "0.1", "1"], "--span: must be 0.62"),
        (["curve", "--span", "1.1", "0.9"], "--span: FROM must be below TO, got 1.1 0.9"),
        (["curve", "--dof", "9"], "--dof: must be 0 to 3"),
        (["backbone", "--other", "0.1"], "--other: must be 0 in a model of one mode"),
        (["design", "--mode", "B"], "--mode: must be one that the scene forces, A"),
        (["fmu", "--range", "0.5"], "--range: must be a finite number >= 1"),
    ],
)
def test_a_refusal_names_the_option(command, begins, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    name, *options = command
    assert main([name, "one-mode", *options, "-o", str(tmp_path / "out")]) == 1
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(f"slipmode: {begins}")
    assert not PYTHON.search(line)


def test_a_design_whose_table_ends_too_early_names_the_key_of_the_scene(tmp_path, capsys):
    text = shipped_scenes()["one-mode"].read_text(encoding="utf-8")
    for old, new in (
        ('law = "tanh"', 'law = "coulomb"'),
        ("alpha = 0.02", ""),
        ("limit = 2.0", "limit = 2000.0"),
    ):
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "stuck.toml").write_text(f"{text}\n[model]\namplitude = [2.0]\n", encoding="utf-8")
    assert main(["design", str(tmp_path / "stuck.toml"), "-o", str(tmp_path)]) == 1
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("slipmode: model.amplitude: up to")
    assert re.search(r"give model\.amplitude = \S+ or more$", line)
    assert not PYTHON.search(line.replace("model.amplitude =", ""))


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ("amplitude: 3 counts as more, outside the friction table; tabulate further",
         "model.amplitude: 3 counts as more, outside the friction table; give a larger "
         "model.amplitude (or a model.file with a larger range)"),
        ("mode: A is self-excited; rom.limit_cycles is for that", "mode: A is self-excited"),
        ("contacts: integrate in time (rom.full)",
         'contacts: integrate in time (model.table = "none")'),
        ("there is 2 %. Call rom.reduce with carrier = this frequency, or compare with "
         "slipmode validate", "there is 2 %. Keep the frequencies closer to the mean frequency of "
         "the forcing, or compare with slipmode validate"),
        ("friction table. Call rom.reduce with carrier = 1.234 rad/s",
         "friction table. Give the forcing of the scene a frequency of 1.234 rad/s"),
        ('Use model.table = "none" or rom.steady_state', 'Use model.table = "none"'),
    ],
)  # fmt: skip
def test_advice_for_python_is_replaced(message, words):
    assert command_words(message) == words
