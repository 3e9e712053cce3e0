"""Files that are no sound recordings: one clear line each, and the file stays as it was."""

import pytest
from damage.commands import COMMANDS
from recordings import damaged, rewritten, write

from slipmode.__main__ import main

OF_SAMPLES = ("doctor", "export", "replay")


def missing(folder):
    return folder / "missing.mcap", "No such file"


def directory(folder):
    return folder, "Is a directory"


def empty(folder):
    (folder / "empty.mcap").touch()
    return folder / "empty.mcap", "an empty file"


def text(folder):
    (folder / "text.mcap").write_text("not a recording at all")
    return folder / "text.mcap", "not an MCAP file"


def cut_in_the_header(folder):
    path = damaged(write(folder / "run.mcap", 10), folder, lambda data: data[:100])
    (folder / "run.mcap").unlink()
    return path, ""


def wrong_schema(folder):
    return rewritten(folder / "schema.mcap", describe=False), "is not a channel of samples"


def wrong_layout(folder):
    return rewritten(folder / "layout.mcap", length=-1), "the length of a sample does not fit"


def mixed_clocks(folder):
    wall = {"/modes": 1_700_000_000 * 10**9, "/contact/0": 0}
    path = rewritten(folder / "clocks.mcap", lambda topic, number: wall[topic] + number)
    return path, "mixed clocks: /modes has times from 1970, /contact/0 from the run's start"


def external(folder):
    return rewritten(folder / "external.mcap", units=False), "not a recording of slipmode"


@pytest.mark.parametrize(
    ("prepare", "command"),
    [
        *((p, c) for p in (missing, directory, empty, text) for c in COMMANDS),
        *((cut_in_the_header, c) for c in COMMANDS if c != "info"),
        *((p, c) for p in (wrong_schema, wrong_layout, mixed_clocks) for c in OF_SAMPLES),
        (external, "export"),
    ],
)
def test_refused_in_one_line(tmp_path, capsys, monkeypatch, prepare, command):
    folder = tmp_path / "source"
    folder.mkdir()
    path, complaint = prepare(folder)
    before = contents(folder)
    monkeypatch.chdir(tmp_path)
    assert main([command, str(path), *COMMANDS[command]]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    lines = printed.err.splitlines()
    assert len(lines) == 1 or command == "doctor"
    assert all(str(path) in line for line in lines)
    assert complaint in printed.err
    assert contents(folder) == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["source"]


def contents(folder):
    return {path: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (
            ("export", "-o", "out.npz", "--topics", "/mode"),
            "/mode: no such channel; the recording has /modes",
        ),
        (("export", "-o", "out.mat"), "must end in .npz, .csv or .parquet"),
        (("export", "-o", "no/out.npz"), "No such file"),
        (("recover", "-o", "run.mcap"), "is the file to recover from"),
        (("recover", "-o", "."), "is a directory"),
    ],
)
def test_bad_requests(tmp_path, capsys, monkeypatch, arguments, complaint):
    monkeypatch.chdir(tmp_path)
    path = write(tmp_path / "run.mcap", 10)
    before = contents(tmp_path)
    command, *options = arguments
    assert main([command, "run.mcap", *options]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert complaint in line
    assert contents(tmp_path) == before == {path: path.read_bytes()}
