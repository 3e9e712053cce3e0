"""Sphinx: `make docs` builds these pages into build/docs.

The keys of scenes come from their declarations, commands from their parser, the API from
docstrings: nothing is written down twice.
"""

import re
import sys
from pathlib import Path

from sphinx.application import Sphinx

from slipmode.rom import __version__

sys.path.insert(0, str(Path(__file__).parent))  # for commands.py and others
from commands import as_markdown as all_commands
from explore_pages import with_pages
from scene_keys import as_markdown as keys_of_scenes

project = "slipmode"
version = release = __version__
html_title = f"slipmode {__version__}"
html_theme = "furo"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["slipmode.css"]
html_copy_source = False
html_show_copyright = False
smartquotes = False  # quotes are those of code

extensions = [
    "mathml",
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
myst_enable_extensions = ["amsmath", "attrs_block", "attrs_inline", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings have types, shapes and units
autodoc_class_signature = "mixed"
numpydoc_show_class_members = False
default_role = "literal"

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "plot_gallery": True,
    "download_all_examples": False,
    "show_memory": False,
    "write_computation_times": False,
    "abort_on_example_error": True,
    "parallel": True,  # as many as there are jobs of Sphinx
    "within_subsection_order": "FileNameSortKey",
}
linkcheck_timeout = 15

_GENERATED = {"<!-- scene keys -->": keys_of_scenes, "<!-- commands -->": all_commands}


def _with_generated(app: Sphinx, page: str, source: list[str]) -> None:
    """Put the keys of scenes, the commands, and scenes as pages, where a page asks for them."""
    if app.builder.format == "html":
        source[0] = with_pages(page, source[0], Path(app.outdir))
    for mark, written in _GENERATED.items():
        if mark in source[0]:
            source[0] = source[0].replace(mark, written())


def _plain_text(_app: Sphinx, _what: str, _name: str, _of: object, _o: object, lines: list[str]):
    """|a| is a modulus in docstrings, *MATRIX a word: no markup of reStructuredText."""
    if _what == "data":  # the docstring of its type; the page describes it
        lines.clear()
    lines[:] = [re.sub(r"(\||(?<![*\w])\*(?=\w))", r"\\\1", line) for line in lines]


def setup(app: Sphinx) -> None:
    """Connect both, the latter before numpydoc reads the docstrings."""
    app.connect("source-read", _with_generated)
    app.connect("autodoc-process-docstring", _plain_text, priority=100)
