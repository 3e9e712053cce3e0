"""`slipmode curve`, `slipmode backbone` and `slipmode design`."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.branches.forced import Varied
from slipmode.rom.slow.units import Shown
from slipmode.rom.storage.files import write_columns
from slipmode.runner.commands import OUTPUT, SCENE, Argument, Command, print_charts
from slipmode.runner.curves.scene_curves import (
    scene_backbone,
    scene_performance,
    scene_response_curve,
)
from slipmode.runner.pictures import check_pictures, page_figure
from slipmode.runner.plan.excited import displacement_shapes
from slipmode.runner.scene.scene import Scene, load_scene
from slipmode.runner.view.labels import units_of

_Curve = rom.ResponseCurve | rom.ToneCurve | rom.Backbone | rom.PerformanceCurve


def commands() -> dict[str, Command]:
    """Return the commands for curves."""
    of_dof = "the DOF whose amplitude is shown, in the scene's [units] (the one that moves most)"
    common = Argument("--dof", type=int, help=of_dof), SCENE, OUTPUT
    mode = Argument("--mode", choices=["A", "B"], help="one that is forced (the first)")
    vary = "a frequency, or a factor on the scene's forces or limits (first mode's frequency)"
    span = "in the scene's [units] (5 %% around the mode's own)"
    other = "|a| of the other mode meanwhile [kg^0.5 m] (0)"
    varied = [name for name in get_args(Varied) if name != "frequency"]
    return {
        "curve": Command(
            _curve,
            "curve two-mode --vary frequency_A --span 0.92 1.04 -o logs",
            Argument("--vary", choices=varied, help=vary),
            Argument("--span", nargs=2, type=float, metavar=("FROM", "TO"), help=span),
            Argument("--log", action="store_true", help="amplitudes on logarithmic axes"),
            *common,
        ),
        "backbone": Command(
            _backbone,
            "backbone two-mode --mode A -o logs",
            Argument("--other", type=float, default=0.0, help=other),
            mode,
            *common,
        ),
        "design": Command(_design, "design blade --mode A -o logs", mode, *common),
    }


def _curve(options: Namespace) -> int:
    check_pictures()
    scene = load_scene(options.scene)
    span = options.span
    if span is not None and not span[0] < span[1]:
        raise SlipmodeError("span: FROM must be below TO, got {:g} {:g}".format(*span))
    if span is not None and (options.vary or "frequency").startswith("frequency"):
        span = [end * scene.units.per_frequency for end in span]
    curve = scene_response_curve(scene, options.vary, span, progress=True)
    shown = _shown(options, scene, curve)
    name, along, points = _points(curve, shown)
    what, unit = name[:-1].split(" [")
    peaks: list[str] = []
    for mode, size in points.items():
        top = int(size.argmax())
        place = f"{along[top]:.4g} {unit}" if unit != "-" else f"{what} = {along[top]:.4g}"
        where = f" at {place}" if 0 < top < size.size - 1 else ""
        peaks.append(f"|{mode}| up to {size.max():.3g} {shown.units.displacement}{where}")
    files = _write(options, "curve", curve, scene, f"DOF {shown.dof}: {'; '.join(peaks)}")

    def listed(row: Iterable[float]) -> str:
        named = zip(points, row, strict=True)
        return ", ".join(f"{shown.named(f'|{mode}|')} = {size:.4g}" for mode, size in named)

    if isinstance(curve, rom.ResponseCurve):
        for point, sizes in zip(curve.special, curve.sizes(shown).special, strict=True):
            at = curve.in_units(point.parameter, scene.units)
            print(f"{point.kind} at {curve.vary} = {at:.6g}: {listed(sizes)}")
    print(f"largest: {listed(size.max() for size in points.values())}")
    print_charts(*files)
    return 0


def _points(
    curve: rom.ResponseCurve | rom.ToneCurve, shown: Shown
) -> tuple[str, Floats, dict[str, Floats]]:
    """Return the name of the parameter, its values in units, and amplitudes by mode."""
    units = shown.units
    if isinstance(curve, rom.ToneCurve):
        at = units.of_frequency(curve.frequency)
        return units.frequency_label, at, curve.sizes(shown)
    sizes = dict(zip("AB", curve.sizes(shown).points.T, strict=False))
    return curve.label(units), curve.in_units(curve.parameter, units), sizes


def _backbone(options: Namespace) -> int:
    check_pictures()
    scene = load_scene(options.scene)
    curve = scene_backbone(scene, options.mode, options.other, progress=True)
    low, high = (scene.units.of_frequency(f(curve.frequency)) for f in (np.min, np.max))
    damping = 100.0 * np.array([curve.damping.min(), curve.damping.max()])
    result = (
        f"Mode {'AB'[curve.mode]}: frequency changes by {percentage(float((high - low) / high))}, "
        "damping ratio from {:.2g} to {:.2g} %".format(*damping)
    )
    files = _write(options, "backbone", curve, scene, result)
    unit = scene.units.frequency
    print(f"frequency {low:.6g} to {high:.6g} {unit}, damping ratio to {curve.damping.max():.3g}")
    print_charts(*files)
    return 0


def _design(options: Namespace) -> int:
    check_pictures()
    scene = load_scene(options.scene)
    curve = scene_performance(scene, options.mode, progress=True)
    shown = _shown(options, scene, curve)
    limit, peak = curve.lowest(shown)
    ratio = percentage(peak / curve.size(shown)[-1])
    unit = shown.units.displacement
    cut = curve.is_cut_at_lowest(shown)
    result = (
        f"{'Peak' if cut else 'Lowest peak'} {peak:.3g} {unit} at {limit:.3g} times the scene's "
        f"limits{', where the curve ends' if cut else ''}: {ratio} of that of stuck contacts"
    )
    files = _write(options, "design", curve, scene, result)
    lowest = f"lowest {shown.named('peak')} = {peak:.4g}"
    if cut:
        print(
            f"{shown.named('peak')} = {peak:.4g} at {limit:.3g} times the scene's limits and "
            "preloads, where the curve ends: no optimum is known; smaller limits may be better"
        )
    elif peak >= 0.99 * curve.size(shown)[-1]:  # hardly below the peak of stuck contacts
        print(f"{lowest} where the contacts stick: no limit is better")
    else:
        low, high = curve.within(1.1, shown)
        equal = "{:.3g} to {:.3g} within the error".format(*curve.lowest_range(shown))
        print(f"{lowest} at {limit:.3g} ({equal}) times the scene's limits and preloads;")
        print(f"at most 10 % above it from {low:.3g} to {high:.3g} times")
    print_charts(*files)
    return 0


def _shown(options: Namespace, scene: Scene, curve: _Curve) -> Shown:
    """Return how amplitudes are shown: of `--dof`, or of the DOF of the largest motion."""
    modal = "kg^0.5 m"  # Rerun has no formulae
    if options.dof is not None:
        return Shown(options.dof, scene.units, modal)
    if isinstance(curve, rom.ToneCurve):
        reduced, amplitude = curve.response.reduced, curve.amplitude
    else:
        reduced, amplitude = curve.motion.model.reduced, curve.motion.amplitude
    moved = 2.0 * displacement_shapes(reduced) * np.abs(amplitude).max(axis=0)
    dof = int(moved.max(axis=1).argmax())
    length = units_of(scene.text, float(moved.max())).displacement
    return Shown(dof, replace(scene.units, displacement=length), modal)


def _write(
    options: Namespace,
    kind: str,
    curve: _Curve,
    scene: Scene,
    result: str,
) -> tuple[Path, Path]:
    """Write a table of numbers, a picture and a recording, and print their paths.

    Their names have the option `--vary` or `--mode`, if it is given. Returns the paths of the
    picture and the recording.
    """
    from slipmode.runner.curves.curve_charts import curve_charts
    from slipmode.runner.view.charts import write_charts

    shown, folder = _shown(options, scene, curve), options.output
    columns = curve.columns(shown.dof, shown.units)
    panels = 2 if isinstance(curve, rom.Backbone) else 1
    folder.mkdir(parents=True, exist_ok=True)
    logarithmic = kind == "curve" and options.log
    given = options.vary if kind == "curve" else options.mode
    name = ".".join(filter(None, (scene.name, kind, given)))
    table, picture, recording = (folder / f"{name}.{ending}" for ending in ("csv", "png", "rrd"))
    write_columns(table, columns)
    with page_figure(picture, result, 3.0 + panels) as figure:
        axes = curve.plot(figure.subplots(panels, sharex=True), shown.dof, shown.units)
        if logarithmic:
            axes.autoscale(axis="y")
            axes.set_yscale("log")
    title = f"{scene.title or scene.name}: {kind}"
    rows = curve_charts(curve, shown)
    if logarithmic:
        rows = [[replace(chart, y=replace(chart.y, log=True)) for chart in row] for row in rows]
    write_charts(recording, title, rows, {"Scene": f"```toml\n{scene.text}\n```"})
    for path in (table, picture, recording):
        print(path)
    return picture, recording
