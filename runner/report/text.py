"""The report as compact tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from slipmode.runner.report.measure import Row, Section
from slipmode.runner.report.methods.figures import Figure

Line = Sequence[str]

LEGEND = """\
Times are medians on one processor core, measured in this run. `table`: what is prepared once, our
friction table (on all cores) or a peer's modes. `ratio`: time over that of the row marked *.
`runs`: how many pay for our table, against a row that is at least as exact as *; `never` where
that row is faster. Errors are relative to the reference, the worst of all components; `reference`
is the error that the reference states. The slow flow yields amplitudes; its errors are those of
the motion that they stand for. Computing that motion at every sample is `motion` where the
contacts are marched and `sums` where their harmonics are summed, in the last part of the run
`window`."""


def render(
    sections: Sequence[Section], structures: Sequence[Section], figures: Sequence[Figure]
) -> str:
    """All tables, ready to print."""
    parts = [LEGEND, *(section_text(section) for section in sections)]
    if structures:
        parts.append(structures_text(structures))
    parts.append("\n".join(f"{f.value:12.4g} {f.unit:3} {f.subject}" for f in figures))
    return "\n\n".join(part for part in parts if part)


def section_text(section: Section) -> str:
    """One table, and what follows from it."""
    has_tables = section.baseline.table_seconds > 0.0
    head = ("method", "setting", *section.errors, "time", "ratio")
    lines = [
        (*head, "table", "runs") if has_tables else head,
        *(_line(section, row, has_tables) for row in section.rows),
    ]
    title = f"{section.title}: {section.task}; reference {_error(section.reference_error)}"
    verdicts = [line for k in section.ours for line in verdict(section, section.rows[k])]
    return "\n".join([title, *aligned(lines), *verdicts])


def structures_text(sections: Sequence[Section]) -> str:
    """Accuracy on other structures, one line each."""
    head = ("structure", *sections[0].errors, "time", "table", "full order", "ratio", "runs")
    lines = [head]
    for section in sections:
        ours, rivals = section.baseline, section.rivals(section.baseline)
        rival = (
            (_time(rivals[0].seconds), _ratio(section.ratio(rivals[0])), _runs(section, rivals[0]))
            if rivals
            else ("less exact", "", "")
        )
        errors = (_error(error) for error in ours.errors)
        times = (_time(ours.seconds), _time(ours.table_seconds))
        lines.append((section.title, *errors, *times, *rival))
    title = "other structures: the slow flow, and the cheapest full order that is as exact"
    return "\n".join([title, *aligned(lines, left=1)])


def verdict(section: Section, ours: Row) -> Iterator[str]:
    """Who is faster than a row of ours at equal or better error, one line per method."""
    yield f"  against {ours.name}, at its error or less:"
    rivals = section.rivals(ours)
    for row in sorted(rivals, key=lambda row: row.seconds):
        ratio = row.seconds / ours.seconds
        factor = f"{ratio:.3g} times slower" if ratio >= 1.0 else f"{1.0 / ratio:.3g} times FASTER"
        yield f"    {row.name}: {factor}"
    reached = {row.method for row in rivals}
    peers = (row.method for row in section.rows if section.is_peer(row))
    missing = dict.fromkeys(method for method in peers if method not in reached)
    if missing:
        yield f"    not that exact at any setting here: {'; '.join(missing)}"


def _line(section: Section, row: Row, has_tables: bool) -> Line:
    mark = "*" if row is section.baseline else ""
    table = (_time(row.table_seconds) if row.table_seconds else "", _runs(section, row))
    return (
        f"{row.method}{mark}",
        row.setting,
        *(_error(error) for error in row.errors),
        _time(row.seconds),
        _ratio(section.ratio(row)),
        *(table if has_tables else ()),
        row.note,
    )


def aligned(lines: Sequence[Line], left: int = 2) -> list[str]:
    """Columns of equal width; the first `left` and the notes to the left, numbers to the right."""
    columns = len(lines[0])
    widths = [max(len(line[k]) for line in lines) for k in range(columns)]
    aligned = []
    for line in lines:
        cells = [
            f"{cell:<{width}}" if k < left else f"{cell:>{width}}"
            for k, (cell, width) in enumerate(zip(line, widths, strict=False))
        ]
        aligned.append("  " + "  ".join([*cells, *line[columns:]]).rstrip())
    return aligned


def _error(error: float) -> str:
    return "" if math.isnan(error) else f"{error:.1e}"


def _ratio(ratio: float) -> str:
    return f"{ratio:.3g}" if ratio < 1000 else f"{ratio:.0f}"


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e6:.3g} us"


def _runs(section: Section, row: Row) -> str:
    runs = section.break_even(row)
    if math.isnan(runs):
        return ""
    return "never" if math.isinf(runs) else f"{math.ceil(runs)}"
