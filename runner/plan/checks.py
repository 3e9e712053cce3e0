"""Checks of a scene: refusals of its time scales, warnings of strained assumptions."""

from __future__ import annotations

import numpy as np

from slipmode.rom import SlipmodeError, validity
from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.combination import combination_resonances
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.validity import Finding
from slipmode.runner.plan.amplitude_range import DryRun
from slipmode.runner.plan.excited import Excited, Moving
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.scene.schedule import Schedule, make_schedule
from slipmode.runner.scene.sections import Forcing, Scene


def checked_schedule(scene: Scene, excited: Moving) -> Schedule:
    """Return the schedule of a scene.

    Raises SlipmodeError, naming the key, if the structure does not have a recorded DOF, or no run
    can follow the forcing, steps or windows.
    """
    for dof in scene.output.elastic:
        if not 0 <= dof < excited.n_dofs:
            raise SlipmodeError(
                f"output.elastic: DOF {dof} is out of range, allowed: 0 to {excited.n_dofs - 1}"
            )
    schedule = make_schedule(scene, excited.natural)
    reached, unit = np.array(schedule.frequency_range(excited.modes)), scene.units.frequency
    for (mode, omega), values in zip(excited.natural.items(), reached.T, strict=True):
        forcing = scene.forcing.get(mode)
        by_order = forcing is not None and forcing.engine_order is not None
        key = f"forcing.{mode}.{'engine_order * rotor_speed' if by_order else 'frequency'}"
        if omega > 0.0:
            spin = _spin(excited, mode, forcing)
            validity.check_carrier(key, mode, omega, values, unit, spin)
    per_second = float(reached.max()) / (2 * np.pi)
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
    return schedule


def _spin(excited: Moving, mode: str, forcing: Forcing | None) -> Floats | None:
    """Return the row of `Reduced.spin` of a mode; refuse another engine order than the model's."""
    if not isinstance(excited, Excited) or excited.reduced.spin is None:
        return None
    spin: Floats = excited.reduced.spin[list[str](excited.modes).index(mode)]
    order = None if forcing is None else forcing.engine_order
    if order is not None and order != spin[1]:
        raise SlipmodeError(
            f"forcing.{mode}.engine_order: must be {spin[1]:g}, as in rom.reduce_rotating, since "
            f"natural frequencies of model.file follow the rotor speed; got {order}"
        )
    return spin


def frequency_findings(plan: ModesPlan) -> list[Finding]:
    """Report implausible frequencies of modes, and forcing far from them.

    Unforced modes are included: they move at the frequency of their [forcing] too.
    """
    omega, names = plan.excited.reduced.frequency, plan.excited.modes
    reached, unit = np.array(plan.schedule.frequency_range(names)), plan.scene.units.frequency
    return [
        *validity.mode_frequency_findings(names, omega),
        *validity.carrier_findings("forcing.{}.frequency", names, omega, reached, unit),
    ]


def check_assumptions(plan: ModesPlan, seen: DryRun | None) -> list[Finding]:
    """Report strained assumptions, at the largest amplitudes and forces.

    Without a structure, neighbouring modes and directions of contacts are not known.
    """
    excited, schedule = plan.excited, plan.schedule
    reduced, law, names = excited.reduced, excited.law, excited.modes
    structure = excited.structure
    largest_force = np.abs(schedule.extremes([f"force_{m}" for m in names])).max(axis=0)
    force = [f * most for f, most in zip(excited.force_patterns, largest_force, strict=True)]
    reached = schedule.frequency_range(names)
    share = seen.contact_share if seen else np.full(len(names), np.inf)
    amplitude = seen.reached if seen else np.array(plan.amplitude)
    return [
        *_self_excited(excited, largest_force),
        *validity.proposal_findings(reduced, force, reached, share, names),
        *(validity.direction_findings(structure, law) if structure is not None else ()),
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
