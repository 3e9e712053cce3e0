"""`slipmode scenes`."""

from __future__ import annotations

from argparse import Namespace

from slipmode.rom.errors import SlipmodeError
from slipmode.runner.commands import Argument, Command, print_next
from slipmode.runner.scene.keys import table_text
from slipmode.runner.scene.scene import load_scene, shipped_scenes


def commands() -> dict[str, Command]:
    """Return the command."""
    keys = "print the keys of a table of scene files: --keys run"
    return {
        "scenes": Command(
            _scenes,
            'scenes && cp "$(slipmode scenes --path two-mode)" mine.toml',
            Argument("--path", metavar="NAME", help="print where a shipped scene's file is"),
            Argument("--keys", metavar="TABLE", help=keys),
        )
    }


def _scenes(options: Namespace) -> int:
    shipped = shipped_scenes()
    if options.keys is not None:
        print(table_text(options.keys))
    elif options.path is not None:
        if options.path not in shipped:
            raise SlipmodeError(f"{options.path}: no such scene; scenes: {', '.join(shipped)}")
        print(shipped[options.path])
    else:
        width = max(len(name) for name in shipped)
        for name in shipped:
            print(f"{name:{width}}  {load_scene(name).title}")
        print_next("slipmode", "run", next(iter(shipped)))
    return 0
