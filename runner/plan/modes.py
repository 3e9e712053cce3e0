"""The plan of a scene with one or two modes or waves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipmode.rom import Model, SlipmodeError, Structure
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.rest.static_preload import Preload, loaded_by_friction
from slipmode.rom.errors import naming
from slipmode.rom.laws.friction import RigidFriction
from slipmode.rom.laws.states import STATES
from slipmode.rom.reduction.combination import TRANSIENT_SEPARATION
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.nonlinear.stiffness import with_nonlinear_stiffness
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.reduction.tones import on_one_tone
from slipmode.rom.short_repr import percentage
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.validity import Finding, frictionless_findings
from slipmode.runner.plan import checks
from slipmode.runner.plan.amplitude_range import DryRun, dry_run, run_on
from slipmode.runner.plan.excited import Excited, initial_amplitudes, listed
from slipmode.runner.plan.plan import ModesPlan, Plan, recording_decisions
from slipmode.runner.plan.transients import plan_transients
from slipmode.runner.plan.waves import excite_waves, wave_decisions
from slipmode.runner.plan.wear import worn
from slipmode.runner.recording.channels import MODES, Mode
from slipmode.runner.scene.contacts import check_scale, loaded_law
from slipmode.runner.scene.kept import kept_reduction
from slipmode.runner.scene.sections import Scene


def plan_modes(scene: Scene, structure: Structure | None, progress: bool) -> ModesPlan:
    """Return the plan of a scene with one or two modes or waves."""
    modes, decisions = _modes(scene)
    excited: Excited
    if scene.disk is not None:
        scene, waves = excite_waves(scene, modes)
        excited, found = waves, wave_decisions(scene, waves)
    else:
        scene, excited, found = _excite(scene, modes, structure, progress)
    schedule = checks.checked_schedule(scene, excited)
    plan = Plan(scene, schedule, excited, decisions + found)
    if not scene.tabulated:
        reason = f'model.table = "none", for {scene.run.duration:g} s in {schedule.steps} steps'
        choice = "none, time integration at full order"
        return plan.with_decisions(
            Finding("friction table", choice, reason),
            *recording_decisions(scene),
            *checks.frequency_findings(plan),
            *frictionless_findings(excited.law, excited.reduced.n_contacts),
        )
    saved = scene.saved_model
    plan, seen = _tabulated(plan, progress) if saved is None else _on_saved_model(plan, saved)
    full_order, transients = plan_transients(plan, seen)
    return replace(plan, full_order=full_order).with_decisions(
        transients,
        *recording_decisions(scene),
        *checks.frequency_findings(plan),
        *checks.check_assumptions(plan, seen),
    )


def _excite(
    scene: Scene, modes: tuple[Mode, ...], structure: Structure | None, progress: bool
) -> tuple[Scene, Excited, list[Finding]]:
    """Return the located scene, its modes under their forces, and the contacts at rest."""
    rest, saved = None, scene.saved_model
    if saved is not None:
        scene, law, reduced = scene.located(None), saved.law, saved.reduced
        check_scale(scene, law, reduced.n_contacts)
    else:
        structure = structure or scene.build()
        scene = scene.located(structure.labels)
        law, rest = loaded_law(scene, structure)
        check_scale(scene, law, structure.n_contacts)
        reduced = kept_reduction(
            structure,
            [scene.modes.numbers[mode] for mode in modes],
            scene.model.formulation,
            None if isinstance(law, RigidFriction) else law,
            [scene.aerodynamics.get(mode, 0j) for mode in modes] if scene.aerodynamics else None,
            progress=progress,
        )
        if scene.nonlinear_stiffness:
            # of modes that are left out there is no amplitude
            letters = str.maketrans("".join(modes), "AB"[: len(modes)])
            with naming("nonlinear_stiffness"):
                reduced = with_nonlinear_stiffness(
                    reduced,
                    {
                        name.translate(letters): value
                        for name, value in scene.nonlinear_stiffness.items()
                        if set(name) <= set(modes)
                    },
                )
        if scene.modes.ratio is not None:
            reduced = on_one_tone(reduced, scene.modes.ratio, _middle(scene))
    initial = initial_amplitudes(scene, modes)
    patterns = tuple(_force_pattern(scene, mode, reduced, j) for j, mode in enumerate(modes))
    return scene, Excited(modes, reduced, law, patterns, initial, initial), _at_rest(rest)


def _tabulated(plan: ModesPlan, progress: bool) -> tuple[ModesPlan, DryRun | None]:
    """Return the plan with the range of its friction table, and the dry run that finds it."""
    scene, excited, schedule = plan.scene, plan.excited, plan.schedule
    if scene.model.formulation == "consistent":
        excited = excited.at_carriers(schedule.mean_frequency(excited.modes)).started(schedule)
        plan = replace(plan, excited=excited, combinations=excited.combinations(schedule))
    seen = None
    if scene.model.amplitude is None:
        amplitude, seen = dry_run(plan, progress)
        reached = _listed(excited.modes, " = {:.3g}", seen.reached)
        reason = f"a dry run on a coarse table reaches {reached}; the margin is 15 %"
    else:
        amplitude = tuple(scene.model.amplitude["AB".index(mode)] for mode in excited.modes)
        reason = "given as model.amplitude"
    found = _range(excited.modes, amplitude, reason)
    plan = replace(plan, amplitude=amplitude).with_decisions(excited.other_modes(), found)
    if scene.disk is None:
        plan = plan.with_decisions(*_combinations(plan))
    if not plan.detuning:
        return plan, seen
    reason = (
        f"the forcing is up to {percentage(plan.detuning)} away from the reference frequency "
        f"of the table, {listed(excited.reduced.carrier)} rad/s"
    )
    return plan.with_decisions(Finding("friction", "follows the forcing frequency", reason)), seen


def _on_saved_model(plan: ModesPlan, model: Model) -> tuple[ModesPlan, DryRun]:
    """Return the plan on a saved model, and the run on this model."""
    excited = plan.excited.started(plan.schedule)
    with naming("initial"):
        excited.component(model, plan.scene.run.tolerance)  # refuses a start outside the table
    with naming("forcing"):
        check_force_patterns(model, AppliedForces.of(model.reduced, excited.force_patterns))
    plan = replace(plan, schedule=worn(excited, plan.schedule, model, plan.scene))
    seen, amplitude = (
        run_on(excited, plan.schedule, model),
        tuple(model.table.amplitude_range.tolist()),
    )
    reason = f"model.file; the scene reaches {_listed(excited.modes, ' = {:.3g}', seen.reached)}"
    plan = replace(
        plan, excited=excited, amplitude=amplitude, combinations=model.combinations
    ).with_decisions(_range(excited.modes, amplitude, reason))
    if not seen.inside:
        reason = "the run ends there. Reduce the forcing, or save a model with a larger range"
        choice = "leave the range of model.file"
        plan = plan.with_decisions(Finding("amplitudes", choice, reason, "warning"))
    if excited.reduced.n_contacts:
        return plan.with_decisions(excited.other_modes(), *_combinations(plan)), seen
    reason = "model.file has only damping and frequency"
    return plan.with_decisions(Finding("contacts", "none", reason)), seen


def _range(modes: Sequence[Mode], amplitude: Sequence[float], reason: str) -> Finding:
    return Finding("friction table", _listed(modes, " <= {:g}", amplitude), reason)


def _listed(modes: Sequence[Mode], form: str, amplitude: Sequence[float] | Floats) -> str:
    return ", ".join(f"|{m}|{form.format(a)}" for m, a in zip(modes, amplitude, strict=True))


def _modes(scene: Scene) -> tuple[tuple[Mode, ...], list[Finding]]:
    """Return the modes that move at all, with the reason for each."""
    modes: list[Mode] = []
    decisions = []
    moves = False
    for mode in scene.modes.numbers:
        forcing = scene.forcing.get(mode)
        forced = forcing is not None and forcing.amplitude.range(0.0, scene.run.duration)[1] > 0
        moved = forced or scene.initial.get(mode, 0.0) != 0.0
        moves = moves or moved
        if moved or scene.aerodynamics.get(mode, 0j).imag < 0.0:
            why = "forcing" if forced else "initial" if moved else "aerodynamics"
            reason = f"moved by {why}.{mode}"
        elif scene.modes.ratio is not None:
            reason = f"driven by the contacts at {scene.modes.ratio} times the frequency of mode A"
        elif scene.saved_model is not None:
            reason = "part of model.file; neither forced nor moving at t = 0"
        else:
            reason = "neither forced nor moving at t = 0; the contact stiffness includes it"
            decisions.append(Finding(f"mode {mode}", "left out", reason))
            continue
        modes.append(mode)
        decisions.append(Finding(f"mode {mode}", "modelled", reason))
    if not moves:
        raise SlipmodeError(
            "forcing: no mode moves; give forcing.A.amplitude or initial.A a value other than 0"
        )
    return tuple(modes), decisions


def _middle(scene: Scene) -> list[float] | None:
    """Return the middle of the forcing frequencies of mode A [rad/s]; None without a force."""
    if "A" not in scene.forcing:
        return None
    return [0.5 * sum(scene.forcing["A"].frequency.range(0.0, scene.run.duration))]


def _force_pattern(scene: Scene, mode: str, reduced: Reduced, index: int) -> Floats:
    """Return the force on every DOF per unit of its amplitude; refuse one without work."""
    if mode not in scene.forcing:
        return np.zeros(reduced.n_dofs)
    pattern = scene.forcing[mode].vector(reduced.n_dofs)
    if not reduced.is_moved_by(index, pattern):
        raise SlipmodeError(
            f"forcing.{mode}: this force does no work on mode {mode}; choose another DOF or vector"
        )
    return pattern


def _at_rest(rest: Preload | None) -> list[Finding]:
    """Return the state of the contacts under the static force."""
    if rest is None:
        return []
    closed = rest.normal_force[rest.normal_force > 0.0]
    count = {word: np.count_nonzero(rest.state == k) for k, word in enumerate(STATES)}
    states = ", ".join(f"{n} {word}" for word, n in count.items() if n)
    pressed = (
        f"normal forces {closed.min():.3g} to {closed.max():.3g} N" if closed.size else "no load"
    )
    found = [Finding("contacts at rest", states, pressed)]
    if reason := loaded_by_friction(rest):
        found.append(Finding("static force", "neglected at contacts", reason, "warning"))
    return found


def _combinations(plan: ModesPlan) -> list[Finding]:
    """Return the harmonics of the contacts that drive modes."""
    combinations = plan.combinations
    if (ratio := plan.scene.modes.ratio) is not None:
        reason = f"the frequency of mode B is {ratio} times that of mode A (modes.ratio)"
        choice = f"{len(combinations)} harmonics of the contacts drive modes A and B"
        return [Finding("internal resonance", choice, reason)]
    if not combinations:
        reason = "no combination frequency comes near a mode"
        return [Finding("combination resonances", "none", reason)]
    found, within = [], percentage(TRANSIENT_SEPARATION)
    for term in combinations:
        mode = MODES[term.mode]
        reason = f"comes within {within} of mode {mode}; the slow flow of mode {mode} includes it"
        found.append(Finding("combination resonance", str(term), reason))
    return found
