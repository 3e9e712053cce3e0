"""`slipmode fmu`, with --ssp too."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from slipmode.fmu.description.options import Origin
from slipmode.runner.commands import SCENE, Argument, Command, print_next
from slipmode.runner.fmi.export import HEADROOM, export_fmu
from slipmode.runner.scene.scene import load_scene


def commands() -> dict[str, Command]:
    """Return the command."""
    reach = (
        "amplitudes that it holds for, relative to what the scene needs: more for importers "
        f"that force it harder ({HEADROOM:g}: the shipped scenes' forces and a tenth more)"
    )
    contacts = "contacts as outputs, without a window of the scene"
    package = "in a system structure package, with start values and units (SCENE.ssp)"
    names = "x86_64-linux, aarch64-linux, x86_64-windows, x86_64-darwin, aarch64-darwin"
    others = {"nargs": "+", "default": [], "metavar": "PLATFORM"}
    about = [f"--{what}" for what in ("author", "copyright", "license")]
    return {
        "fmu": Command(
            _fmu,
            "fmu two-mode -o two-mode.fmu --fmi 2",
            SCENE,
            Argument("-o", "--output", type=Path, help="the .fmu file (SCENE.fmu)"),
            Argument("--fmi", type=int, choices=(2, 3), help="FMI 2.0 or 3.0 (3; with --ssp 2)"),
            Argument("--range", type=float, default=HEADROOM, metavar="FACTOR", help=reach),
            Argument("--contacts", action="store_true", help=contacts),
            *(
                Argument(name, metavar="TEXT", help="of the model (nothing is said)")
                for name in about
            ),
            Argument("--dated", action="store_true", help="say when it was made"),
            Argument("--ssp", action="store_true", help=package),
            Argument("--platforms", help=f"besides this machine's: {names}", **others),
        ),
    }


def _fmu(options: Namespace) -> int:
    now = datetime.now(UTC) if options.dated else None
    scene, output = load_scene(options.scene), options.output
    export: Callable[..., Path] = export_fmu
    if options.ssp:
        from slipmode.runner.fmi.ssp import export_ssp  # it reads the FMU by FMPy

        output, export = output or Path(f"{scene.name}.ssp"), export_ssp
    path = export(
        scene,
        output,
        fmi=options.fmi or (2 if options.ssp else 3),  # SSP 1.0 is for FMI 1.0 and 2.0
        platforms=options.platforms,
        headroom=options.range,
        contacts=options.contacts,
        origin=Origin(options.author, options.copyright, options.license, now),
        progress=True,
    )
    print(path)
    if not options.ssp and scene.tabulated:
        print_next("slipmode", "run", options.scene, "--fmu", path)
    return 0
