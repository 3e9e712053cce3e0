"""What the views show, in words that stand beside them."""

from __future__ import annotations

from collections.abc import Iterable

_WORDS = {
    "|A|": "**|A|, |B|**: amplitudes of the two modes in slow time. The displacement of a DOF is "
    "`2 Re(phi A exp(i theta))`, so that a mass-normalised mode moves by twice its amplitude.",
    "Mode A": "**Mode A, Mode B**: complex amplitudes in their planes. The angle is the phase "
    "against the forcing; a steady state is a point.",
    "over its frequency": "**|A| over its frequency**: amplitude against forcing frequency as the "
    "sweep went on. It lags behind the steady response curve where the sweep is quick.",
    "Hysteresis": "**Hysteresis**: friction force against displacement of a contact. The area of "
    "a loop is the energy it takes out in a cycle; steep sides are sticking, level ones sliding.",
    "Orbit": "**Orbit**: displacement of a contact in its plane.",
    "Contacts": "**Contacts**: displacement of one contact against that of another.",
    "over the phases": "**Contact over the phases of both carriers**: while amplitudes stand "
    "still, the motion of a contact depends on two angles alone, the phases of both forcings. The "
    "height of the surface is its displacement there, the colour its friction force: orange "
    "slides one way, blue the other, grey is without force. The white point is the motion itself: "
    "it crosses the square again and again, and comes back at the opposite edge.",
    "stuck": "**State**: 0 while a contact sticks, 1 while it slips, 2 while it is open.",
}


def reading(titles: Iterable[str]) -> str:
    """Markdown that explains the views with such titles, and how to move through time."""
    shown = list(titles)
    found = [words for part, words in _WORDS.items() if any(part in title for title in shown)]
    last = (
        "Time runs below: drag it or press space. Drag in a plot to move it, scroll to zoom, "
        "double-click to see all of it."
    )
    return "\n\n".join([*found, last])
