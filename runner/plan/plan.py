"""What a scene needs modelled, and why: decided before anything is computed for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipmode.fmu import Component
from slipmode.rom import Model, Reduced, SlipmodeError, Structure
from slipmode.rom.contact.static_preload import Preload, loaded_by_friction
from slipmode.rom.laws.friction import RigidFriction
from slipmode.rom.laws.states import STATES
from slipmode.rom.reduction.combination import (
    CombinationResonance,
    combination_resonances,
    separation,
)
from slipmode.rom.reduction.force_response import ForceResponse
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.table.cache import cached_model
from slipmode.rom.validity import Finding as Decision
from slipmode.rom.validity import frictionless_findings
from slipmode.runner.plan.amplitude_range import Excited, dry_run
from slipmode.runner.plan.assumptions import check_assumptions, check_frequencies
from slipmode.runner.plan.fast_motion import ORDERS, measure_truncation
from slipmode.runner.plan.time_scales import check_time_scales
from slipmode.runner.plan.transients import Stretches, plan_transients
from slipmode.runner.recording.channels import MODES, Mode
from slipmode.runner.scene.contacts import check_scale, law_of, preloaded
from slipmode.runner.scene.kept import kept_reduction
from slipmode.runner.scene.nodes import located
from slipmode.runner.scene.scene import Scene, Window
from slipmode.runner.scene.schedule import Schedule, make_schedule


@dataclass(frozen=True, eq=False)
class Plan:
    """A scene and everything decided about it.

    Attributes
    ----------
    scene : Scene
    structure : Structure
    excited : Excited
        What is modelled: modes, reduced matrices, friction law, force patterns.
    schedule : Schedule
    amplitude : tuple of float
        Range of the friction table [kg^1/2 m]; none where all of the scene is integrated.
    combinations : tuple of CombinationResonance
        Combination frequencies that come near a carrier during the scene.
    elastic_order : int or None
        Order of the harmonics that are summed in elastic windows; None: nothing is summed.
    full_order : tuple of (float, float)
        Start and end [s] of the stretches that are integrated at full order, by the dry run.
    decisions : list of Decision
    """

    scene: Scene
    structure: Structure
    excited: Excited
    schedule: Schedule
    amplitude: tuple[float, ...]
    combinations: tuple[CombinationResonance, ...]
    elastic_order: int | None
    full_order: Stretches
    decisions: list[Decision]

    def __repr__(self) -> str:
        reach = ", ".join(f"{amplitude:.4g}" for amplitude in self.amplitude)
        how = f"amplitudes to {reach}" if self.scene.tabulated else "integrated"
        return (
            f"Plan({self.scene.title!r}: mode {' and '.join(self.excited.modes)}, "
            f"{self.excited.reduced.n_contacts} contacts, {how}, "
            f"{self.schedule.steps} steps, {len(self.decisions)} decisions)"
        )

    @property
    def warnings(self) -> list[str]:
        """Return the decisions that are warnings, each as one line."""
        return [
            f"{each.subject} {each.choice}: {each.reason}"
            for each in self.decisions
            if each.level != "info"
        ]

    @property
    def may_be_integrated(self) -> bool:
        """Whether `model.table = "none"` could be had instead of the table."""
        scene = self.scene
        fixed = scene.limit_scale is None
        return scene.tabulated and fixed and scene.model.formulation != "paper"

    def model(
        self,
        *,
        contact: bool = False,
        headroom: float = 1.0,
        detuning: bool = False,
        progress: bool = False,
    ) -> tuple[Model, bool]:
        """The model of the scene, and whether it came from the cache.

        `contact` asks for one that has contact motion whatever the scene wants of it, `detuning`
        for one whose friction follows frequencies off the carriers, even if they are constant.
        """
        self.scene.check_tabulated()
        return cached_model(
            *(self.excited.reduced, self.excited.law, self.amplitude),
            self.scene.model.tolerance,
            combinations=self.combinations,
            harmonics=self._harmonics(contact),
            headroom=headroom,
            detuning=detuning or self._frequencies_move,
            budget=self.scene.model.budget,
            progress=progress,
        )

    def _harmonics(self, contact: bool) -> int:
        """Order up to which the model keeps harmonics; a march wants what the modes respond to."""
        marched = (
            contact or self.scene.contact or (self.scene.elastic and self.elastic_order is None)
        )
        responding = self.scene.model.formulation == "consistent"
        return max(RESPONSE_ORDER if marched and responding else 0, self.elastic_order or 0)

    @property
    def _frequencies_move(self) -> bool:
        """Whether the forcing leaves the carriers of the friction table."""
        least, most = self.schedule.extremes([f"frequency_{m}" for m in self.excited.modes])
        return bool(np.any(least != most)) and self.scene.model.formulation == "consistent"

    def component(self, model: Model) -> Component:
        """A component at t = 0 of the scene."""
        return self.excited.component(model, self.scene.run.tolerance)


def make_plan(scene: Scene, *, structure: Structure | None = None, progress: bool = False) -> Plan:
    """Decide what the scene needs.

    Parameters
    ----------
    scene : Scene
    structure : Structure, optional
        That of the scene, where it has been built already: what was solved of it is kept with it.
    progress : bool, default False
        Whether to say on standard error what a large structure is at.

    Raises
    ------
    SlipmodeError
        If the scene and its structure do not fit together.
    """
    modes, mode_decisions = _modes(scene)
    structure = scene.structure.build() if structure is None else structure
    scene = located(scene, structure)
    numbers = dict(zip("AB", scene.modes.numbers, strict=False))
    law = law_of(scene, structure.n_contacts)
    rest = preloaded(scene, structure, law)
    law = law if rest is None else rest.law
    check_scale(scene, law, structure.n_contacts)
    reduced = kept_reduction(
        structure,
        [numbers[m] for m in modes],
        scene.model.formulation,
        None if isinstance(law, RigidFriction) else law,
        _aerodynamics(scene, modes),
        progress=progress,
    )
    initial = tuple(complex(scene.initial.get(mode, 0.0)) for mode in modes)
    excited = Excited(
        modes,
        reduced,
        law,
        tuple(_force_pattern(scene, mode, reduced, index) for index, mode in enumerate(modes)),
        initial,
        initial,
    )
    _check_outputs(scene, reduced)
    schedule = make_schedule(scene, dict(zip(modes, reduced.frequency.tolist(), strict=True)))
    check_time_scales(scene, schedule, modes, reduced)
    of_frequencies = check_frequencies(excited, schedule, scene.units.frequency)
    if not scene.tabulated:
        decisions = [
            *mode_decisions,
            *_preload_decisions(rest),
            *_integrated(scene, schedule),
            *of_frequencies,
            *frictionless_findings(law, structure.n_contacts),
        ]
        return Plan(scene, structure, excited, schedule, (), (), None, (), decisions)
    combinations: tuple[CombinationResonance, ...] = ()
    if scene.model.formulation == "consistent":
        excited = replace(excited, reduced=_at_frequencies(excited, schedule))
        excited = replace(excited, amplitude=start_amplitudes(excited, schedule))
        frequencies = [f"frequency_{mode}" for mode in modes]
        straight = schedule.stretches()
        combinations = combination_resonances(
            straight.inputs(frequencies), straight.at_ends(frequencies), even=reduced.even
        )
    seen = None
    if scene.model.amplitude is None:
        seen = dry_run(excited, schedule, combinations, progress=progress)
        amplitude, reason = seen.amplitude, seen.reason
    else:
        given = dict(zip("AB", scene.model.amplitude, strict=False))
        amplitude, reason = tuple(given[mode] for mode in modes), "given as model.amplitude"
    full_order, transients = plan_transients(
        scene, modes, seen, np.array(amplitude), excited.reduced.carrier
    )
    elastic_order, motion_decisions = _fast_motion(scene, excited, amplitude, combinations)
    ranges = ", ".join(f"|{m}| <= {a:g}" for m, a in zip(modes, amplitude, strict=True))
    decisions = [
        *mode_decisions,
        *_preload_decisions(rest),
        _other_modes(excited.reduced),
        Decision("friction table", ranges, reason),
        *_combination_decisions(combinations),
        transients,
        *motion_decisions,
        *_recording_decisions(scene),
        *of_frequencies,
        *check_assumptions(
            *(structure, excited, np.array(amplitude) if seen is None else seen.reached),
            *(np.abs(schedule.extremes([f"force_{m}" for m in modes])).max(axis=0), seen),
        ),
    ]
    return Plan(
        *(
            scene,
            structure,
            excited,
            schedule,
            amplitude,
            combinations,
            elastic_order,
            full_order,
            decisions,
        )
    )


def _modes(scene: Scene) -> tuple[tuple[Mode, ...], list[Decision]]:
    """Modes that move at all, with the reason for each."""
    modes: list[Mode] = []
    decisions = []
    moves = False
    for mode in MODES[: len(scene.modes.numbers)]:
        forcing = scene.forcing.get(mode)
        forced = forcing is not None and forcing.amplitude.range(0.0, scene.run.duration)[1] > 0
        moved = forced or scene.initial.get(mode, 0.0) != 0.0
        moves = moves or moved
        if moved or scene.aerodynamics.get(mode, 0j).imag < 0.0:
            modes.append(mode)
            why = "forcing" if forced else "initial" if moved else "aerodynamics"
            decisions.append(Decision(f"mode {mode}", "modelled", f"moved by {why}.{mode}"))
        else:
            reason = "neither forced nor moving at t = 0; its flexibility stays in the contacts"
            decisions.append(Decision(f"mode {mode}", "left out", reason))
    if not moves:
        raise SlipmodeError(
            "forcing: nothing moves; give forcing.A.amplitude or initial.A a value other than 0"
        )
    return tuple(modes), decisions


def _preload_decisions(rest: Preload | None) -> list[Decision]:
    """What the static force makes of the contacts."""
    if rest is None:
        return []
    closed = rest.normal_force[rest.normal_force > 0.0]
    count = {word: np.count_nonzero(rest.state == k) for k, word in enumerate(STATES)}
    states = ", ".join(f"{n} {word}" for word, n in count.items() if n)
    pressed = (
        f"normal forces {closed.min():.3g} to {closed.max():.3g} N" if closed.size else "no load"
    )
    found = [Decision("contacts at rest", states, pressed)]
    if reason := loaded_by_friction(rest):
        found.append(Decision("static force", "tangential at contacts", reason, "warning"))
    return found


def _integrated(scene: Scene, schedule: Schedule) -> list[Decision]:
    """What becomes of a scene without a friction table."""
    reason = f'model.table = "none", for {scene.run.duration:g} s in {schedule.steps} steps'
    decisions = [Decision("friction table", "none, all at full order", reason)]
    for subject, windows in (("contact", scene.contact), ("elastic", scene.elastic)):
        for window in windows:
            decisions.append(_window_decision(f"{subject} motion", window, "integrated"))
    return [*decisions, *_elastic_decisions(scene), *_recording_decisions(scene)]


def _aerodynamics(scene: Scene, modes: Sequence[Mode]) -> list[complex] | None:
    """Coefficients of the modes that are modelled."""
    if not scene.aerodynamics:
        return None
    return [scene.aerodynamics.get(mode, 0j) for mode in modes]


def _other_modes(reduced: Reduced) -> Decision:
    """What becomes of the modes that are not retained."""
    responding = reduced.nonresonant_frequency
    if reduced.formulation == "paper":
        return Decision("other modes", "follow statically", 'model.formulation is "paper"')
    if not responding.size:
        reason = "no harmonic of the contacts makes one of them respond otherwise"
        return Decision("other modes", "follow statically", reason)
    listed = ", ".join(f"{omega:.3g}" for omega in responding)
    reason = f"those at {listed} rad/s respond to harmonics of the contacts, in the table"
    return Decision("other modes", f"{responding.size} modelled, without an equation", reason)


def _force_pattern(scene: Scene, mode: str, reduced: Reduced, index: int) -> np.ndarray:
    """Force on every DOF per unit of its amplitude; it must be able to move its mode."""
    if mode not in scene.forcing:
        return np.zeros(reduced.n_dofs)
    pattern = scene.forcing[mode].vector(reduced.n_dofs)
    if not reduced.is_moved_by(index, pattern):
        raise SlipmodeError(
            f"forcing.{mode}: this force does no work on mode {mode}; choose another DOF or vector"
        )
    return pattern


def _at_frequencies(excited: Excited, schedule: Schedule) -> Reduced:
    """With the contact problem at the forcing frequencies, and what the forces do to it."""
    reduced = excited.reduced.at_carrier(schedule.mean_frequency(excited.modes))
    return replace(reduced, force_patterns=np.array(excited.force_patterns))


def start_amplitudes(excited: Excited, schedule: Schedule) -> tuple[complex, ...]:
    """Amplitudes with which the modes move as the scene says, under the forces at t = 0."""
    reduced, first = excited.reduced, slice(1)
    force, _ = excited.modal_forces(schedule, first)
    frequency = schedule.inputs([f"frequency_{mode}" for mode in excited.modes], first)
    force_response = ForceResponse.of(reduced, excited.force_patterns)
    at_rest = force_response.free_vibration(reduced, force[0], frequency[0])
    return tuple((np.array(excited.initial) + at_rest).tolist())


def _check_outputs(scene: Scene, reduced: Reduced) -> None:
    for dof in scene.output.elastic:
        if not 0 <= dof < reduced.n_dofs:
            raise SlipmodeError(
                f"output.elastic: DOF {dof} is out of range, allowed: 0 to {reduced.n_dofs - 1}"
            )


def _combination_decisions(combinations: Sequence[CombinationResonance]) -> list[Decision]:
    if not combinations:
        return [Decision("combination resonances", "none", "no combination frequency is near")]
    return [
        Decision(
            "combination resonance",
            f"{term.n:+d} A {term.m:+d} B",
            f"within {separation((term.n, term.m)):.0%} of mode {MODES[term.mode]} in this scene: "
            "in its slow flow",
        )
        for term in combinations
    ]


def _fast_motion(
    scene: Scene,
    excited: Excited,
    amplitude: Sequence[float],
    combinations: Sequence[CombinationResonance],
) -> tuple[int | None, list[Decision]]:
    """Order of the harmonics summed for elastic motion, if any, and every such decision."""
    if not (scene.contact or scene.elastic):
        reason = "no [[contact]] or [[elastic]] window"
        return None, [Decision("fast motion", "none", reason)]
    dofs, tolerance = scene.output.elastic, scene.model.tolerance
    truncation = measure_truncation(excited, amplitude, combinations, dofs)
    order = truncation.order_within(tolerance) if scene.elastic else None
    missed = f"harmonics to order {ORDERS[-1]} miss"
    what = "displacement" if excited.reduced.contacts is None else "slip"
    decisions = [
        _window_decision(
            *("contact motion", window, "marched"),
            f"{missed} {truncation.contact[-1]:.2g} of the {what}, more of the velocity",
        )
        for window in scene.contact
    ]
    if order is None:
        how, why = "marched", f"{missed} {truncation.elastic[-1]:.2g} of it, above {tolerance:g}"
    else:
        missing = truncation.elastic[ORDERS.index(order)]
        how = f"harmonics to order {order} summed"
        why = f"they miss {missing:.1g} of it, model.tolerance is {tolerance:g}"
    decisions += [_window_decision("elastic motion", window, how, why) for window in scene.elastic]
    return order, decisions + _elastic_decisions(scene)


def _window_decision(subject: str, window: Window, how: str, *why: str) -> Decision:
    choice = f"{window.start:g} to {window.end:g} s, {how}"
    reasons = (f"{window.samples_per_period} samples per period", *why)
    return Decision(subject, choice, "; ".join(reasons))


def _elastic_decisions(scene: Scene) -> list[Decision]:
    listed = ", ".join(map(str, scene.output.elastic))
    return [Decision("elastic DOFs", listed, "output.elastic, in every window")] if listed else []


def _recording_decisions(scene: Scene) -> list[Decision]:
    kinds = [name for name in ("mcap", "rerun") if getattr(scene.log, name)]
    return [Decision("recording", " and ".join(kinds) or "none", "[log]")]
