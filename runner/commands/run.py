"""`slipmode run` and `slipmode validate`."""

from __future__ import annotations

import logging
from argparse import Namespace
from pathlib import Path

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import percentage
from slipmode.runner.commands import OUTPUT, SCENE, Argument, Command, print_next
from slipmode.runner.run import run
from slipmode.runner.validation.validate import validate
from slipmode.runner.view.viewer import find_viewer

_log = logging.getLogger("slipmode")


def commands() -> dict[str, Command]:
    """Return the commands that run a scene."""
    live = (
        "show it in Rerun while it runs: in a new viewer, or in one that listens there: "
        "run two-mode --live rerun+http://127.0.0.1:9876/proxy"
    )
    fmu = "let an FMU of the scene do the steps: run two-mode --fmu two-mode.fmu"
    return {
        "run": Command(
            _run,
            "run two-mode -o logs",
            Argument("--fmu", type=Path, metavar="FILE", help=fmu),
            Argument("--live", nargs="?", const="", metavar="URL", help=live),
            SCENE,
            OUTPUT,
        ),
        "validate": Command(_validate, "validate two-mode", SCENE, OUTPUT),
    }


def _run(options: Namespace) -> int:
    live = None
    if options.live is not None:
        try:
            live = find_viewer(options.live or None)
        except SlipmodeError as error:
            _log.warning("%s; recorded without it: see slipmode replay", error)
    recording = run(options.scene, options.output, fmu=options.fmu, live=live, progress=True)
    source = "from the cache" if recording.cached else "computed"
    source = "from model.file" if recording.plan.scene.saved_model else source
    before, steps = "friction table", "slow time"
    if recording.model is None:
        steps = "full order" if recording.plan.kind == "full order" else "slow time"
        before, source = "plan", "no friction table"
    print(f"{recording.plan.scene.title}: {recording.plan.scene.run.duration:g} s")
    print(f"  {before:14}   {recording.table_seconds * 1e3:8.1f} ms  ({source})")
    taken = f"{recording.steps} steps"
    if share := recording.plan.full_order_share:
        taken += f", with full order in about {percentage(share)} of the time"
    print(f"  {steps:14}   {recording.slow_seconds * 1e3:8.1f} ms  ({taken})")
    included = f"{recording.samples} samples of fast motion, recordings included"
    print(f"  in all           {recording.total_seconds * 1e3:8.1f} ms  ({included})")
    for path in (recording.mcap, recording.rrd):
        if path:
            print(f"  {path}  ({path.stat().st_size / 1024:.0f} KiB)")
    if recording.mcap:
        print_next("slipmode", "replay", recording.mcap)
    elif recording.rrd:
        print_next("rerun", recording.rrd)
    return 0


def _validate(options: Namespace) -> int:
    found = validate(options.scene, options.output, progress=True)
    print(found.compared())
    print("relative error            reduced   full order at half its resolution")
    for line in found.comparisons:
        print(f"{line.subject:30}{line.error:9.2e}  {line.reference_error:9.2e}")
    before = "friction table" if found.reduced == "slow time" else "plan"
    print(
        f"time: {found.reduced} {found.slow_seconds * 1e3:.1f} ms (and {before} "
        f"{found.table_seconds * 1e3:.0f} ms), full order {found.full_seconds * 1e3:.1f} ms "
        f"on {found.coordinates} coordinates"
    )
    for path in found.recordings:
        print(path)
    print_next("slipmode", "replay", found.recordings[0])
    return 0
