"""The file of a page, without a browser; the core as WebAssembly where zig is installed."""

import base64
import json
import zlib
from html.parser import HTMLParser

import numpy as np
import pytest
from runs import replaced

from slipmode import runner
from slipmode.__main__ import main
from slipmode.runner import shipped_scenes
from slipmode.runner.explore import explore as exploring


class Elements(HTMLParser):
    """Texts of the scripts by their identifiers or types, and all addresses."""

    def __init__(self, text):
        super().__init__()
        self.scripts, self.addresses, self._inside = {}, [], None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        name = given.get("id") or f"type {given.get('type')}"
        self._inside = name if tag == "script" else None
        self.addresses += [value for key, value in attrs if key in ("src", "href")]

    def handle_data(self, data):
        if self._inside:
            self.scripts[self._inside] = self.scripts.get(self._inside, "") + data

    def handle_endtag(self, tag):
        self._inside = None


@pytest.fixture
def no_compiler(monkeypatch):
    """A module that is none, so that pages can be written without zig."""
    monkeypatch.setattr(exploring, "browser_module", lambda: b"\0asm")


@pytest.fixture
def written(no_compiler, tmp_path):
    """Writes a page of a scene, whose text may be changed, and returns its elements."""

    def write(name, *changes):
        scene = tmp_path / f"{name}.toml"
        text = replaced(shipped_scenes()[name].read_text(encoding="utf-8"), *changes)
        scene.write_text(text, encoding="utf-8")
        path = runner.explore(scene, tmp_path / "page.html")
        return Elements(path.read_text(encoding="utf-8"))

    return write


def test_a_page_has_everything_in_it(written):
    page = written("one-mode")
    assert {"content", "module", "files", "type importmap"} <= page.scripts.keys()
    assert zlib.decompress(base64.b64decode(page.scripts["module"])) == b"\0asm"
    files = zlib.decompress(base64.b64decode(page.scripts["files"]))
    planes = np.frombuffer(files, dtype=np.uint8).reshape(8, -1)
    assert b"token.txt" in planes.T.tobytes()
    imports = json.loads(page.scripts["type importmap"])["imports"]
    assert {"page/main", "page/core", "page/uplot"} <= imports.keys()
    assert all(each.startswith("data:") for each in (*imports.values(), *page.addresses))


def test_a_static_force_that_alone_presses_contacts_is_an_input(written):
    """In newtons; the core scales limits and preloads."""
    matrices = shipped_scenes()["wedge-damper"].with_suffix(".npz").as_posix()
    page = written("wedge-damper", ("wedge-damper.npz", matrices))
    content = json.loads(page.scripts["content"])
    scale = next(each for each in content["inputs"] if each["name"] == "limit_scale")
    assert (scale["label"], scale["unit"], scale["start"] / scale["per"]) == (
        "Static force",
        "N",
        240,
    )


def test_inputs_start_as_the_scene_ends_and_cover_its_frequencies(written):
    content = json.loads(written("one-mode").scripts["content"])
    inputs = {each["name"]: each for each in content["inputs"]}
    assert inputs.keys() == {"force_A", "frequency_A"}  # tanh: limits cannot be scaled
    force, frequency = inputs.values()
    assert force["start"] == 0.15 and force["least"] == 0.0 and 0.2 < force["most"] < 0.5
    assert frequency["least"] < frequency["start"] < frequency["most"]
    assert frequency["most"] - frequency["least"] == pytest.approx(0.07, abs=0.02)  # [rad/s]
    assert content["modes"] == ["A"] and len(content["contacts"]) == 2
    assert [each["name"] for each in content["dofs"]] == ["DOF 0"]  # where the force is


def test_a_title_is_shown_and_not_run(written):
    title = "</title><script>alert(1)</script> & co"
    page = written("one-mode", ('title = "One mode near resonance"', f"title = '{title}'"))
    assert json.loads(page.scripts["content"])["title"] == title
    run = [text for name, text in page.scripts.items() if name != "content"]
    assert not [text for text in run if "alert" in text]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("mistuned-disk",), "mistuning: this needs a model of one or two waves"),
        (("one-mode", "--range", "0.5"), "--range: must be a finite number >= 1, got 0.5"),
        (("no-such-scene",), "'no-such-scene': no such scene file"),
        (("one-mode", "-o", "no/such/folder/x.html"), "no/such/folder/x.html"),
    ],
)
def test_what_is_refused_is_named(arguments, message, no_compiler, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["explore", *arguments]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"slipmode: {message}")
