"""The draft of the paper has the fields of its journal, and every reference resolves."""

import re
from pathlib import Path

import pytest

yaml = pytest.importorskip("yaml", reason="needs slipmode[study]")

PAPER = Path(__file__).parents[2] / "release" / "paper"


def test_fields_sections_and_references():
    _, front, text = (PAPER / "paper.md").read_text(encoding="utf-8").split("---\n", 2)
    fields = yaml.safe_load(front)
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= fields.keys()
    places = {each["index"] for each in fields["affiliations"]}
    assert fields["authors"] and all(each["affiliation"] in places for each in fields["authors"])
    titles = re.findall(r"^# (.*)$", text, re.MULTILINE)
    assert titles[:2] == ["Summary", "Statement of need"] and titles[-1] == "References"
    assert 250 <= len(text.split()) <= 1750

    entries = (PAPER / fields["bibliography"]).read_text(encoding="utf-8").split("\n@")
    known = {re.match(r"@?\w+\{([\w-]+),", entry)[1]: entry for entry in entries}
    cited = set(re.findall(r"@([\w-]+)", text))
    assert len(cited) >= 6
    assert cited == known.keys()
    for entry in known.values():
        assert all(f"{field} = " in entry for field in ("author", "title", "year"))
        assert "doi = {10." in entry or "url = {https://" in entry
