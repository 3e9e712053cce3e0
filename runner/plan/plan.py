"""The plan of a scene: what is modelled and why, decided before tables and runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from slipmode.fmu import Component
from slipmode.rom import Model, Reduced, SlipmodeError, Structure
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.detuning import MOST_DETUNING
from slipmode.rom.contact.static_preload import Preload, loaded_by_friction
from slipmode.rom.errors import naming
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import RigidFriction
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.laws.states import STATES
from slipmode.rom.reduction.combination import (
    TRANSIENT_SEPARATION,
    CombinationResonance,
)
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.reduction.tones import combinations_along, on_one_tone
from slipmode.rom.representable import round_up
from slipmode.rom.short_repr import percentage
from slipmode.rom.table.quasi_static import check_force_patterns
from slipmode.rom.validity import Finding, frictionless_findings
from slipmode.runner.plan import checks
from slipmode.runner.plan.amplitude_range import DryRun, dry_run, run_on_saved_model
from slipmode.runner.plan.excited import Excited
from slipmode.runner.plan.scene_plan import ScenePlan
from slipmode.runner.plan.transients import Intervals, plan_transients
from slipmode.runner.plan.waves import wave_decisions, waves_of
from slipmode.runner.recording.channels import MODES, Mode
from slipmode.runner.scene.contacts import check_scale, law_of, loaded_law
from slipmode.runner.scene.kept import kept_reduction
from slipmode.runner.scene.schedule import Schedule, make_schedule
from slipmode.runner.scene.sections import Scene
from slipmode.runner.scene.structures import Disk


@dataclass(frozen=True, eq=False)
class Plan(ScenePlan):
    """Hold a scene and all modelling decisions about it, with their reasons.

    Attributes
    ----------
    scene, schedule : Scene, Schedule
        Scene, and its forces and frequencies in each communication step.
    known_structure : Structure or None
        Structure of the scene; None with a saved model or a disk.
    excited : Excited
        Retained modes, reduced matrices, contact law and force patterns.
    decisions : list of Finding
        Decisions and warnings with their reasons.
    amplitude : tuple of float
        Amplitude range of the friction table [kg^1/2 m]; empty without a table.
    combinations : tuple of CombinationResonance
        Harmonics that come near a carrier during the scene.
    full_order : tuple of (float, float)
        Start and end of the intervals that are integrated at full order [s], from the dry run.
    """

    scene: Scene
    known_structure: Structure | None
    excited: Excited
    schedule: Schedule
    decisions: list[Finding] = field(default_factory=list)
    amplitude: tuple[float, ...] = ()
    combinations: tuple[CombinationResonance, ...] = ()
    full_order: Intervals = ()

    def __repr__(self) -> str:
        amplitudes = ", ".join(f"{amplitude:.4g}" for amplitude in self.amplitude)
        how = f"amplitudes to {amplitudes}" if self.scene.tabulated else "integrated"
        return (
            f"Plan({self.scene.title!r}: mode {' and '.join(self.excited.modes)}, "
            f"{self.excited.reduced.n_contacts} contacts, {how}, {self.schedule.steps} steps, "
            f"{len(self.decisions)} decisions)"
        )

    @property
    def summary(self) -> str:
        """What moves, and how it is computed, for the first event of a recording."""
        if not self.scene.tabulated:
            return "integrated without a friction table"
        contacts, _ = self.excited.contacts
        return (
            f"mode {' and '.join(self.excited.modes)}, {contacts.n_contacts} contacts, "
            f"{contacts.formulation} formulation, table tolerance {self.scene.model.tolerance:g}"
        )

    @property
    def structure(self) -> Structure:
        """Structure of the scene.

        Raises
        ------
        SlipmodeError
            If the scene has a saved model, or a disk of one sector.
        """
        return self.scene.build() if self.known_structure is None else self.known_structure

    @property
    def detuning(self) -> float:
        """Largest relative distance of the forcing from the reference frequencies of the table.

        Rounded up to two digits, so that small changes of a scene share a table; 0 without one.
        """
        if not self.scene.tabulated or self.excited.reduced.formulation == "paper":
            return 0.0
        reached = np.array(self.schedule.frequency_range(self.excited.modes))
        distance = float(np.abs(reached / self.excited.reduced.carrier - 1.0).max())
        return round_up(distance) if distance > 1e-9 else 0.0  # less is rounding

    @property
    def full_order_share(self) -> float:
        """Share of the duration that the dry run integrates at full order, 0 to 1."""
        return sum(end - start for start, end in self.full_order) / self.scene.run.duration

    @property
    def may_be_integrated(self) -> bool:
        """Whether the scene has a table, and `model.table = "none"` is possible as well."""
        scene = self.scene
        fixed = scene.limit_scale is None and scene.saved_model is None and scene.disk is None
        return scene.tabulated and fixed and scene.model.formulation != "paper"

    def model(
        self,
        *,
        contact: bool = False,
        headroom: float = 1.0,
        detuning: bool = False,
        progress: bool = False,
    ) -> tuple[Model, bool]:
        """Return the model of the scene, from the cache if possible.

        Parameters
        ----------
        contact : bool, default False
            Include contact motion, even if the scene has no window of it.
        headroom : float, default 1.0
            Margin of the table: its range relative to `amplitude` [-], >= 1.
        detuning : bool, default False
            Let friction depend on the forcing frequencies, even if they are constant.
        progress : bool, default False
            Show a progress bar.

        Returns
        -------
        model : Model
            Reduced structure and friction table; a saved model unchanged.
        cached : bool
            Whether the model was not computed, but saved or cached.

        Raises
        ------
        SlipmodeError
            If the scene has no friction table, or its tolerance cannot be reached.
        """
        self.scene.check_tabulated()
        if self.scene.saved_model is not None:
            return self.scene.saved_model, True
        consistent = self.scene.model.formulation == "consistent"
        return self.excited.model(
            self.amplitude,
            self.scene.model.tolerance,
            combinations=self.combinations,
            harmonics=RESPONSE_ORDER if consistent and (contact or self.scene.windows) else 0,
            headroom=headroom,
            detuning=detuning or min(self.detuning, MOST_DETUNING) or False,
            budget=self.scene.model.budget,
            progress=progress,
        )

    def component(self, model: Model) -> Component:
        """Return a component at the start of the scene.

        Parameters
        ----------
        model : Model
            Model of the scene.

        Returns
        -------
        Component
            Component at t = 0 with the force patterns of the scene.
        """
        return self.excited.component(model, self.scene.run.tolerance)


def make_plan(scene: Scene, *, structure: Structure | None = None, progress: bool = False) -> Plan:
    """Return the plan of a scene without a mistuned disk.

    The plan states the modes, the reduced model, the range of the friction table and the intervals
    at full order, with reasons and warnings. `runner.plan_scene` plans mistuned disks as well.

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
        If the scene and its structure do not fit together, or the disk is mistuned.
    """
    scene.check_tuned()
    modes, mode_decisions = _modes(scene)
    rest, saved = None, scene.saved_model
    if scene.disk is not None:
        disk = scene.disk.build_disk()
        return _tabulated(_plan_of_disk(scene, modes, disk, mode_decisions), progress)
    if saved is not None:
        scene, law, reduced = scene.located(None), saved.law, saved.reduced
        check_scale(scene, law, reduced.n_contacts)
    else:
        structure = scene.build() if structure is None else structure
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
        if scene.modes.ratio is not None:
            reduced = on_one_tone(reduced, scene.modes.ratio, _middle(scene))
    initial = tuple(complex(scene.initial.get(mode, 0.0)) for mode in modes)
    patterns = tuple(_force_pattern(scene, mode, reduced, j) for j, mode in enumerate(modes))
    excited = Excited(modes, reduced, law, patterns, initial, initial)
    plan = _scheduled(scene, structure, excited, mode_decisions + _preload_decisions(rest))
    if saved is not None:
        return _on_saved_model(plan, saved)
    return _tabulated(plan, progress) if scene.tabulated else _integrated(plan)


def _scheduled(
    scene: Scene, structure: Structure | None, excited: Excited, decisions: list[Finding]
) -> Plan:
    """Return the plan with its schedule, before anything is decided about tables."""
    reduced = excited.reduced
    checks.check_outputs(scene, reduced.n_dofs)
    natural = dict(zip(excited.modes, reduced.frequency.tolist(), strict=True))
    schedule = make_schedule(scene, natural)
    checks.check_time_scales(scene, excited, schedule)
    return Plan(scene, structure, excited, schedule, decisions)


def _plan_of_disk(
    scene: Scene, modes: tuple[Mode, ...], disk: Disk, decisions: list[Finding]
) -> Plan:
    """Return the plan of a scene with sectors, before anything is decided about tables."""
    scene = scene.located(disk.labels)
    of_contacts = cast(Elastic, law_of(scene, disk.structure.n_contacts))
    waves = waves_of(scene, modes, disk.structure, of_contacts)
    initial = tuple(complex(scene.initial.get(mode, 0.0)) for mode in modes)
    law, reduced = NoContacts(), waves.reduced
    excited = Excited(modes, reduced, law, waves.patterns, initial, initial, waves)
    return _scheduled(scene, None, excited, decisions + wave_decisions(scene, modes, waves))


def _integrated(plan: Plan) -> Plan:
    """Add the decisions of a scene without a friction table."""
    scene = plan.scene
    reason = f'model.table = "none", for {scene.run.duration:g} s in {plan.schedule.steps} steps'
    decisions = [
        *plan.decisions,
        Finding("friction table", "none, time integration at full order", reason),
        *(_fast_motion_decisions(scene) if scene.windows else ()),
        _recording_decision(scene),
        *checks.check_frequencies(plan.excited, plan.schedule, scene.units.frequency),
        *frictionless_findings(plan.excited.law, plan.excited.reduced.n_contacts),
    ]
    return replace(plan, decisions=decisions)


def _tabulated(plan: Plan, progress: bool) -> Plan:
    """Add range, combination resonances and decisions of a scene with a friction table."""
    scene, excited, schedule = plan.scene, plan.excited, plan.schedule
    combinations: tuple[CombinationResonance, ...] = ()
    if excited.waves is not None:
        waves = excited.waves.at_carriers(schedule.mean_frequency(excited.modes))
        excited = replace(excited, reduced=waves.reduced, waves=waves).started(schedule)
    elif scene.model.formulation == "consistent":
        reduced = excited.reduced.at_carrier(schedule.mean_frequency(excited.modes))
        reduced = replace(reduced, force_patterns=np.array(excited.force_patterns))
        excited = replace(excited, reduced=reduced).started(schedule)
        start, end = schedule.frequencies(excited.modes)
        combinations = combinations_along(reduced, start, end, transient=True)
    seen: DryRun | None = None
    if scene.model.amplitude is None:
        seen = dry_run(excited, schedule, combinations, progress=progress)
        amplitude, reason = seen.amplitude, seen.reason
    else:
        amplitude = tuple(scene.model.amplitude["AB".index(mode)] for mode in excited.modes)
        reason = "given as model.amplitude"
    plan = replace(plan, excited=excited, amplitude=amplitude, combinations=combinations)
    found = [
        _other_modes(excited),
        Finding("friction table", _ranges(excited.modes, amplitude), reason),
        *(_combination_decisions(plan) if excited.waves is None else ()),
    ]
    if plan.detuning:
        reason = (
            f"the forcing is up to {percentage(plan.detuning)} away from the reference frequency "
            f"of the table, {_listed(excited.reduced.carrier)} rad/s"
        )
        found.append(Finding("friction", "follows the forcing frequency", reason))
    return _add_decisions(plan, found, seen)


def _on_saved_model(plan: Plan, model: Model) -> Plan:
    """Add the decisions of a scene with a saved model, and run it once on this model."""
    scene, excited, schedule = plan.scene, plan.excited, plan.schedule
    excited = excited.started(schedule)
    with naming("initial"):
        excited.component(model, scene.run.tolerance)  # refuses a start outside the table
    with naming("forcing"):
        check_force_patterns(model, AppliedForces.of(model.reduced, excited.force_patterns))
    seen, inside = run_on_saved_model(excited, schedule, model)
    found = [Finding("friction table", _ranges(excited.modes, seen.amplitude), seen.reason)]
    if not inside:
        reason = "the run ends there. Reduce the forcing, or save a model with a larger range"
        choice = "leave the range of model.file"
        found.append(Finding("amplitudes", choice, reason, "warning"))
    amplitude, combinations = seen.amplitude, model.combinations
    plan = replace(plan, excited=excited, amplitude=amplitude, combinations=combinations)
    if excited.reduced.n_contacts:
        found += [_other_modes(excited), *_combination_decisions(plan)]
    else:
        found.append(Finding("contacts", "none", "model.file has only damping and frequency"))
    return _add_decisions(plan, found, seen)


def _add_decisions(plan: Plan, found: Sequence[Finding], seen: DryRun | None) -> Plan:
    """Add decisions about a friction table, and those that follow from its range and a dry run."""
    scene, excited, schedule = plan.scene, plan.excited, plan.schedule
    largest = np.array(plan.amplitude)
    full_order, transients = plan_transients(
        scene, excited.modes, seen, largest, excited.reduced.carrier
    )
    reached = largest if seen is None else seen.reached
    decisions = [
        *plan.decisions,
        *found,
        transients,
        *_fast_motion_decisions(scene),
        _recording_decision(scene),
        *checks.check_frequencies(excited, schedule, scene.units.frequency),
        *checks.check_assumptions(plan.known_structure, excited, schedule, reached, seen),
    ]
    return replace(plan, decisions=decisions, full_order=full_order)


def _ranges(modes: Sequence[Mode], amplitude: Sequence[float]) -> str:
    return ", ".join(f"|{m}| <= {a:g}" for m, a in zip(modes, amplitude, strict=True))


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
        choice = "modelled"
        if moved or scene.aerodynamics.get(mode, 0j).imag < 0.0:
            why = "forcing" if forced else "initial" if moved else "aerodynamics"
            reason = f"moved by {why}.{mode}"
        elif scene.modes.ratio is not None:
            reason = f"driven by the contacts at {scene.modes.ratio} times the frequency of mode A"
        elif scene.saved_model is not None:
            reason = "part of model.file; neither forced nor moving at t = 0"
        else:
            choice = "left out"
            reason = "neither forced nor moving at t = 0; the contact stiffness includes it"
        if choice == "modelled":
            modes.append(mode)
        decisions.append(Finding(f"mode {mode}", choice, reason))
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


def _force_pattern(scene: Scene, mode: str, reduced: Reduced, index: int) -> np.ndarray:
    """Return the force on every DOF per unit of its amplitude; refuse one without work."""
    if mode not in scene.forcing:
        return np.zeros(reduced.n_dofs)
    pattern = scene.forcing[mode].vector(reduced.n_dofs)
    if not reduced.is_moved_by(index, pattern):
        raise SlipmodeError(
            f"forcing.{mode}: this force does no work on mode {mode}; choose another DOF or vector"
        )
    return pattern


def _preload_decisions(rest: Preload | None) -> list[Finding]:
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


def _other_modes(excited: Excited) -> Finding:
    """Return how the modes that are not retained are modelled."""
    if excited.waves is not None:
        reason = "harmonics of the contacts excite the modes of their nodal diameters"
        return Finding("other modes", "in the friction table", reason)
    reduced = excited.reduced
    responding = reduced.nonresonant_frequency
    if reduced.formulation == "paper":
        return Finding("other modes", "quasi-static response", 'model.formulation is "paper"')
    if not responding.size:
        reason = "no harmonic of the contacts excites another mode dynamically"
        return Finding("other modes", "quasi-static response", reason)
    listed = _listed(responding)
    reason = f"the modes at {listed} rad/s respond dynamically to harmonics of the contacts"
    return Finding("other modes", f"{responding.size} in the friction table", reason)


def _listed(frequency: Floats) -> str:
    return ", ".join(f"{omega:.3g}" for omega in frequency)


def _combination_decisions(plan: Plan) -> list[Finding]:
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


def _fast_motion_decisions(scene: Scene) -> list[Finding]:
    """Return the windows in which fast motion is computed, and the DOFs that are recorded."""
    if not scene.windows:
        return [Finding("fast motion", "none", "no [[contact]] or [[elastic]] window")]
    how = "reconstructed" if scene.tabulated else "integrated"
    found = []
    for kind, windows in (("contact", scene.contact), ("elastic", scene.elastic)):
        for window in windows:
            choice = f"{window.start:g} to {window.end:g} s, {how}"
            reason = f"{window.samples_per_period} samples per period"
            found.append(Finding(f"{kind} motion", choice, reason))
    if dofs := ", ".join(map(str, scene.output.elastic)):
        found.append(Finding("elastic DOFs", dofs, "output.elastic, in every window"))
    return found


def _recording_decision(scene: Scene) -> Finding:
    kinds = [name for name in ("mcap", "rerun") if getattr(scene.log, name)]
    return Finding("recording", " and ".join(kinds) or "none", "chosen in [log]")
