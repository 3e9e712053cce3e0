"""What an FMU says about itself: documentation/index.html and its icon."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from html import escape

import numpy as np

from slipmode.fmu.description.description import FmiVersion
from slipmode.fmu.description.xml_writer import literal
from slipmode.fmu.variables.quantities import UNITS
from slipmode.fmu.variables.variable import Causality, Variable
from slipmode.rom import Model
from slipmode.rom.errors import Finding
from slipmode.rom.laws.directions import law_words
from slipmode.rom.slow.transient import TransientError

_STYLE = (
    "body { font-family: sans-serif; max-width: 60em; margin: 2em auto; line-height: 1.4 } "
    "table { border-collapse: collapse } "
    "td, th { border: 1px solid #bbb; padding: .2em .6em; text-align: left }"
)

_VALIDITY = (
    "The modes are well separated, lightly damped, and forced near their resonances.",
    "Contact outputs leave out the modal response to the higher harmonics of the contacts, about "
    "1 % of the motion.",
    "A step that leaves the friction table is discarded, and the instance is as before it; "
    "nothing is extrapolated. The log says which input, how far the table goes and when it ends. "
    "A shorter step may do; where none does, or the same is tried again, the FMU asks for the end "
    "of the simulation (<code>fmi2Terminated</code>, <code>terminateSimulation</code>).",
    "Modal damping may be changed, but the friction table was made with its start value: small "
    "changes are followed, large ones are an approximation.",
)

_USE = (
    "<b>Inputs.</b> An input holds its value, and moves at its rate (<code>force_rate_A</code>, "
    "...), until it is set again: in Co-Simulation during the steps, in Model Exchange with the "
    "time that the importer sets. Sweeps by rates are exact and continuous in phase.",
    "<b>Co-Simulation.</b> Steps may have any length. At the same times, amplitudes and what "
    "follows from them differ by no more than the tolerance from one choice of steps to another; "
    "displacements and forces of contacts by 0.1 % (RMS), their velocities by 1.5 %. Contacts are "
    "marched where they are read: whether they were read before changes displacements and forces "
    "by less than 1e-5 in their units.",
    "<b>Model Exchange.</b> The states are the amplitudes, the carrier angles and the dissipated "
    "energy. The state of a carrier angle grows without end; the variable (<code>theta_A</code>) "
    "reads in [0, 2 pi), as in Co-Simulation. Contact motion is that of the last few periods on "
    "amplitudes which are straight lines; in a transient it differs from Co-Simulation by about "
    "their curvature.",
    "Where a force jumps, in amplitude or phase, the modes go on as they were, and the free "
    "vibrations that this leaves behind are part of the amplitudes. In Co-Simulation that is "
    "where a force is set between two steps to another value than it has come to. In Model "
    "Exchange it is where a force is set in Event Mode: the event iteration then changes the "
    "amplitudes and says so (<code>valuesOfContinuousStatesChanged</code>). A force set in "
    "Continuous-Time Mode changes continuously there, however far it moves. Nothing jumps before "
    "the first step or in the initial event: what acts first did before.",
    "<b>Start.</b> The start values of the amplitudes belong to the start values of the forces. A "
    "force near one mode also moves the other, off resonance. From rest, that mode's amplitude "
    "therefore starts at the free vibration that cancels this response: it is not 0, though the "
    "mode's own force and its displacement are. Displacements <code>x_</code>n have both parts. "
    "An importer that starts with other forces gives the amplitudes too, or starts at rest with "
    "amplitudes and forces 0 and sets the forces after the first step or in an event.",
    "<b>Derivatives</b> by states and inputs, directional and (FMI 3.0) adjoint, are analytic, "
    "those of the table's interpolant, but for a small term that would take its second "
    "derivatives and is a central difference; |a| and arg a have none at a = 0. Those of contact "
    "motion are central differences of marches over the last few periods, in steps that are not "
    "halved where contacts begin to slip: within some per cent. Outputs have first derivatives by "
    "time.",
    "<b>Events and early returns</b> (Co-Simulation of FMI 3.0). With event mode, forces that "
    "jump are set there; without, between two steps, which does the same. Where early returns are "
    "allowed, a step that would leave the friction table ends where it does. An importer with an "
    "<b>intermediate update</b> is told of each internal step of a step, may read the outputs it "
    "named there, and end the step; in a step that is discarded they do not count.",
    "<b>Modal damping</b> and the <b>tolerance</b> may be tuned between steps and at events; the "
    "present amplitudes stay.",
    "A sweep that the importer makes by setting the frequency alone, its rate left at 0, leaves "
    "out the term i (d frequency / dt) a of the amplitude equations, which is small.",
    "FMI 3.0: the motion of all contact DOFs is there as arrays as well, <code>contact_x</code>, "
    "<code>contact_v</code>, <code>contact_f</code>.",
    "Both: amplitudes <code>A_re</code>, ... may be set before the start. States can be saved, "
    "restored and serialized; a continued run has the same bits.",
)


def index_html(
    name: str,
    model: Model,
    variables: Sequence[Variable],
    fmi: FmiVersion,
    version: str,
    findings: Sequence[Finding] = (),
) -> bytes:
    """The page that a tool opens as the FMU's documentation; it lists findings as warnings."""
    warnings = [
        escape(f"{each.subject} {each.choice}: {each.reason}")
        for each in findings
        if each.level != "info"
    ]
    sections = [
        f"<h1>{escape(name)}</h1>",
        f"<p>FMI {fmi}.0, Co-Simulation and Model Exchange, made by slipmode {version}.</p>",
        "<h2>Model</h2>",
        "<p>Amplitudes of forced modes of a structure with dry-friction contacts, in slow time. "
        "A modal displacement is q = a exp(i theta) + c.c., theta' the forcing frequency; "
        "friction enters by functions of the amplitudes that were tabulated beforehand.</p>",
        _table(("", ""), _facts(model)),
        "<h2>Use</h2>",
        _list(_USE),
        "<h2>Validity</h2>",
        _list((_contact_validity(model), _transient_validity(model), *_VALIDITY)),
        *(("<h2>Warnings</h2>", _list(warnings)) if warnings else ()),
        "<h2>Variables</h2>",
    ]
    header = ("Reference", "Name", "Description", "Unit", "Start")
    for causality in Causality:
        chosen = [v for v in variables if v.causality is causality]
        sections.append(f"<h3>{causality.value.capitalize()}</h3>")
        sections.append(_table(header, [_row(variables.index(v), v) for v in chosen]))
    page = (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(name)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(sections)
        + "\n</body>\n</html>\n"
    )
    return page.encode()


