"""Documentation inside an FMU: documentation/index.html and the icon."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from importlib.metadata import version
from pathlib import Path
from string import Template

import numpy as np

from slipmode.fmu.description.xml_files import Fmi3Description, literal
from slipmode.fmu.inputs import AnyModel
from slipmode.fmu.variables.variable import Variable
from slipmode.rom.errors import Finding
from slipmode.rom.laws.directions import law_words
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.tone.tone_flow import SPAN
from slipmode.rom.slow.transient import TransientError
from slipmode.rom.table.local.tone_model import ToneModel


def index_html(model: AnyModel, given: Fmi3Description, findings: Sequence[Finding]) -> bytes:
    """Return the page that a tool opens as documentation; it lists findings as warnings."""
    warnings = [f"<li>{escape(each.line())}</li>" for each in findings if each.level != "info"]
    sections = []
    for causality in ("independent", "parameter", "input", "output", "local"):
        rows = [_row(k, v) for k, v in enumerate(given.variables) if v.causality == causality]
        header = ("Reference", "Name", "Description", "Unit", "Start")
        sections += [f"<h3>{causality.capitalize()}</h3>", _table(rows, header)]
    use = _template(
        "documentation_tone" if isinstance(model, ToneModel) else "documentation_tables"
    )
    page = _template("documentation").substitute(
        name=escape(given.options.name),
        use=use.substitute(
            fmi=given.options.fmi,
            version=version("slipmode"),
            facts=_table(_facts(model)),
            validity="\n".join(f"<li>{words}</li>" for words in _validity(model)),
        ),
        warnings="\n".join(["<h2>Warnings</h2>\n<ul>", *warnings, "</ul>"]) if warnings else "",
        variables="\n".join(sections),
    )
    return page.encode()


def _template(name: str) -> Template:
    return Template(Path(__file__).with_name(f"{name}.html").read_text(encoding="utf-8"))


def contact_count(model: AnyModel) -> int:
    """Return the number of contacts, each with one to three contact DOFs."""
    elements = model.reduced.contacts
    return model.reduced.n_contacts if elements is None else len(elements.element)


def _validity(model: AnyModel) -> list[str]:
    """Return what the model assumes, and what a change of amplitudes within a cycle costs."""
    if isinstance(model, ToneModel):
        middle = " and ".join(f"{each:.6g} rad/s" for each in model.carrier)
        return [
            "The modes are modes of the structure with stuck contacts. A force moves all modes of "
            f"its tone, at frequencies within {percentage(SPAN)} of {middle}.",
            "Contacts follow the present motion at the forcing frequencies. Their action on each "
            "other at higher harmonics is neglected.",
        ]
    contacts = "Contact motion is small relative to modal motion. The contacts do not separate."
    if model.reduced.contacts is not None:
        contacts = (
            "The modes are modes of the structure with stuck contacts. At most two of them "
            "dominate the motion."
        )
    largest, carrier = model.table.amplitude_range[np.newaxis], model.reduced.carrier
    rate = 0.01 * largest * carrier.min() / (2.0 * np.pi)
    error = TransientError.of(model.reduced, model.law).at(rate, carrier, largest) / largest
    listed = ", ".join(percentage(part) for part in error[0])
    transients = (
        "Amplitudes change little within a cycle. If contacts slip and all amplitudes change by "
        "1 % of the range of the friction table in a cycle, the estimated error is up to "
        f"{listed} of the range. Steady states do not have this error."
    )
    return [contacts, transients]


def _facts(model: AnyModel) -> list[tuple[str, ...]]:
    reduced = model.reduced
    facts = [
        ("Formulation", reduced.formulation),
        ("Natural frequencies", ", ".join(f"{f:.6g}" for f in reduced.frequency) + " rad/s"),
        ("Contacts", str(contact_count(model))),
        ("Contact law", "; ".join(law_words(model.law, reduced.n_contacts)) or "none"),
    ]
    if isinstance(model, ToneModel):
        return [*facts, ("Friction", "one table for each contact, over its own amplitudes")]
    accuracy = model.accuracy
    combinations = ", ".join(f"{t.n:+d} A {t.m:+d} B" for t in model.combinations) or "none"
    nodes = f"{model.table.node_a.size} x {model.table.node_b.size}"
    ends = ", ".join(f"{value:g}" for value in model.table.amplitude_range)
    return [
        *facts,
        ("Combination resonances", combinations),
        (
            "Friction table",
            f"{nodes} amplitudes up to {ends} kg^0.5 m; relative interpolation error "
            f"{accuracy.interpolation:.1e}, relative resolution error {accuracy.resolution:.1e}",
        ),
        ("Content hash of the model", model.hash),
    ]


def _row(reference: int, variable: Variable) -> tuple[str, ...]:
    unit = variable.quantity.unit if variable.quantity else ""
    start = "" if variable.start is None else literal(variable.start)
    return str(reference), variable.name, variable.description, unit, start


def _table(rows: Sequence[Sequence[str]], header: Sequence[str] = ()) -> str:
    lines = [_cells("th", header)] if header else []
    lines += [_cells("td", row) for row in rows]
    return "<table>\n" + "\n".join(lines) + "\n</table>"


def _cells(tag: str, row: Sequence[str]) -> str:
    return "<tr>" + "".join(f"<{tag}>{escape(text)}</{tag}>" for text in row) + "</tr>"


def icon_png() -> bytes:
    """Return the icon, a friction hysteresis loop, as a PNG picture."""
    return Path(__file__).with_name("icon.png").read_bytes()
