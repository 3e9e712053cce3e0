"""`slipmode explore`."""

from __future__ import annotations

import shlex
from argparse import Namespace
from pathlib import Path

from slipmode.runner.commands import SCENE, Argument, Command
from slipmode.runner.explore.explore import HEADROOM, SCALED, explore


def commands() -> dict[str, Command]:
    """Return the command."""
    reach = (
        "amplitudes that it holds for, relative to what the scene needs: more to force it harder, "
        f"or with less friction ({HEADROOM:g}; {SCALED:g} where friction limits can be scaled)"
    )
    return {
        "explore": Command(
            _explore,
            "explore blade -o blade.html --open",
            SCENE,
            Argument("-o", "--output", type=Path, help="the .html file (SCENE.html)"),
            Argument("--range", type=float, metavar="FACTOR", help=reach),
            Argument("--open", action="store_true", help="open it in a browser"),
        ),
    }


def _explore(options: Namespace) -> int:
    path = explore(
        options.scene,
        options.output,
        headroom=options.range,
        show=options.open,
        progress=True,
    )
    print(path)
    if not options.open:
        print(f"next:  open {shlex.quote(str(path))} in a browser")
    return 0
