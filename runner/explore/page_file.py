"""The HTML file: the page, the library of its plots, the core and the model, all in one."""

from __future__ import annotations

import base64
import html
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from string import Template
from typing import Any

from slipmode.rom import __version__
from slipmode.rom.storage import replacing

_PAGE = Path(__file__).with_name("page")


def write_page(path: Path, content: Mapping[str, Any], module: bytes, files: bytes) -> None:
    """Write the file.

    Parameters
    ----------
    path : Path
    content : mapping
        What the page shows, see page/main.js.
    module : bytes
        The core as WebAssembly.
    files : bytes
        The resource files of the model, see `browser_files`.
    """
    uplot = _PAGE / "uplot"
    modules = {each.stem: each.read_bytes() for each in sorted(_PAGE.glob("*.js"))}
    modules["uplot"] = (uplot / "uPlot.iife.min.js").read_bytes() + b"\nexport default uPlot;\n"
    imports = {f"page/{name}": _data_url(text) for name, text in modules.items()}
    text = Template((_PAGE / "page.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(content["title"]),
        version=__version__,
        style=(uplot / "uPlot.min.css").read_text() + (_PAGE / "page.css").read_text("utf-8"),
        license=(uplot / "LICENSE").read_text(encoding="utf-8").strip(),
        imports=json.dumps({"imports": imports}),
        content=_in_html(json.dumps(content)),
        module=_packed(module),
        files=_packed(files),
    )
    with replacing(path) as file:
        file.write(text.encode())


def _data_url(source: bytes) -> str:
    return f"data:text/javascript;base64,{base64.b64encode(source).decode()}"


def _packed(data: bytes) -> str:
    """Return compressed data as base64."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


def _in_html(text: str) -> str:
    """Return JSON that ends no <script>."""
    return text.replace("<", "\\u003c")
