"""Pictures of an identification: backbones, and decays or sine tests."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from slipmode.rom import Identification, SineIdentification
from slipmode.rom.extras import extra
from slipmode.rom.identification.first_look import demodulate
from slipmode.rom.identification.sine.levels import complex_rate
from slipmode.rom.identification.sine.responses import ORDERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def pictures(found: Identification | SineIdentification) -> Iterator[tuple[str, Figure]]:
    """Yield the names and figures: the backbones, then the measured decays or sine tests."""
    modes = found.law.form.modes
    figures = extra("matplotlib.figure", "pictures")
    backbones, tests = (figures.Figure(figsize=(9, 7), layout="constrained") for _ in range(2))
    found.plot(backbones.subplots(2, modes, sharex="col", squeeze=False))
    yield "backbone", backbones
    if isinstance(found, SineIdentification):
        _draw_sine_tests(found, tests)
        yield "sine_tests", tests
    else:
        _draw_decays(found, tests)
        yield "decays", tests


def _draw_sine_tests(found: SineIdentification, figure: Figure) -> None:
    """Draw frequency responses, and those of the law at the measured amplitudes.

    Each test has its own natural frequency, because these scatter between tests.
    """
    ax, natural = figure.subplots(), float(found.law.values[1])
    lines = [
        (test, x.frequency - float(complex_rate(found.law, x.amplitude).imag), "-")
        for test, x in zip(found.tests, found.levels, strict=True)
    ]
    lines += [(each.test, each.frequency - natural, "--") for each in found.held_out]
    for k, (test, change, style) in enumerate(lines):
        part = test.within(found.band)
        size, omega = np.abs(part.response), 2.0 * np.pi * part.frequency
        force = found.models[0].shifted(change).force(omega, size, ORDERS[found.unit])
        label = test.name + (", held out" if style == "--" else "")
        ax.semilogy(part.frequency, size / np.abs(part.force), f"C{k % 10}.", ms=3)
        ax.semilogy(part.frequency, size / force, f"C{k % 10}{style}", label=label)
    ax.set_title("measured response / force (points), law at the measured amplitudes (lines)")
    ax.set_ylabel(f"response / force [{found.unit}/N]")
    ax.set_xlabel("frequency [Hz]")
    ax.legend(fontsize="small", ncols=2)


def _draw_decays(found: Identification, figure: Figure) -> None:
    """Draw the envelopes of all records and their predictions from the first window."""
    source, modes = found.source, found.law.form.modes
    channel = found.channels.index(found.channel)
    axes = figure.subplots(modes, sharex=True, squeeze=False)[:, 0]
    used = [record for record in found.records if record.use != "excluded"]
    for k, report in enumerate(used):
        made = found.predict(report.name, extrapolate=True)
        label = report.name + (", held out" if report.use == "held out" else "")
        style = "--" if report.use == "held out" else "-"
        for mode, ax in enumerate(axes):
            measured = demodulate(
                made.record.signal,
                made.record.sample_rate,
                source.look.carrier[mode],
                source.plan.bands[mode],
            )
            size = np.abs(measured.values[channel])
            chosen = slice(None, None, max(size.size // 100, 1))
            ax.semilogy(measured.times[chosen], size[chosen], f"C{k % 10}.", ms=3)
            ax.semilogy(made.times, made.amplitude[:, mode], f"C{k % 10}{style}", label=label)
    for mode, ax in enumerate(axes):
        ax.set_ylabel(f"|{'AB'[mode]}| [{found.unit}]")
        ax.set_ylim(bottom=0.5 * found.range[mode, 0])
    axes[0].set_title("measured envelopes (points), predictions from the first window (lines)")
    axes[0].legend(fontsize="small", ncols=3)
    axes[-1].set_xlabel("time [s]")
