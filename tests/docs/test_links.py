"""make docs-links tells broken links from a machine without a network."""

import importlib.util
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
OFFLINE = "HTTPSConnectionPool(host='a.org'): Max retries exceeded (NameResolutionError)"


def line(status, info=""):
    return {
        **{"filename": "index.md", "lineno": 3, "uri": "https://a.org", "status": status},
        "info": info,
    }


@pytest.mark.parametrize(
    ("lines", "status", "words"),
    [
        ([line("working"), line("redirected"), line("unchecked")], 0, "2 external links reached"),
        ([line("working"), line("broken", "404 Not Found")], 1, "index.md:3: https://a.org: 404"),
        ([line("broken", "404 Not Found")], 1, "0 external links reached"),
        ([line("broken", OFFLINE)] * 2, 2, "no network here: none of 2 external links"),
        ([line("working"), line("broken", OFFLINE)], 1, "NameResolutionError"),
    ],
)
def test_the_verdict(lines, status, words):
    spec = importlib.util.spec_from_file_location("links", DOCS / "links.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found, said = module.verdict(lines)
    assert found == status
    assert words in said
