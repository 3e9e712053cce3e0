"""The report as one table, which README.md and docs/guide/accuracy.md contain."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.report.sections import OURS, Row, Section
from benchmarks.report.text import time_in_words

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", ROOT / "docs" / "guide" / "accuracy.md")
BEGIN, END = "<!-- make report writes this table -->\n", "<!-- end of the table -->\n"


def as_markdown(sections: Sequence[Section]) -> str:
    """Return a line for the baseline of each section and for each other method of ours, once."""
    head = ("task", "slipmode", "error", "time", "other methods at this error, times slower")
    lines: list[Sequence[str]] = [head, ("---",) * len(head)]
    methods = {"slipmode, sums"}  # a rough form of `motion`
    for section in sections:
        for row in (section.rows[k] for k in section.ours):
            if row is section.baseline or row.method not in methods:
                lines.append(_line(section, row))
            methods.add(row.method)
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def write(table: str, pages: Sequence[Path] = PAGES) -> None:
    """Replace the table of each page."""
    for page in pages:
        text = page.read_text(encoding="utf-8")
        before, _, rest = text.partition(BEGIN)
        after = rest.partition(END)[2]
        page.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


def _line(section: Section, row: Row) -> Sequence[str]:
    method = row.method.removeprefix(OURS).removeprefix(", ") or "friction of one amplitude pair"
    error = f"{100 * row.error:.2g} %"
    return section.title, method, error, time_in_words(row.seconds), _rivals(section, row)


def _rivals(section: Section, ours: Row) -> str:
    rivals = sorted(section.rivals(ours), key=lambda row: row.seconds)
    found = [f"{row.method} {_rounded(row.seconds / ours.seconds)}" for row in rivals]
    return ", ".join(found) or "none reaches it"


def _rounded(ratio: float) -> str:
    """Two digits: machines are noisy."""
    return f"{float(f'{ratio:.2g}'):g}" if ratio < 1e4 else f"{float(f'{ratio:.2g}'):,.0f}"
