"""`slipmode identify`."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from slipmode import rom
from slipmode.rom.extras import extra
from slipmode.rom.identification.models.sensor_units import sensor_unit, shape_at_sensor
from slipmode.rom.identification.slow_laws import LAWS
from slipmode.rom.progress import phase, phases
from slipmode.runner.commands import AddCommand, Argument

LONG = 20_000  # samples that take about a second


def add_identify_command(add: AddCommand) -> None:
    """Add the command."""
    files = "measured decays: .csv, .npz, .mat or universal files; names may have wildcards"
    band = "a band [Hz] with one mode alone; twice for two modes, the lower one first"
    held = "records that are predicted, not fitted, by name or by the number in their names"
    mass = "modal mass of each mode at the sensor [kg] (1: forces are relative)"
    add(
        "identify",
        _identify,
        "frequency and damping against amplitude from measured decays: law, model and FMU",
        "identify hit*.csv --band 100 140 --band 225 260 --unit m/s --hold-out 2 6 -o beam",
        Argument("files", nargs="+", metavar="FILES", help=files),
        Argument(
            "--band",
            nargs=2,
            type=float,
            action="append",
            required=True,
            metavar=("LOW", "HIGH"),
            help=band,
        ),
        Argument("--unit", help="of the signals: m, mm/s, m/s^2, g, ... (the one in the file)"),
        Argument("--sample-rate", type=float, metavar="HZ", help="if the files do not state it"),
        Argument("--channels", nargs="+", type=_key, help="by name, or by position from 0 (all)"),
        Argument("--hold-out", nargs="+", type=_key, default=[], metavar="RECORD", help=held),
        Argument("--law", choices=["auto", *LAWS], default="auto", help="the law (auto)"),
        Argument("--modal-mass", nargs="+", type=float, metavar="KG", help=mass),
        Argument("-o", "--output", type=Path, default=Path("identified"), help="(identified)"),
    )


def _key(text: str) -> str | int:
    return int(text) if text.isdecimal() else text


def _identify(options: Namespace) -> int:
    from slipmode.runner.identification.files import write_files
    from slipmode.runner.identification.report import report

    extra("matplotlib.figure", "pictures")
    shape_at_sensor(len(options.band), options.modal_mass, None)
    data = rom.read_measurement(
        options.files,
        quantity="vibration",
        unit=options.unit,
        channels=options.channels,
        sample_rate=options.sample_rate,
    )
    data = replace(data, quantity=sensor_unit(data.unit)[0])
    with phases("identify", shown=True):
        if sum(record.signal.size for record in data) > LONG:
            phase(f"fitting laws to {len(data)} records")
        found = rom.identify(data, bands=options.band, law=options.law, hold_out=options.hold_out)
    text = report(found, options.modal_mass)
    print(text, end="\n\n")
    for path in write_files(found, text, options.output, options.modal_mass):
        print(path)
    return 0
