"""`slipmode plan`."""

from __future__ import annotations

from argparse import Namespace

from slipmode.runner.commands import SCENE, Command, print_next
from slipmode.runner.plan.planning import plan_scene
from slipmode.runner.scene.scene import load_scene
from slipmode.runner.transients.full_order import integration_cost


def commands() -> dict[str, Command]:
    """Return the command."""
    return {"plan": Command(_plan, "plan sweep", SCENE)}


def _plan(options: Namespace) -> int:
    plan = plan_scene(load_scene(options.scene), progress=True)
    shown = [d for d in plan.decisions if d.level == "info"]
    if plan.may_be_integrated:
        shown += integration_cost(plan)
    rows = [(d.subject, d.choice, d.reason) for d in shown]
    widths = [max(len(row[k]) for row in rows) for k in range(2)]
    for subject, choice, reason in rows:
        print(f"{subject:{widths[0]}}  {choice:{widths[1]}}  {reason}")
    for warning in plan.warnings:
        print(f"warning: {warning}")
    print_next("slipmode", "run", options.scene)
    return 0
