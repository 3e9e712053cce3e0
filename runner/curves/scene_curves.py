"""Response curves and backbones of the structure of a scene, under its forces at the end."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.contact.slip_onset import slip_onset
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.friction import RigidFriction
from slipmode.rom.reduction.nonlinear.stiffness import refuse_nonlinear_stiffness
from slipmode.rom.reduction.tones import combinations_along
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.branches.forced import Varied
from slipmode.rom.table.cache import cached_model
from slipmode.rom.validity import Finding, warn
from slipmode.runner.plan.plan import ModesPlan
from slipmode.runner.plan.planning import make_plan, plan_scene
from slipmode.runner.plan.tones import TonesPlan
from slipmode.runner.recording.channels import Mode
from slipmode.runner.scene.sections import Scene

_Forced = TypeVar("_Forced", rom.ResponseCurve, rom.PerformanceCurve)


@frozen
class SceneForcing:
    """The forces at the end of a scene."""

    plan: ModesPlan
    frequency: Floats  # (tones,) [rad/s]
    force: list[Floats]  # [N], of each tone
    phase: Floats  # (tones,) [rad]

    @classmethod
    def of(cls, scene: Scene, *, progress: bool = False) -> SceneForcing:
        """Return the forces at the end of a scene, with its plan."""
        scene.check_tabulated()
        plan = make_plan(scene, progress=progress)
        last, tones = slice(-1, None), plan.excited.modes[: plan.excited.reduced.tones]
        frequency, force, phase = (
            plan.schedule.at_ends([f"{name}_{mode}" for mode in tones], last)[0]
            for name in ("frequency", "force", "phase")
        )
        forces = [f * size for f, size in zip(plan.excited.force_patterns, force, strict=False)]
        return cls(plan, frequency, forces, phase)


def scene_response_curve(
    scene: Scene,
    vary: Varied | None = None,
    span: Sequence[ArrayLike] | None = None,
    *,
    progress: bool = False,
) -> rom.ResponseCurve | rom.ToneCurve:
    """Return steady states under the forces at the end of a scene, see `rom.response_curve`.

    The friction table has the range of the curve; on a saved model the curve ends where it leaves
    the table. Of several modes on one tone the curve is a `rom.ToneCurve`.

    Parameters
    ----------
    scene : Scene
    vary : str, optional
        The parameter, as in `rom.response_curve`. Default: the frequency of the first forced mode.
    span : two values, optional
        First and last value of the parameter. Default of a frequency: 5 % to both sides of the
        natural one, or of all natural ones on the tone.
    progress : bool
        Shows progress bars on work longer than a second.
    """
    if scene.modes.tones:
        return _tone_curve(plan_scene(scene), vary, span)
    forcing = SceneForcing.of(scene, progress=progress)
    excited, at_edge = forcing.plan.excited, 0.97  # of a table's range: the curve may be cut off
    vary = vary or cast(Varied, f"frequency_{excited.modes[0]}")
    which = _in_model(vary, excited.modes)
    if span is None:
        if not which.startswith("frequency_"):
            raise SlipmodeError(f"span: is missing; give the first and last value of {vary}")
        natural = float(excited.reduced.frequency["AB".index(which[-1])])
        span = [0.95 * natural, 1.05 * natural]

    combinations: tuple[rom.CombinationResonance, ...] = ()
    if forcing.plan.combinations:  # a run has more of them
        ends = forcing.plan.schedule.frequencies(excited.modes)
        combinations = combinations_along(excited.reduced, *ends)

    def curve_of(model: rom.Model) -> rom.ResponseCurve:
        phase = tuple(forcing.phase)
        return rom.response_curve(model, forcing.frequency, forcing.force, which, span, phase)

    def curve_on(amplitude: Floats, tolerance: float) -> tuple[rom.ResponseCurve, Floats]:
        """Return the curve on a table, and the largest amplitudes in the table (modes,)."""
        model, _ = excited.model(
            amplitude.tolist(),
            tolerance,
            combinations=combinations,
            detuning=which.startswith("frequency"),
            progress=progress,
        )
        curve = curve_of(model)
        size = np.abs(curve.amplitude)
        if which == "limit":  # the table is for limits of scale 1
            size = size / curve.parameter[:, np.newaxis]
        return curve, np.asarray(size.max(axis=0))

    if scene.saved_model is not None:
        curve, largest = curve_of(scene.saved_model), np.array(forcing.plan.amplitude)
        if vary != "limit" and np.any(np.abs(curve.amplitude) > at_edge * largest):
            reason = "more steady states lie outside it. Save a model with a larger range"
            choice = "ends at the range of the friction table of model.file"
            warn([Finding("curve", choice, reason, "warning")])
        return curve
    tried = np.array(forcing.plan.amplitude)
    largest = 3.0**8 * tried  # 7000 times is more than resonance
    while True:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rom.ValidityWarning)  # the final curve repeats them
            _, reached = curve_on(tried, 0.05)  # coarse: it only shows how far the curve goes
        cut_off = reached > at_edge * tried
        if not cut_off.any():
            break
        tried = np.where(cut_off, 3.0 * tried, tried)
        if np.any(tried > largest):
            raise SlipmodeError("span: the amplitudes grow without bound in this span")
    amplitude = 1.1 * np.maximum(reached, 1e-2 * tried)  # twice the coarse tolerance above
    curve, _ = curve_on(amplitude, scene.model.tolerance)
    return _with_structure(curve, forcing.plan.excited.structure)


def _tone_curve(
    plan: TonesPlan, vary: Varied | None, span: Sequence[ArrayLike] | None
) -> rom.ToneCurve:
    reduced, tones = plan.excited.reduced, plan.excited.modes
    vary = vary or "frequency_A"
    if span is None:
        if not vary.startswith("frequency_"):
            raise SlipmodeError(f"span: is missing; give the first and last value of {vary}")
        natural = reduced.frequency[reduced.on_tones[tones.index(vary[-1])]]
        span = [0.95 * natural.min(), 1.05 * natural.max()]
    frequency, size, phase = (
        plan.schedule.at_ends([f"{name}_{tone}" for tone in tones], slice(-1, None))[0]
        for name in ("frequency", "force", "phase")
    )
    forces = [f * pattern for f, pattern in zip(size, plan.excited.force_patterns, strict=True)]
    return rom.response_curve(plan.excited.tone_model, frequency, forces, vary, span, phase)


def scene_backbone(
    scene: Scene, mode: Mode | None = None, other: float = 0.0, *, progress: bool = False
) -> rom.Backbone:
    """Return frequency and damping of a mode up to the amplitudes of a scene.

    Parameters
    ----------
    scene : Scene
    mode : {"A", "B"}, optional
        Default: the first forced mode.
    other : float
        Amplitude of the other mode, see `rom.backbone` [kg^1/2 m].
    progress : bool
        Shows progress bars on work longer than a second.
    """
    plan = make_plan(scene, progress=progress)
    model, _ = plan.model(detuning=True, progress=progress)  # frequency follows amplitude
    return rom.backbone(model, _index(plan.excited.modes, mode), other)


def scene_performance(
    scene: Scene, mode: Mode | None = None, *, progress: bool = False
) -> rom.PerformanceCurve:
    """Return the resonance peak of one mode against limits and preloads.

    The force is the scene's on this mode; see `rom.performance_curve`. The reference frequency of
    the friction table is the forcing frequency of the scene. The table goes well beyond the
    scene's amplitudes, and, unless `model.amplitude` is given, beyond the onset of slip, so that
    the curve has both stuck and fully slipping contacts.

    Parameters
    ----------
    scene : Scene
    mode : {"A", "B"}, optional
        Default: the first forced mode.
    progress : bool
        Shows progress bars on work longer than a second.
    """
    forcing = SceneForcing.of(scene, progress=progress)
    plan = forcing.plan
    at = _index(plan.excited.modes, mode)
    if not forcing.force[at].any():
        name = plan.excited.modes[at]
        raise SlipmodeError(
            f"forcing.{name}: must not be 0, because this force causes the resonance peak"
        )
    refuse_nonlinear_stiffness(
        plan.excited.reduced, "the peak against limits", "compute a response curve for each limit"
    )
    law, aerodynamics = plan.excited.law, plan.excited.reduced.aerodynamics
    reduced = rom.reduce(
        plan.structure,
        (plan.excited.reduced.modes[at],),
        law=None if isinstance(law, RigidFriction) else law,
        carrier=plan.excited.reduced.carrier[at : at + 1].tolist(),
        force_patterns=(forcing.force[at],),
        aerodynamics=None if aerodynamics is None else aerodynamics[at : at + 1].tolist(),
        warned=False,
        progress=progress,
    )
    furthest = plan.amplitude[at]
    if scene.model.amplitude is None:
        furthest = max(furthest, slip_onset(reduced, law, 0)[1])
    # The curve has the same range of limits. Contacts that slide much farther than they stick may
    # not settle; the range is then halved.
    for factor in (8.0, 4.0, 2.0, 1.0):
        try:
            range_, tolerance = (factor * furthest,), scene.model.tolerance
            model, _ = cached_model(
                reduced, law, range_, tolerance, detuning=True, progress=progress
            )
            break
        except SlipmodeError:
            if factor == 1.0:
                raise
    return _with_structure(rom.performance_curve(model, forcing.force[at]), plan.structure)


def _with_structure(curve: _Forced, structure: rom.Structure | None) -> _Forced:
    """Return the curve whose displacements include the quasi-static response to the forces."""
    motion = curve.motion
    if structure is None or motion.applied is None:
        return curve
    static = replace(motion.applied, structure=structure).static
    return replace(curve, motion=replace(motion, static=static))


def _index(modes: Sequence[Mode], mode: Mode | None) -> int:
    """Return the index of a mode in the model of a scene; of the first by default."""
    if mode is not None and mode not in modes:
        raise SlipmodeError(f"mode: must be one that the scene forces, {' or '.join(modes)}")
    return 0 if mode is None else modes.index(mode)


def _in_model(vary: Varied, modes: Sequence[Mode]) -> Varied:
    """Return `vary` for the model's modes: if a scene forces B alone, this is the model's A."""
    name, _, mode = vary.rpartition("_")
    if mode not in ("A", "B"):
        return vary
    if mode not in modes:
        raise SlipmodeError(f"vary: the scene does not force mode {mode}")
    place = "".join(modes).index(mode)
    return cast(Varied, f"{name}_{'AB'[place]}")
