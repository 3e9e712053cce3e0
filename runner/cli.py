"""The command line: slipmode run, plan, scenes and others; more commands are in their rooms."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from slipmode.rom import __version__
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import percentage
from slipmode.rom.table import disk_cache
from slipmode.runner.commands import OUTPUT, SCENE, Argument, overview, print_next
from slipmode.runner.commands.command_words import command_words
from slipmode.runner.commands.curves import add_curve_commands
from slipmode.runner.commands.diameters import add_diameters_command
from slipmode.runner.commands.identify import add_identify_command
from slipmode.runner.commands.mode_table import is_scene, mode_table
from slipmode.runner.commands.recordings import add_recording_commands
from slipmode.runner.commands.scenes import add_scenes_command
from slipmode.runner.commands.study import add_study_command
from slipmode.runner.explore.command import add_explore_command
from slipmode.runner.fmi.command import add_fmu_command
from slipmode.runner.messages import warnings_to
from slipmode.runner.plan.mistuned import plan_scene
from slipmode.runner.plan.plan import Plan
from slipmode.runner.run import run
from slipmode.runner.scene.scene import load_scene
from slipmode.runner.transients.passes import integration_cost
from slipmode.runner.view.viewer import find_viewer

_log = logging.getLogger("slipmode")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0, or 1 after one line on standard error with the reason."""
    options = _parser().parse_args(arguments)
    try:
        with _warnings_shown():
            return int(options.command(options))
    except SlipmodeError as error:
        return _fail(command_words(str(error), vars(options)))
    except MemoryError as error:
        return _fail(f"out of memory: {error}" if str(error) else "out of memory")
    except BrokenPipeError:  # `slipmode ... | head` closes the pipe early
        sys.stdout = None
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _fail(f"{where}{error.strerror or error}")
    except KeyboardInterrupt:
        print("slipmode: interrupted; a recording is readable as far as it got", file=sys.stderr)
        return 130  # what a shell reports after Ctrl-C


@contextmanager
def _warnings_shown() -> Iterator[None]:
    """Print each warning once, in one line on standard error, inside the context."""
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("slipmode: warning: %(message)s"))
    shown: set[str] = set()

    def is_new(record: logging.LogRecord) -> bool:
        record.msg, record.args = command_words(record.getMessage()), ()
        known = record.msg in shown
        shown.add(record.msg)
        return not known

    handler.addFilter(is_new)
    with warnings_to(handler):
        yield


def _fail(message: str) -> int:
    print(f"slipmode: {' '.join(message.split())}", file=sys.stderr)
    return 1


def _run(options: argparse.Namespace) -> int:
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
        steps = "full order" if isinstance(recording.plan, Plan) else "slow time"
        before, source = "plan", "no friction table"
    print(f"{recording.plan.scene.title}: {recording.plan.scene.run.duration:g} s")
    print(f"  {before:14}   {recording.table_seconds * 1e3:8.1f} ms  ({source})")
    taken = f"{recording.steps} steps"
    if isinstance(recording.plan, Plan) and (share := recording.plan.full_order_share):
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


def _plan(options: argparse.Namespace) -> int:
    plan = plan_scene(load_scene(options.scene), progress=True)
    shown = [d for d in plan.decisions if d.level == "info"]
    if isinstance(plan, Plan) and plan.may_be_integrated:
        shown += integration_cost(plan)
    rows = [(d.subject, d.choice, d.reason) for d in shown]
    widths = [max(len(row[k]) for row in rows) for k in range(2)]
    for subject, choice, reason in rows:
        print(f"{subject:{widths[0]}}  {choice:{widths[1]}}  {reason}")
    for warning in plan.warnings:
        print(f"warning: {warning}")
    print_next("slipmode", "run", options.scene)
    return 0


def _modes(options: argparse.Namespace) -> int:
    chosen = options.mass, options.contact, options.stiffness, options.number
    parts = ("mass", "stiffness", "damping")
    names = {part: name for part in parts if (name := getattr(options, f"{part}_name"))}
    print(mode_table(options.file, *chosen, names=names))
    if is_scene(options.file):
        print_next("slipmode", "curve", options.file)
    else:
        print_next("slipmode", "scenes", "--keys", "structure")
    return 0