def contact_count(model: Model) -> int:
    """Contacts, each with one to three contact DOFs."""
    elements = model.reduced.contacts
    return model.reduced.n_contacts if elements is None else len(elements.element)


def _contact_validity(model: Model) -> str:
    if model.reduced.contacts is None:
        return "Contact motion is small against the modal motion; the contacts do not separate."
    return (
        "The modes are those of the structure whose contacts stick; two of them, at most, "
        "dominate the motion."
    )


def _transient_validity(model: Model) -> str:
    """Return what a change of the amplitudes within a cycle costs in accuracy, in words."""
    largest, carrier = model.table.amplitude_range[np.newaxis], model.reduced.carrier
    rate = 0.01 * largest * carrier.min() / (2.0 * np.pi)
    error = TransientError.of(model.reduced, model.law).at(rate, carrier, largest) / largest
    listed = ", ".join(f"{100 * part:.2g} %" for part in error[0])
    return (
        "Amplitudes change little within a cycle. Where contacts slip and all amplitudes change "
        "by 1 % of the range of the friction table in a cycle, their estimated error is up to "
        f"{listed} of it. Steady states do not have this error."
    )


def _facts(model: Model) -> list[tuple[str, ...]]:
    reduced, accuracy = model.reduced, model.accuracy
    combinations = ", ".join(f"{t.n:+d} A {t.m:+d} B" for t in model.combinations) or "none"
    return [
        ("Formulation", reduced.formulation),
        ("Natural frequencies", ", ".join(f"{f:.6g}" for f in reduced.frequency) + " rad/s"),
        ("Contacts", str(contact_count(model))),
        ("Contact law", "; ".join(law_words(model.law, reduced.n_contacts))),
        ("Combination resonances", combinations),
        (
            "Friction table",
            f"{model.table.node_a.size} x {model.table.node_b.size} amplitudes up to "
            + ", ".join(f"{value:g}" for value in model.table.amplitude_range)
            + f" kg^0.5 m; interpolation error {accuracy.interpolation:.1e}, "
            f"resolution error {accuracy.resolution:.1e} of the largest value",
        ),
        ("Content hash of the model", model.hash),
    ]


def _row(reference: int, variable: Variable) -> tuple[str, ...]:
    unit = (
        UNITS[variable.quantity.unit].name if variable.quantity and variable.quantity.unit else ""
    )
    start = "" if variable.start is None else literal(variable.start)
    return str(reference), variable.name, variable.description, unit, start


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [_cells("th", header)] if any(header) else []
    lines += [_cells("td", row) for row in rows]
    return "<table>\n" + "\n".join(lines) + "\n</table>"


def _cells(tag: str, row: Sequence[str]) -> str:
    return "<tr>" + "".join(f"<{tag}>{escape(text)}</{tag}>" for text in row) + "</tr>"


def _list(items: Sequence[str]) -> str:
    return "<ul>\n" + "\n".join(f"<li>{item}</li>" for item in items) + "\n</ul>"


def icon_png(size: int = 96) -> bytes:
    """A friction hysteresis loop, as a PNG picture."""
    y, x = np.mgrid[1 : -1 : size * 1j, -1 : 1 : size * 1j]
    inside = (np.abs(y) < 0.6) & (np.abs(x - 0.5 * y) < 0.55)
    within = (np.abs(y) < 0.5) & (np.abs(x - 0.5 * y) < 0.47)
    pixels = np.full((size, size, 3), 255, dtype=np.uint8)
    pixels[inside] = (31, 73, 125)
    pixels[within] = (198, 217, 241)
    rows = np.hstack((np.zeros((size, 1), dtype=np.uint8), pixels.reshape(size, -1)))
    header = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        _chunk(kind, data)
        for kind, data in (
            (b"IHDR", header),
            (b"IDAT", zlib.compress(rows.tobytes(), 9)),
            (b"IEND", b""),
        )
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    checksum = struct.pack(">I", zlib.crc32(kind + data))
    return struct.pack(">I", len(data)) + kind + data + checksum
