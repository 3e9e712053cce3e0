"""Checks of a scene: refusals of its time scales, warnings of strained assumptions."""

from __future__ import annotations

import numpy as np

from slipmode.rom import SlipmodeError, Structure, validity
from slipmode.rom.arrays import Floats
from slipmode.rom.frequencies import FrequencyUnit
from slipmode.rom.reduction.combination import combination_resonances
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.validity import Finding
from slipmode.runner.plan.amplitude_range import DryRun
from slipmode.runner.plan.excited import Excited
from slipmode.runner.scene.schedule import Schedule
from slipmode.runner.scene.sections import Scene


def check_outputs(scene: Scene, n_dofs: int) -> None:
    """Refuse recorded DOFs that the structure does not have."""
    for dof in scene.output.elastic:
        if not 0 <= dof < n_dofs:
            raise SlipmodeError(
                f"output.elastic: DOF {dof} is out of range, allowed: 0 to {n_dofs - 1}"
            )


def check_time_scales(scene: Scene, excited: Excited, schedule: Schedule) -> None:
    """Refuse a scene whose forcing, steps or windows no run can follow, naming the key."""
    reached = schedule.frequency_range(excited.modes)
    natural = zip(excited.modes, excited.reduced.frequency, *reached, strict=True)
    for mode, omega, *values in natural:
        forcing, unit = scene.forcing.get(mode), scene.units.frequency
        by_order = forcing is not None and forcing.engine_order is not None
        key = f"forcing.{mode}.{'engine_order * rotor_speed' if by_order else 'frequency'}"
        validity.check_carrier(key, mode, float(omega), np.array(values), unit)
    fastest = float(reached[1].max())
    per_second = fastest / (2 * np.pi)
    longest = 1e6 / per_second  # rounding then changes a phase by 1e-9 in a step
    if scene.run.step > longest:
        raise SlipmodeError(
            f"run.step: must be at most {longest:.3g} s (1e+06 periods of the forcing), "
            f"got {scene.run.step:g} s"
        )
    samples = sum(per_second * w.samples_per_period * (w.end - w.start) for w in scene.windows)
    if samples > 1e8:  # some GB in a recording
        raise SlipmodeError(
            f"contact.window, elastic.window: have {samples:.2g} samples, allowed: 1e+08; use "
            "shorter windows or a smaller samples_per_period"
        )


def check_frequencies(excited: Excited, schedule: Schedule, unit: FrequencyUnit) -> list[Finding]:
    """Report implausible frequencies of modes, and forcing far from them.

    Unforced modes are included: they move at the frequency of their [forcing] too.
    """
    omega, names = excited.reduced.frequency, excited.modes
    reached = np.array(schedule.frequency_range(names))
    return [
        *validity.mode_frequency_findings(names, omega),
        *validity.carrier_findings("forcing.{}.frequency", names, omega, reached, unit),
    ]


def check_assumptions(
    structure: Structure | None,
    excited: Excited,
    schedule: Schedule,
    amplitude: Floats,
    seen: DryRun | None,
) -> list[Finding]:
    """Report strained assumptions, at the largest amplitudes (modes,) and forces.

    Without a structure, neighbouring modes and directions of contacts are not known.
    """
    reduced, law, names = excited.reduced, excited.law, excited.modes
    largest_force = np.abs(schedule.extremes([f"force_{m}" for m in names])).max(axis=0)
    force = [f * most for f, most in zip(excited.force_patterns, largest_force, strict=True)]
    reached = schedule.frequency_range(names)
    share = seen.contact_share if seen else np.full(len(names), np.inf)
    of_structure = validity.direction_findings(structure, law) if structure is not None else []
    return [
        *_self_excited(excited, largest_force),
        *validity.proposal_findings(reduced, force, reached, share, names),
        *of_structure,
        *validity.share_findings(seen.contact_share if seen else np.zeros(len(names)), names),
        *validity.contact_findings(reduced, combination_resonances(reduced.carrier), names),
        *validity.friction_findings(*excited.contacts, amplitude),
        *validity.force_findings(AppliedForces.of(reduced, force), names),
    ]


def _self_excited(excited: Excited, largest_force: Floats) -> list[Finding]:
    """Report modes that aerodynamics make grow, and whether anything starts them."""
    found = []
    for j in np.flatnonzero(excited.reduced.modal_damping < 0.0):
        mode, damping = excited.modes[j], excited.reduced.modal_damping[j]
        reason = f"modal damping {damping:.3g} 1/s; it grows until friction limits it"
        found.append(Finding(f"mode {mode}", "self-excited", reason))
        if excited.amplitude[j] == 0.0 and largest_force[j] == 0.0:
            reason = (
                "it is self-excited, but remains at rest without a disturbance; give "
                f"initial.{mode} a value other than 0"
            )
            found.append(Finding(f"mode {mode}", "starts at rest", reason, "warning"))
    return found
