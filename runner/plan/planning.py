"""Plans of scenes."""

from __future__ import annotations

from typing import Any

from slipmode.rom import Structure
from slipmode.runner.plan.blades import plan_blades
from slipmode.runner.plan.modes import plan_modes
from slipmode.runner.plan.plan import ModesPlan, Plan
from slipmode.runner.plan.tones import plan_tones
from slipmode.runner.scene.sections import Scene


def plan_scene(
    scene: Scene, *, structure: Structure | None = None, progress: bool = False
) -> Plan[Any]:
    """Return the plan of a scene.

    The plan states what moves, the reduced model, the range of the friction table and the
    intervals at full order, with reasons and warnings.

    Parameters
    ----------
    scene : Scene
        Scene from `runner.load_scene`.
    structure : Structure, optional
        Structure of the scene if it is already built. It contains the modes that were computed.
    progress : bool, default False
        Print the phases of the computation on standard error.

    Returns
    -------
    Plan
        Decisions about the scene.

    Raises
    ------
    SlipmodeError
        If the scene and its structure do not fit together.
    """
    if scene.mistuning:
        return plan_blades(scene)
    if scene.modes.tones:
        return plan_tones(scene, structure or scene.build())
    return plan_modes(scene, structure, progress)


def make_plan(
    scene: Scene, *, structure: Structure | None = None, progress: bool = False
) -> ModesPlan:
    """Return the plan of a scene with one or two modes or waves, see `plan_scene`.

    Parameters
    ----------
    scene : Scene
        Scene from `runner.load_scene`.
    structure : Structure, optional
        Structure of the scene if it is already built. It contains the modes that were computed.
    progress : bool, default False
        Print the phases of the computation on standard error.

    Returns
    -------
    Plan
        Decisions about the scene.

    Raises
    ------
    SlipmodeError
        If several modes share a tone, the disk is mistuned, or the scene and its structure do not
        fit together.
    """
    scene.check_tuned()
    return plan_modes(scene, structure, progress)
