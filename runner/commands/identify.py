"""`slipmode identify`."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Literal

from slipmode import rom
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.identification import LAWS, sensor_unit, shape_at_sensor
from slipmode.rom.progress import phase, phases
from slipmode.runner.commands import Argument, Command, print_next
from slipmode.runner.pictures import check_pictures

LONG = 20_000  # samples that take about a second


def commands() -> dict[str, Command]:
    """Return the command."""
    files = "measured decays, sine tests or loops: text, .npz, .mat, universal files, or wildcards"
    sine = "the files are sine tests: sweeps or steps of force and response, or steady responses"
    loops = "the files are loops of force against displacement of a joint; several are levels"
    channels = (
        "by name, or by position from 0 (all); of sine tests force and response, by name; of "
        "loops displacement and force"
    )
    band = "a band [Hz] with one mode alone; twice for two modes, the lower one first"
    law = "the law (auto); jenkins and segalman: one joint from complete slip into stick, one mode"
    held = "predicted, not fitted: records by name or number in it, tests by beginning of the name"
    cross = (
        "whether rates of a mode depend on the amplitude of the other one (auto: if it predicts)"
    )
    mass = "modal mass of each mode at the sensor [kg] (1: forces are relative)"
    return {
        "identify": Command(
            _identify,
            "identify hit*.csv --band 100 140 --band 225 260 --unit m/s --hold-out 2 6 -o beam; "
            "slipmode identify --loops damper.csv --unit mm --force-unit kN -o damper",
            Argument("files", nargs="+", metavar="FILES", help=files),
            Argument(
                "--band",
                nargs=2,
                type=float,
                action="append",
                metavar=("LOW", "HIGH"),
                help=band,
            ),
            Argument(
                "--unit", help="of the signals: m, mm/s, m/s^2, g, ... (the one in the file)"
            ),
            Argument(
                "--force-unit",
                help="of sine tests and loops: N, kN, ... (the one in the file)",
            ),
            Argument("--sample-rate", type=float, metavar="HZ", help="(the rate in the files)"),
            Argument("--channels", nargs="+", type=_key, help=channels),
            Argument("--hold-out", nargs="+", type=_key, default=[], metavar="NAME", help=held),
            Argument("--law", choices=["auto", *LAWS], default="auto", help=law),
            Argument("--cross", choices=["auto", "yes", "no"], help=cross),
            Argument("--modal-mass", nargs="+", type=float, metavar="KG", help=mass),
            Argument("-o", "--output", type=Path, default=Path("identified"), help="(identified)"),
            either=(
                Argument("--sine", action="store_true", help=sine),
                Argument("--loops", action="store_true", help=loops),
            ),
        ),
    }


def _key(text: str) -> str | int:
    return int(text) if text.isdecimal() else text


def _identify(options: Namespace) -> int:
    from slipmode.runner.identification.files import write_files
    from slipmode.runner.identification.report import report

    check_pictures()
    if options.loops:
        return _of_loops(options)
    if options.band is None:
        raise SlipmodeError("band: is missing; give the frequencies around each mode, [Hz]")
    shape_at_sensor(len(options.band), options.modal_mass, None)
    with phases("identify", shown=True):
        found = _of_sine_tests(options) if options.sine else _of_decays(options)
    text = report(found, options.modal_mass)
    print(text, end="\n\n")
    for path in write_files(found, text, options.output, options.modal_mass):
        print(path)
    print_next("slipmode", "run", options.output / "scene.toml")
    return 0


def _of_loops(options: Namespace) -> int:
    from slipmode.runner.identification.loops import loop_report, write_loop_files

    for name in ("band", "cross", "modal_mass", "sample_rate"):
        if getattr(options, name) is not None:
            raise SlipmodeError(f"{name}: is not for loops; leave it out")
    if options.hold_out or options.law != "auto":
        name = "hold_out" if options.hold_out else "law"
        raise SlipmodeError(f"{name}: is not for loops; leave it out")
    loops = rom.read_loops(
        options.files,
        unit=options.unit,
        force_unit=options.force_unit,
        channels=options.channels,
    )
    with phases("identify", shown=True):
        found = rom.fit_loops(loops)
    print(loop_report(found), end="\n\n")
    for path in write_loop_files(found, options.output):
        print(path)
    return 0


def _of_decays(options: Namespace) -> rom.Identification:
    if options.force_unit is not None:
        raise SlipmodeError("force_unit: is for sine tests; give --sine")
    data = rom.read_measurement(
        options.files,
        quantity="vibration",
        unit=options.unit,
        channels=options.channels,
        sample_rate=options.sample_rate,
    )
    data = replace(data, quantity=sensor_unit(data.unit)[0])
    if sum(record.signal.size for record in data) > LONG:
        phase(f"fitting laws to {len(data)} records")
    cross: Literal["auto"] | bool = "auto"
    if options.cross in ("yes", "no"):
        cross = options.cross == "yes"
    held = options.hold_out
    return rom.identify(data, bands=options.band, law=options.law, cross=cross, hold_out=held)


def _of_sine_tests(options: Namespace) -> rom.SineIdentification:
    for name in ("cross", "modal_mass"):
        if getattr(options, name) is not None:
            raise SlipmodeError(f"{name}: is for decays, not for sine tests")
    if len(options.band) > 1:
        raise SlipmodeError("band: sine tests are of one mode; give one band")
    channels = None if options.channels is None else tuple(map(str, options.channels))
    tests = rom.read_sine_tests(
        options.files,
        unit=options.unit,
        force_unit=options.force_unit,
        sample_rate=options.sample_rate,
        channels=channels,
    )
    if options.law not in ("auto", "power", "linear"):
        raise SlipmodeError(f"law = {options.law!r}: must be power or linear for sine tests")
    law: Literal["power", "linear"] = "linear" if options.law == "linear" else "power"
    held = [str(key) for key in options.hold_out]
    return rom.identify_sine(tests, band=tuple(options.band[0]), law=law, hold_out=held)
