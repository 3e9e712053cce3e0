"""The documentation builds without a warning, and its pages have what they promise."""

import html
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("sphinx", reason="needs slipmode[docs]")
for package in (
    "furo",
    "latex2mathml",
    "myst_parser",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_gallery",
):
    pytest.importorskip(package, reason="needs slipmode[docs]")

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
LINK = re.compile(r'(?:href|src)="([^"#?]*)[^"#]*(?:#([^"]*))?"')


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The pages as `make docs` builds them."""
    folder = tmp_path_factory.mktemp("site")
    command = (sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning", DOCS, folder)
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def links(page):
    """Addresses within the site that a page names, with their anchors."""
    for address, anchor in LINK.findall(page.read_text(encoding="utf-8")):
        if "://" not in address and not address.startswith(("data:", "mailto:")):
            anchor = "" if "=" in anchor else html.unescape(anchor)  # settings of a scene's page
            yield (page.parent / address).resolve() if address else page, anchor


def test_links_within_the_site_lead_somewhere(site):
    pages = [p for p in site.rglob("*.html") if "_modules" not in p.parts]
    assert len(pages) > 12
    anchors = {p: set(re.findall(r'\bid="([^"]*)"', p.read_text("utf-8"))) for p in pages}
    # "play=0" and the like are settings of a scene in the browser
    broken = {
        (page.name, target.name, anchor)
        for page in pages
        for target, anchor in links(page)
        if not target.exists()
        or (anchor and "=" not in anchor and anchor not in anchors.get(target, {anchor}))
    }
    assert not broken


def test_pages_need_no_network(site):
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="(https?:[^"]*)"', text)


def test_equations_keys_and_names_are_on_their_pages(site):
    theory = (site / "theory.html").read_text(encoding="utf-8")
    assert theory.count("<math ") > 100
    assert "\\" not in re.sub(r"<script.*?</script>", "", theory, flags=re.DOTALL)
    scene = (site / "reference" / "scene.html").read_text(encoding="utf-8")
    assert "samples_per_period" in scene and "scene keys" not in scene
    api = (site / "reference" / "rom.html").read_text(encoding="utf-8")
    assert 'id="slipmode.rom.steady"' in api
