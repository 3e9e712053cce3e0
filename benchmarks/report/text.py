"""The report as tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from benchmarks.report.sections import Row, Section, by_method

Line = Sequence[str]

LEGEND = """\
Times are medians on one processor core, measured in this run. `table`: what is prepared once, our
friction table (on all cores) or the modes of another method. `ratio`: time over the time of the
row marked *. `runs`: how many pay for our table, against a row that is at least as accurate as *;
`never` where that row is faster. Errors are relative to the reference, the worst of all
components; `reference` is the error that the reference states. The slow flow yields amplitudes;
its errors are errors of the motion that they describe. Computing that motion at every sample is
`motion` where the contacts are integrated and `sums` where their harmonics are summed."""


def render(sections: Sequence[Section], structures: Sequence[Section]) -> str:
    """Return all tables, ready to print."""
    parts = [LEGEND, *(_section(section) for section in sections)]
    if structures:
        parts.append(_structures(structures))
    return "\n\n".join(parts)


def _section(section: Section) -> str:
    """One table, and the comparison with each method."""
    has_tables = section.baseline.table_seconds > 0.0
    head = ("method", "setting", *section.errors, "time", "ratio")
    lines = [
        (*head, "table", "runs") if has_tables else head,
        *(_line(section, row, has_tables) for row in section.rows),
    ]
    title = f"{section.title}: {section.task}; reference {_error(section.reference_error)}"
    verdicts = [line for k in section.ours for line in _verdict(section, section.rows[k])]
    return "\n".join([title, *_aligned(lines, 2), *verdicts])


def _structures(sections: Sequence[Section]) -> str:
    """Accuracy on other structures, one line each."""
    head = ("structure", *sections[0].errors, "time", "table", "full order", "ratio", "runs")
    lines: list[Line] = [head]
    for section in sections:
        ours, rivals = section.baseline, section.rivals(section.baseline)
        rival = (
            (
                time_in_words(rivals[0].seconds),
                _ratio(section.ratio(rivals[0])),
                _runs(section, rivals[0]),
            )
            if rivals
            else ("less accurate", "", "")
        )
        errors = (_error(error) for error in ours.errors)
        times = (time_in_words(ours.seconds), time_in_words(ours.table_seconds))
        lines.append((section.title, *errors, *times, *rival))
    title = "other structures: the slow flow, and the fastest full order that is as accurate"
    return "\n".join([title, *_aligned(lines, 1)])


def _verdict(section: Section, ours: Row) -> Iterator[str]:
    """How much slower other methods are than a row of ours, at its error or less."""
    yield f"  against {ours.name}, at its error or less:"
    rivals = section.rivals(ours)
    for row in sorted(rivals, key=lambda row: row.seconds):
        ratio = row.seconds / ours.seconds
        factor = f"{ratio:.3g} times slower" if ratio >= 1.0 else f"{1.0 / ratio:.3g} times FASTER"
        yield f"    {row.name}: {factor}"
    others = by_method(row for row in section.rows if row.is_peer)
    inaccurate = [name for name in others if name not in {row.method for row in rivals}]
    if inaccurate:
        yield f"    less accurate at any setting here: {', '.join(inaccurate)}"


def _line(section: Section, row: Row, has_tables: bool) -> Line:
    mark = "*" if row is section.baseline else ""
    table = (time_in_words(row.table_seconds) if row.table_seconds else "", _runs(section, row))
    return (
        f"{row.method}{mark}",
        row.setting,
        *(_error(error) for error in row.errors),
        time_in_words(row.seconds),
        _ratio(section.ratio(row)),
        *(table if has_tables else ()),
        row.note,
    )


def _aligned(lines: Sequence[Line], left: int) -> list[str]:
    """Columns of equal width: the first `left` and the notes to the left, numbers to the right."""
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    aligned = []
    for line in lines:
        cells = [
            f"{cell:<{width}}" if k < left else f"{cell:>{width}}"
            for k, (cell, width) in enumerate(zip(line, widths, strict=False))
        ]
        aligned.append("  " + "  ".join([*cells, *line[len(widths) :]]).rstrip())
    return aligned


def _error(error: float) -> str:
    return "" if math.isnan(error) else f"{error:.1e}"


def _ratio(ratio: float) -> str:
    return f"{ratio:.3g}" if ratio < 1000 else f"{ratio:.0f}"


def time_in_words(seconds: float) -> str:
    """Return a time [s] in s, ms or us, to three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e6:.3g} us"


def _runs(section: Section, row: Row) -> str:
    runs = section.break_even(row)
    if math.isnan(runs):
        return ""
    return "never" if math.isinf(runs) else f"{math.ceil(runs)}"
