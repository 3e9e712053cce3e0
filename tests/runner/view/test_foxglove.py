"""The layout for Foxglove beside an MCAP file names what is recorded, and nothing else."""

import json

import pytest

from slipmode.runner import load, shipped_scenes


def panels(node):
    """Names in the tree of a layout."""
    if isinstance(node, str):
        return [node]
    return panels(node["first"]) + panels(node["second"])


def paths(config):
    """What a panel reads."""
    if "topicToRender" in config:
        return [config["topicToRender"]]
    return [each["value"] for each in config["paths"]] + (
        [config["xAxisPath"]["value"]] if config["xAxisVal"] == "custom" else []
    )


POWERS = ("input", "dissipated", "structural", "stored")  # the first is the sum of the others
KINDS = ("two-mode", "mistuned-disk")  # these two have all kinds of panels between them


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name in KINDS else [pytest.mark.slow])
        for name in shipped_scenes()
    ],
)
def test_every_panel_reads_what_is_recorded(name, shipped_scene):
    mcap = shipped_scene(name).mcap
    layout = json.loads(mcap.with_suffix(".foxglove.json").read_text(encoding="utf-8"))
    configs = layout["configById"]
    assert sorted(panels(layout["layout"])) == sorted(configs)
    recorded = load(mcap)
    fields = {f"{topic}.{field}" for topic in recorded for field in recorded[topic].units}
    read = {path.partition(".@")[0] for config in configs.values() for path in paths(config)}
    assert read <= fields | {"/events"}
    modes = {path for path in fields if path.endswith("_abs")}
    contacts = {path for path in fields if path.startswith("/contact/") and path.endswith(".f")}
    blades = {path for path in fields if path.startswith("/blades.")}
    balance = ("dissipated_energy", *(f"{part}_power" for part in POWERS))
    energy = {f"/energy.{name}" for name in balance} & fields  # a mistuned disk has none
    assert len(energy) in (0, 5)
    assert modes | contacts | blades | energy | {"/events"} <= read
    assert blades or energy or "/modes.A2_abs" in modes  # modes on one tone have none either
