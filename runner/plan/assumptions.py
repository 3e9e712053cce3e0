"""The assumptions of the method, measured for a scene: warnings if they are strained."""

from __future__ import annotations

import numpy as np

from slipmode.rom import Structure
from slipmode.rom.arrays import Floats
from slipmode.rom.frequencies import FrequencyUnit
from slipmode.rom.reduction.combination import combination_resonances
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.validity import (
    Finding,
    carrier_findings,
    contact_findings,
    direction_findings,
    force_findings,
    friction_findings,
    mode_frequency_findings,
    separation_findings,
    share_findings,
)
from slipmode.runner.plan.amplitude_range import DryRun
from slipmode.runner.plan.excited import Excited
from slipmode.runner.scene.schedule import Schedule


def check_frequencies(excited: Excited, schedule: Schedule, unit: FrequencyUnit) -> list[Finding]:
    """Report implausible frequencies of modes, and forcing far from them.

    Unforced modes are included: they move at the frequency of their [forcing] too.
    """
    omega, names = excited.reduced.frequency, excited.modes
    reached = np.array(schedule.frequency_range(names))
    return [
        *mode_frequency_findings(names, omega),
        *carrier_findings("forcing.{}.frequency", names, omega, reached, unit),
    ]


def check_assumptions(
    structure: Structure,
    excited: Excited,
    schedule: Schedule,
    amplitude: Floats,
    seen: DryRun | None,
) -> list[Finding]:
    """Report strained assumptions, at the largest amplitudes (modes,) and forces."""
    reduced, law, names = excited.reduced, excited.law, excited.modes
    largest_force = np.abs(schedule.extremes([f"force_{m}" for m in names])).max(axis=0)
    force = [f * most for f, most in zip(excited.force_patterns, largest_force, strict=True)]
    return [
        *_self_excited(excited, largest_force),
        *separation_findings(structure, reduced, names),
        *share_findings(seen.contact_share if seen else np.zeros(len(names)), names),
        *direction_findings(structure, law),
        *contact_findings(reduced, combination_resonances(reduced.carrier), names),
        *friction_findings(reduced, law, amplitude),
        *force_findings(AppliedForces.of(reduced, force), names),
    ]


def _self_excited(excited: Excited, largest_force: Floats) -> list[Finding]:
    """Report modes that aerodynamics make grow, and whether anything starts them."""
    found = []
    for j, mode in enumerate(excited.modes):
        damping = excited.reduced.modal_damping[j]
        if damping >= 0.0:
            continue
        reason = f"modal damping {damping:.3g} 1/s: it grows until friction holds it"
        found.append(Finding(f"mode {mode}", "self-excited", reason))
        if excited.amplitude[j] == 0.0 and largest_force[j] == 0.0:
            reason = (
                "self-excited, but at rest it stays at rest until something moves it; give "
                f"initial.{mode} a value other than 0"
            )
            found.append(Finding(f"mode {mode}", "starts at rest", reason, "warning"))
    return found
