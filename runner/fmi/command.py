"""`slipmode fmu`, with --ssp too."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

HEADROOM = 1.25  # forces a tenth above those of the shipped scenes reach up to 1.19 times as far


def add_fmu_command(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add it; `command(name, call, help, example)` makes a parser."""
    fmu = command(
        "fmu", _fmu, "export a scene's model as an FMU", "fmu two-mode -o two-mode.fmu --fmi 2"
    )
    fmu.add_argument("scene", help="a scene file, or the name of a shipped scene")
    fmu.add_argument("-o", "--output", type=Path, help="the .fmu file (SCENE.fmu)")
    fmu.add_argument("--fmi", type=int, choices=(2, 3), default=3, help="FMI 2.0 or 3.0 (3)")
    fmu.add_argument(
        "--range",
        type=float,
        default=HEADROOM,
        metavar="FACTOR",
        help="amplitudes that it holds for, relative to what the scene needs: more for importers "
        f"that force it harder ({HEADROOM:g}: the shipped scenes' forces and a tenth more)",
    )
    fmu.add_argument(
        "--contacts",
        action="store_true",
        help="contacts as outputs, without a window of the scene",
    )
    for what in ("author", "copyright", "license"):
        fmu.add_argument(f"--{what}", metavar="TEXT", help="of the model (nothing is said)")
    fmu.add_argument("--dated", action="store_true", help="say when it was made")
    fmu.add_argument(
        "--ssp",
        action="store_true",
        help="in a system structure package, with start values and units (SCENE.ssp)",
    )
    fmu.add_argument(
        "--platforms",
        nargs="+",
        default=[],
        metavar="PLATFORM",
        help="besides this machine's: x86_64-linux, aarch64-linux, x86_64-windows, x86_64-darwin, "
        "aarch64-darwin",
    )


def _fmu(options: argparse.Namespace) -> int:
    from slipmode.fmu.description.options import Origin
    from slipmode.runner.fmi.export import export_fmu
    from slipmode.runner.scene.scene import load_scene

    now = datetime.now(UTC) if options.dated else None
    origin = Origin(options.author, options.copyright, options.license, now)
    arguments: dict[str, Any] = {
        "fmi": options.fmi,
        "platforms": options.platforms,
        "headroom": options.range,
        "contacts": options.contacts,
        "origin": origin,
        "progress": True,
    }
    if options.ssp:
        from slipmode.runner.fmi.ssp import export_ssp  # it reads the FMU by FMPy

        scene = load_scene(options.scene)
        print(export_ssp(scene, options.output or Path(f"{scene.name}.ssp"), **arguments))
    else:
        print(export_fmu(options.scene, options.output, **arguments))
    return 0
