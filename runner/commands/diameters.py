"""`slipmode diameters`."""

from __future__ import annotations

from argparse import Namespace
from typing import cast

from slipmode import rom
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.frequencies import RPM
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.storage.files import write_columns
from slipmode.runner.commands import OUTPUT, SCENE, Argument, Command, print_charts
from slipmode.runner.pictures import page_figure
from slipmode.runner.scene.contacts import law_of
from slipmode.runner.scene.scene import Scene, load_scene


def commands() -> dict[str, Command]:
    """Return the command."""
    speed = "rotor speeds of the Campbell diagram [rpm] (20 %% around the scene's)"
    return {
        "diameters": Command(
            _diameters,
            "diameters bladed-disk --orders 2 3 4 5 --speed 3000 6000 -o logs",
            Argument("-n", "--families", type=int, default=3, help="modes of each diameter (3)"),
            Argument("--orders", nargs="+", type=int, help="engine orders (the scene's)"),
            Argument("--speed", nargs=2, type=float, metavar=("FROM", "TO"), help=speed),
            SCENE,
            OUTPUT,
        ),
    }


def _diameters(options: Namespace) -> int:
    from slipmode.runner.curves.disk_charts import disk_charts
    from slipmode.runner.view.charts import write_charts

    scene = load_scene(options.scene)
    if scene.disk is None:
        raise SlipmodeError(
            "structure.sectors: is missing: nodal diameters are those of a bladed disk, of "
            'model = "lumped-disk" or of matrices of one sector'
        )
    disk = scene.disk.build_disk().structure
    law = cast(Elastic, law_of(scene, disk.n_contacts))
    diagram = rom.nodal_diameter_diagram(disk, law, options.families)
    campbell = diagram.campbell(*_range(options, scene))
    options.output.mkdir(parents=True, exist_ok=True)
    table, picture, recording = (
        options.output / f"{scene.name}.diameters.{ending}" for ending in ("csv", "png", "rrd")
    )
    write_columns(table, diagram.columns(scene.units))
    title = f"{scene.title or scene.name}: nodal diameters"
    with page_figure(picture, _result(campbell), 4.0) as figure:
        left, right = figure.subplots(1, 2)
        diagram.plot(left, scene.units).set_title("Nodal diameters")
        campbell.plot(right, scene.units).set(title="Engine orders (EO)")
    charts = disk_charts(campbell, scene.units)
    write_charts(recording, title, [charts], {"Scene": f"```toml\n{scene.text}\n```"})
    for path in (table, picture, recording):
        print(path)
    unit = scene.units.frequency
    for each in campbell.crossings:
        frequency = scene.units.of_frequency(each.frequency)
        print(
            f"engine order {each.engine_order} excites nodal diameter {each.nodal_diameter}, "
            f"mode {each.mode} ({frequency:.6g} {unit}), at {each.rotor_speed:.5g} rpm"
        )
    print_charts(picture, recording)
    return 0


def _result(campbell: rom.CampbellDiagram) -> str:
    """Return how many resonances there are in the range of the rotor speed, and the slowest."""
    low, high = campbell.rotor_speed
    found = sorted(campbell.crossings, key=lambda each: each.rotor_speed)
    if not found:
        return f"No resonance from {low:g} to {high:g} rpm"
    number = "One resonance" if len(found) == 1 else f"{len(found)} resonances"
    return (
        f"{number} from {low:.0f} to {high:.0f} rpm, the slowest of engine order "
        f"{found[0].engine_order} at {found[0].rotor_speed:.0f} rpm"
    )


def _range(options: Namespace, scene: Scene) -> tuple[tuple[float, float], list[int]]:
    """Return the rotor speeds [rpm] and the engine orders that are shown."""
    forced = [each for each in scene.forcing.values() if each.engine_order is not None]
    orders = options.orders or [each.engine_order for each in forced]
    if not orders:
        raise SlipmodeError("orders: are missing: the scene has no engine order")
    if options.speed is not None:
        low, high = options.speed
        return (low, high), orders
    speeds = [
        end / (each.engine_order * RPM)
        for each in forced
        if each.engine_order is not None
        for end in each.frequency.range(0.0, scene.run.duration)
    ]
    if not speeds:
        raise SlipmodeError("speed: is missing: the scene has no rotor speed")
    return (0.8 * min(speeds), 1.2 * max(speeds)), orders
