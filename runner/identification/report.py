"""The report of an identification, for people."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap

import numpy as np

from slipmode.rom import Identification, IdentifiedLaw, SineIdentification, SlipmodeError
from slipmode.rom.short_repr import percentage

# 0.3 MB of the FMU of one mode, 7 MB of two modes
_SAMPLES = 40
_UNITS = {"limit": "N/kg", "delta_0": "1/s", "g": "1/s", "omega_0": "rad/s", "h": "rad/s"}


def report(found: Identification | SineIdentification, modal_mass: Sequence[float] | None) -> str:
    """Return the report: records, law, parameters with intervals, errors of predictions."""
    measured = _levels(found) if isinstance(found, SineIdentification) else _records(found)
    parts = [measured, _law(found), _parameters(found), _modes(found)]
    if isinstance(found, Identification):
        mass = "1 kg, not measured: forces on the model are relative to it"
        if modal_mass is not None:
            mass = f"{', '.join(f'{each:g}' for each in modal_mass)} kg"
        parts.append(f"modal mass at {found.channel}: {mass}")
    parts.append(model_samples(found)[1])
    return "\n\n".join(parts)


def model_samples(found: IdentifiedLaw) -> tuple[int, str]:
    """Return how many samples of the posterior the model gets, in words too."""
    try:
        found.samples(_SAMPLES)
    except SlipmodeError as refused:
        return 0, f"no samples in the model; {refused}"
    return _SAMPLES, f"{_SAMPLES} samples of the parameters in the model: runs have a band"


def _records(found: Identification) -> str:
    unit, modes = found.unit, "AB"[: found.law.form.modes]
    width = max(len("record"), *(len(record.name) for record in found.records))
    sizes = "".join(f"{f'{mode} [{unit}]':>13}" for mode in modes)
    lines = [f"{'record':{width}}  {'use':8}  {'used [s]':>14}{sizes}  error of prediction"]
    for r in found.records:
        line = f"{r.name:{width}}  {r.use:8}"
        if r.use != "excluded":
            sizes = "".join(f"{size:13.4g}" for size in r.amplitude)
            line += f"  {f'{r.start:.3g} to {r.end:.3g}':>14}{sizes}  {percentage(r.error)}"
        lines += [line, *(f"    {note}" for note in r.notes)]
    for use in ("fitted", "held out"):
        errors = [r.error for r in found.records if r.use == use]
        if errors:
            mean = percentage(float(np.mean(errors)))
            lines.append(f"{len(errors)} {use}: mean error {mean} from the first window")
    return "\n".join(lines)


def _levels(found: SineIdentification) -> str:
    names = [x.name for x in found.levels] + [x.test.name for x in found.held_out]
    width = max(len("level"), *map(len, names))
    ratios_head = "".join(f"{x:>10}" for x in ("damping", "from law", "by others", "no phase"))
    head = f"{f'amplitude [{found.unit}]':>18}{'frequency':>12}{ratios_head}{'phase error':>12}"
    lines = [f"{'level':{width}} {head}"]
    for x, misfit in zip(found.levels, found.misfit, strict=True):
        ratios = (x.left_out_damping, x.damping_without_phase)
        damping = f"{100 * x.damping:8.4f} %{100 * misfit:+8.2f} %"
        damping += "".join(f"{100 * each:8.4f} %" for each in ratios)
        frequency = f"{x.frequency / (2.0 * np.pi):9.5g} Hz"
        line = f"{x.name:{width}} {x.amplitude:18.4g}{frequency}{damping}"
        lines.append(f"{line}{x.phase_error:8.3f} rad")
    lines += [
        "damping from law: its relative deviation from the law of all levels, up to "
        f"{percentage(float(np.abs(found.misfit).max()))}",
        "damping by others: prediction by the law of the other levels",
        "damping no phase: from a fit without phase error of the channels",
        f"natural frequencies scatter by {found.frequency_scatter / (2.0 * np.pi):.3g} Hz",
    ]
    for each in found.held_out:
        line = f"{each.test.name:{width}}  held out: error {percentage(each.error)} of the peak"
        lines.append(f"{line}, peak {100 * each.peak_error:+.2g} %")
    tests = [*found.tests, *(each.test for each in found.held_out)]
    lines += [f"{test.name}: {note}" for test in tests for note in test.notes]
    return "\n".join(lines)


def _law(found: IdentifiedLaw) -> str:
    form, unit = found.law.form, found.unit
    lines = [f"law: {form}"]
    if isinstance(found, Identification) and found.deviations:
        every = len(found.deviations) == form.modes
        lines = [f"law: none is claimed; the closest is {form}" if every else lines[0]]
        lines += [f"    not claimed: {line}" for line in found.deviations]
    if isinstance(found, Identification) and found.errors:
        errors = (f"{each} {percentage(error)}" for each, error in found.errors.items())
        listed = f"prediction errors of loud records by fits to the others: {', '.join(errors)}"
        lines += wrap(listed, 95, initial_indent="    ", subsequent_indent="        ")
    if form.law == "linear":
        return "\n".join(lines)
    rates = "delta_0 + g (s / R)^p, frequency omega_0 - h (s / R)^p"
    if form.law == "coulomb":
        rates = "delta_0 + g R / s (constant friction force), frequency omega_0"
    if form.kind == "macro-slip":
        slip = f"{found.law.slip_amplitude:.4g} {unit}, seen from {found.range[0, 0]:.3g}"
        lines.append(f"    the joint slips completely above s = {slip} to {found.range[0, 1]:.3g}")
        rates = "delta_0 + g R / s, frequency omega_0 - h far above; omega_0 in stick"
    lines.append(f"    damping rate {rates}")
    if form.cross:
        lines.append("    s_A^2 = A^2 + kappa_A B^2, s_B^2 = B^2 + kappa_B A^2")
    sizes = zip("AB", found.law.reference, strict=False)
    lines.append("    " + ", ".join(f"R_{mode} = {size:.4g} {unit}" for mode, size in sizes))
    return "\n".join(lines)


def _parameters(found: IdentifiedLaw) -> str:
    lines = [f"{'parameter':10}  {'value':>10}  {'95 % interval':>22}"]
    for name, value in found.parameters.items():
        low, high = found.interval[name]
        digits = _digits(high - low)
        interval = "open" if name in found.unidentified else "needs three records"
        if np.isfinite(high):
            interval = f"{low:.{digits}f} to {high:.{digits}f}"
        unit = "kg" if name == "modal_mass" else _UNITS.get(name.rpartition("_")[0], "-")
        if "q_" in name:
            unit = f"1/s per {found.unit}"
        lines.append(f"{name:10}  {value:10.{digits}f}  {interval:>22}  {unit}")
    scattered = any(np.isfinite(each) for each in found.deviation.values())
    nothing = "none" if scattered else "unknown with fewer than three fitted records"
    lines.append(f"not identified: {', '.join(found.unidentified) or nothing}")
    return "\n".join(lines)


def _digits(width: float) -> int:
    """Return the decimal places that show two digits of the width of an interval."""
    if not 0.0 < width < np.inf:
        return 4
    return min(max(1 - int(np.floor(np.log10(width))), 0), 8)


def _modes(found: IdentifiedLaw) -> str:
    lines = []
    for mode in range(found.law.form.modes):
        curve = found.backbone(mode)
        hertz = curve.frequency / (2.0 * np.pi)
        low, high = curve.amplitude[[0, -1]]
        lines.append(
            f"mode {'AB'[mode]}: {hertz[0]:.5g} to {hertz[-1]:.5g} Hz, damping ratio "
            f"{curve.damping[0]:.3g} to {curve.damping[-1]:.3g}, at {low:.3g} to {high:.3g} "
            f"{curve.unit} of {found.channel}"
        )
    return "\n".join(lines)
