"""The reference of commands: every command and option, as the program says it."""

from pathlib import Path
from runpy import run_path

import pytest

from slipmode.__main__ import main

DOCS = Path(__file__).parents[2] / "docs"
GENERATOR = run_path(DOCS / "commands.py")
PAGE, COMMANDS = GENERATOR["as_markdown"](), GENERATOR["commands"]()


def test_the_page_has_every_command_that_the_program_names(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    printed = capsys.readouterr().out
    assert len(COMMANDS) >= 16
    for name in COMMANDS:
        assert f"\n    {name}" in printed
        assert PAGE.count(f"## `slipmode {name}`\n") == 1
    assert PAGE.count("## `slipmode ") == len(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_its_arguments_and_an_example(name, capsys):
    with pytest.raises(SystemExit):
        main([name, "--help"])
    options = [word for word in capsys.readouterr().out.split() if word.startswith("--")]
    section = PAGE.split(f"## `slipmode {name}`\n")[1].split("\n## ")[0]
    assert f"slipmode {name}" in section
    for option in {word.strip(",.:;[]") for word in options} - {"--help"}:
        assert f"`{option}" in section
    for row in section.splitlines():
        if row.startswith("| `"):
            assert len(row.split(" | ")[1]) > 8
