"""The assumptions of the method, measured for a scene: warnings where they are strained."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom import Structure
from slipmode.rom.reduction.combination import combination_resonances
from slipmode.rom.reduction.fixed_interface import fixed_interface_modes
from slipmode.rom.reduction.stiffness_margin import STRAINED, stiffness_loss
from slipmode.runner.plan.amplitude_range import DryRun, Excited
from slipmode.runner.recording.channels import Level

_SEPARATION = 0.1  # relative distance of a mode from its neighbours
_TOUCH = 1e-8  # part of a mode's stiffness that is at stake at the contacts
_SMALL = 0.3  # the same, above which the contacts do not merely perturb the mode


@dataclass(frozen=True)
class Decision:
    """One thing that is, or is not, modelled; or an assumption that is strained."""

    subject: str
    choice: str
    reason: str
    level: Level = "info"


def check_assumptions(
    structure: Structure,
    excited: Excited,
    seen: DryRun | None,
) -> list[Decision]:
    """Warnings, each with the indicator that was measured; some need a dry run."""
    return [
        *_separation(structure, excited),
        *_contact(excited, seen),
        *_stiffness_loss(excited),
    ]


def _separation(structure: Structure, excited: Excited) -> list[Decision]:
    """Modes must be well apart from their neighbours, excited or not."""
    parts = structure.partition()
    wanted = max(excited.reduced.modes) + 2
    frequency, _ = fixed_interface_modes(parts, min(wanted, parts.K_ec.shape[0]))
    found = []
    for mode, number in zip(excited.modes, excited.reduced.modes, strict=True):
        others = np.delete(frequency, number)
        distance = np.abs(others / frequency[number] - 1.0).min(initial=np.inf)
        if distance < _SEPARATION:
            reason = (
                f"its nearest neighbour is {distance:.1%} away, below {_SEPARATION:.0%}: "
                "that mode will move too, and is not modelled"
            )
            found.append(Decision(f"mode {mode}", "not separated", reason, "warning"))
    return found


def _contact(excited: Excited, seen: DryRun | None) -> list[Decision]:
    """The contacts must matter to a mode, but only as a perturbation."""
    reduced = excited.reduced
    flexibility = np.linalg.solve(reduced.stiffness, reduced.spring.T)
    at_stake = np.einsum("jc,cj->j", reduced.spring, flexibility) / reduced.frequency**2
    shares = seen.contact_share if seen else np.zeros(at_stake.size)
    found = []
    for mode, most, share in zip(excited.modes, at_stake, shares, strict=True):
        if most < _TOUCH:
            reason = f"{most:.1e} of its stiffness is at stake there: friction does not see it"
            found.append(
                Decision(f"mode {mode}", "does not touch the contacts", reason, "warning")
            )
        elif share > _SMALL:
            reason = (
                f"contact motion takes {share:.0%} of its stiffness, above {_SMALL:.0%}: too much "
                "for a perturbation; compare with slipmode validate"
            )
            found.append(Decision(f"mode {mode}", "large contact motion", reason, "warning"))
    return found


def _stiffness_loss(excited: Excited) -> list[Decision]:
    """The contacts must be stiff against what the modes respond to their motion."""
    reduced = excited.reduced
    share, _ = stiffness_loss(reduced, combination_resonances(reduced.carrier))
    if share <= STRAINED:
        return []
    reason = (
        f"modes take away {share:.0%} of their stiffness, above {STRAINED:.0%}: the friction "
        "table takes long; compare with slipmode validate"
    )
    return [Decision("contacts", "soft", reason, "warning")]