def _validate(options: argparse.Namespace) -> int:
    from slipmode.runner.validation.validate import validate  # Rerun takes a while to import

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


def _cache(options: argparse.Namespace) -> int:
    entries = disk_cache.entries()
    size = sum(entries.values()) / disk_cache.MIB
    print(disk_cache.folder())
    if options.clear:
        disk_cache.clear()
        print(f"  removed {len(entries)} files, {size:.1f} MiB")
    else:
        most = disk_cache.bound() / disk_cache.MIB
        print(f"  {len(entries)} files, {size:.1f} of at most {most:g} MiB")
        print_next("slipmode", "cache", "--clear")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="slipmode",
        usage="slipmode [-h] [--version] COMMAND ...",
        epilog="example: slipmode run two-mode -o logs && slipmode replay logs/two-mode.mcap",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"slipmode {__version__}")
    commands = parser.add_subparsers(
        prog="slipmode", required=True, metavar="COMMAND", help=argparse.SUPPRESS
    )
    summaries: dict[str, str] = {}

    def add(
        name: str,
        function: Callable[[argparse.Namespace], int],
        summary: str,
        example: str,
        *arguments: Argument,
    ) -> argparse.ArgumentParser:
        command = commands.add_parser(
            name, description=summary, epilog=f"example: slipmode {example}"
        )
        summaries[name] = summary
        for each in arguments:
            command.add_argument(*each.names, **each.options)
        command.set_defaults(command=function)
        return command

    live = (
        "show it in Rerun while it runs: in a new viewer, or in one that listens there: "
        "run two-mode --live rerun+http://127.0.0.1:9876/proxy"
    )
    fmu = "let an FMU of the scene do the steps: run two-mode --fmu two-mode.fmu"
    add(
        "run",
        _run,
        "run a scene and record it",
        "run two-mode -o logs",
        Argument("--fmu", type=Path, metavar="FILE", help=fmu),
        Argument("--live", nargs="?", const="", metavar="URL", help=live),
        SCENE,
        OUTPUT,
    )
    add(
        "plan",
        _plan,
        "what the reduced model of a scene must include, and why",
        "plan sweep",
        SCENE,
    )
    contact = "DOFs, or NODE:DIRECTION, or NODE-NODE:DIRECTION of two that touch"
    add(
        "modes",
        _modes,
        "modes of a scene or structure, and their motion at the contacts",
        "modes job_STIF2.mtx --contact 4711:z 12-13:x --stiffness 1e7",
        Argument("file", help="a scene, or a file of matrices (see rom.load_structure)"),
        Argument("--mass", type=Path, help="file of the mass matrix, if it is separate"),
        Argument("--mass-name", metavar="NAME", help="its name in a file with several matrices"),
        Argument("--stiffness-name", metavar="NAME", help="name of the stiffness matrix"),
        Argument("--damping-name", metavar="NAME", help="name of the damping matrix"),
        Argument("--contact", nargs="+", metavar="WHERE", help=contact),
        Argument("--stiffness", type=float, help="of elastic contacts [N/m] (bonded)"),
        Argument("-n", "--number", type=int, default=10, help="number of modes (10)"),
    )
    add_curve_commands(add)
    add_diameters_command(add)
    add_study_command(add)
    add_identify_command(add)
    add_recording_commands(add)
    add(
        "validate",
        _validate,
        "compare a run of a scene with full-order integration",
        "validate two-mode",
        SCENE,
        OUTPUT,
    )
    add_fmu_command(add)
    add_explore_command(add)
    add_scenes_command(add)
    add(
        "cache",
        _cache,
        "folder and size of the cache of friction tables and reductions",
        "cache --clear",
        Argument("--clear", action="store_true", help="remove them all"),
    )
    parser.description = "\n\n".join(overview(summaries))
    return parser
