"""`slipmode curve`, `slipmode backbone` and `slipmode design`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.extras import extra
from slipmode.rom.slow.units import Shown

if TYPE_CHECKING:
    from slipmode import rom
    from slipmode.runner.scene.sections import Scene

_MODAL = "kg^0.5 m"
_IMPROVEMENT = 0.99  # of the stuck peak, above which a peak is no improvement worth a number


def add_curve_commands(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the commands; `command(name, call, help, example)` makes a parser."""
    from slipmode.rom.slow.branches.forced import Varied

    curve = command(
        "curve",
        _curve,
        "steady states against a frequency, a force or the friction limit, with stability",
        "curve two-mode --vary frequency_A --span 0.92 1.04 -o logs",
    )
    curve.add_argument(
        "--vary",
        choices=[name for name in get_args(Varied) if name != "frequency"],
        help="a frequency, or a factor on the scene's forces or limits (first mode's frequency)",
    )
    curve.add_argument(
        "--span",
        nargs=2,
        type=float,
        metavar=("FROM", "TO"),
        help="in the scene's [units] (5 %% around the mode's own)",
    )
    backbone = command(
        "backbone",
        _backbone,
        "frequency and damping of a mode against its amplitude",
        "backbone two-mode --mode A -o logs",
    )
    backbone.add_argument(
        "--other", type=float, default=0.0, help="|a| of the other mode meanwhile [kg^0.5 m] (0)"
    )
    design = command(
        "design",
        _design,
        "resonance peak of a mode against friction limits and preloads, and the best of them",
        "design blade --mode A -o logs",
    )
    for parser in (backbone, design):
        parser.add_argument("--mode", choices=["A", "B"], help="one that is forced (the first)")
    for parser in (curve, backbone, design):
        parser.add_argument(
            "--dof",
            type=int,
            help="the amplitude of a DOF, contacts included, in the scene's [units]",
        )
        parser.add_argument("scene", help="a scene file, or the name of a shipped scene")
        parser.add_argument(
            "-o", "--output", type=Path, default=Path("logs"), help="folder (logs)"
        )


def _curve(options: argparse.Namespace) -> int:
    from slipmode.runner.curves.scene_curves import scene_response_curve
    from slipmode.runner.scene.scene import load_scene

    scene = load_scene(options.scene)
    units, span = scene.units, options.span
    of_frequency = options.vary is None or options.vary.startswith("frequency")
    if span is not None and of_frequency:
        span = [end * units.per_frequency for end in span]
    curve = scene_response_curve(scene, options.vary, span, progress=True)
    _write(options, "curve", curve, scene)
    shown = Shown(options.dof, units, _MODAL)
    sizes, modes = curve.sizes(shown), "AB"[: curve.amplitude.shape[1]]

    def listed(row: Floats) -> str:
        named = zip(modes, row, strict=True)
        return ", ".join(f"{shown.named(f'|{mode}|')} = {size:.4g}" for mode, size in named)

    for point, size in zip(curve.special, sizes.special, strict=True):
        at = float(units.of_frequency(point.parameter)) if of_frequency else point.parameter
        print(f"{point.kind} at {curve.vary} = {at:.6g}: {listed(size)}")
    print(f"largest: {listed(sizes.points.max(axis=0))}")
    return 0


def _backbone(options: argparse.Namespace) -> int:
    from slipmode.runner.curves.scene_curves import scene_backbone
    from slipmode.runner.scene.scene import load_scene

    scene = load_scene(options.scene)
    curve = scene_backbone(scene, options.mode, options.other, progress=True)
    _write(options, "backbone", curve, scene, panels=2)
    low, high = (scene.units.of_frequency(f(curve.frequency)) for f in (np.min, np.max))
    unit = scene.units.frequency
    print(f"frequency {low:.6g} to {high:.6g} {unit}, damping ratio to {curve.damping.max():.3g}")
    return 0


def _design(options: argparse.Namespace) -> int:
    from slipmode.runner.curves.scene_curves import scene_performance
    from slipmode.runner.scene.scene import load_scene

    scene = load_scene(options.scene)
    curve = scene_performance(scene, options.mode, progress=True)
    _write(options, "design", curve, scene)
    shown = Shown(options.dof, scene.units, _MODAL)
    limit, peak = curve.lowest(shown)
    lowest = f"lowest {shown.named('peak')} = {peak:.4g}"
    if peak >= _IMPROVEMENT * curve.size(shown)[-1]:
        print(f"{lowest} where the contacts stick: no limit is better")
        return 0
    low, high = curve.within(1.1, shown)
    equal = "{:.3g} to {:.3g} within the error".format(*curve.lowest_range(shown))
    print(f"{lowest} at {limit:.3g} ({equal}) times the scene's limits and preloads;")
    print(f"at most 10 % above it from {low:.3g} to {high:.3g} times")
    return 0


def _write(
    options: argparse.Namespace,
    kind: str,
    curve: rom.ResponseCurve | rom.Backbone | rom.PerformanceCurve,
    scene: Scene,
    panels: int = 1,
) -> None:
    """Write a table of numbers, a picture and a recording, and print their paths."""
    from slipmode.runner.curves.curve_charts import curve_charts
    from slipmode.runner.view.charts import write_charts

    units, folder = scene.units, options.output
    columns = curve.columns(options.dof, units)
    figure = extra("matplotlib.figure", "pictures").Figure(
        figsize=(8, 4 + panels), layout="constrained"
    )
    curve.plot(figure.subplots(panels, sharex=True), options.dof, units)
    folder.mkdir(parents=True, exist_ok=True)
    table, picture, recording = (
        folder / f"{scene.name}.{kind}.{ending}" for ending in ("csv", "png", "rrd")
    )
    numbers = np.column_stack(list(columns.values()))
    np.savetxt(table, numbers, delimiter=",", header=",".join(columns), comments="")
    figure.savefig(picture, dpi=120)
    title = f"{scene.title or scene.name}: {kind}"
    rows = curve_charts(curve, Shown(options.dof, units, _MODAL))
    write_charts(recording, title, rows, {"Scene": f"```toml\n{scene.text}\n```"})
    for path in (table, picture, recording):
        print(path)
