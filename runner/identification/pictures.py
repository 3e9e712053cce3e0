"""Pictures of an identification: backbones, and decays or sine tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slipmode.rom import Identification, SineIdentification
from slipmode.rom.extras import extra
from slipmode.rom.identification import ORDERS, complex_rate, demodulate
from slipmode.rom.short_repr import percentage
from slipmode.runner.pictures import page_figure, write_beside

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def pictures(found: Identification | SineIdentification, folder: Path) -> Iterator[Path]:
    """Write the backbones, then the measured decays or sine tests; yield the paths."""
    modes = found.law.form.modes
    path = folder / "backbone.png"
    with page_figure(path, _damping(found), 5.0) as figure:
        axes = figure.subplots(2, modes, sharex="col", squeeze=False)
        found.plot(axes)
        axes[0, 0].get_legend().remove()  # records are named in the other picture
    yield path
    if isinstance(found, SineIdentification):
        path = folder / "sine_tests.png"
        with page_figure(path, _sine_errors(found), 5.0) as figure:
            _draw_sine_tests(found, figure)
    else:
        path = folder / "decays.png"
        with page_figure(path, _decay_errors(found), 5.0) as figure:
            _draw_decays(found, figure)
    yield path


def _damping(found: Identification | SineIdentification) -> str:
    """Return the measured range of the damping ratios."""
    parts = []
    for mode in range(found.law.form.modes):
        damping = 100.0 * found.backbone(mode).damping
        parts.append(f"{'AB'[mode]} {damping.min():.2g} to {damping.max():.2g} %")
    return f"Damping ratio in the measured range: {', '.join(parts)}"


def _sine_errors(found: SineIdentification) -> str:
    """Return the errors of the tests that were held out."""
    listed = [f"{x.test.name}: {percentage(x.error)} of the peak" for x in found.held_out]
    if not listed:
        return f"One law for {len(found.levels)} levels (lines) and the tests (points)"
    return f"Prediction of tests that were held out (dashed), {', '.join(listed)}"


def _decay_errors(found: Identification) -> str:
    """Return the mean error of the predictions from the first window."""
    for use in ("held out", "fitted"):
        errors = [each.error for each in found.records if each.use == use]
        if errors:
            mean = percentage(float(np.mean(errors)))
            return f"Decays from the first window: {len(errors)} {use}, mean error {mean}"
    return "Decays from the first window"


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
        color, ratio = f"C{k % 10}", size / force
        ax.semilogy(part.frequency, size / np.abs(part.force), f"{color}.", ms=4)
        ax.semilogy(part.frequency, ratio, color + style)
        top = int(np.argmax(ratio))
        write_beside(ax, (part.frequency[top], ratio[top]), test.name, color, above=True)
    ax.set_title("measured (points), law at the measured amplitudes (lines)")
    ax.set_ylabel(f"response / force [{found.unit}/N]")
    ax.set_xlabel("frequency [Hz]")
    _plain_scale(ax)


def _draw_decays(found: Identification, figure: Figure) -> None:
    """Draw the envelopes of all records and their predictions from the first window."""
    source, modes = found.source, found.law.form.modes
    channel = found.channels.index(found.channel)
    axes = figure.subplots(modes, sharex=True, squeeze=False)[:, 0]
    ends: dict[str, tuple[float, float, str]] = {}
    used = [record for record in found.records if record.use != "excluded"]
    for k, report in enumerate(used):
        made = found.predict(report.name, extrapolate=True)
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
            ax.semilogy(made.times, made.amplitude[:, mode], f"C{k % 10}{style}")
            if mode == 0:
                end = float(made.times[-1]), float(made.amplitude[-1, 0])
                ends[report.name] = (*end, f"C{k % 10}")
    for mode, ax in enumerate(axes):
        ax.set_ylabel(f"|{'AB'[mode]}| [{found.unit}]")
        ax.set_ylim(bottom=0.5 * found.range[mode, 0])
        _plain_scale(ax)
    figure.draw_without_rendering()  # places the axes
    _write_ends(axes[0], figure.get_figheight(), ends)
    axes[0].set_title("measured (points), predicted (lines), held out (dashed)")
    axes[-1].set_xlabel("time [s]")


def _plain_scale(ax: Axes) -> None:
    """Label 1, 2 and 5 on a logarithmic scale that has few powers of ten."""
    low, high = ax.get_ylim()
    if high < 30.0 * low:
        locator = extra("matplotlib.ticker", "pictures").LogLocator(subs=(1.0, 2.0, 5.0))
        ax.yaxis.set_major_locator(locator)
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter("")


def _write_ends(ax: Axes, height: float, ends: dict[str, tuple[float, float, str]]) -> None:
    """Name curves at their ends (time, size, colour) in a figure of some height [inch].

    Names stand a line apart.
    """
    low, high = ax.get_ylim()
    line = 1.2 * 9.0 / 72.0 / (ax.get_position().height * height)  # relative to the axes
    apart = line * np.log(high / low)
    last = -np.inf
    for name, (time, size, color) in sorted(ends.items(), key=lambda each: each[1][1]):
        last = max(np.log(size), last + apart)
        write_beside(ax, (time, float(np.exp(last))), name, color)
