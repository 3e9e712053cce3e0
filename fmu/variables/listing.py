"""The variables of an FMU: one list, from which everything else about them is derived.

The place of a variable in the list is its value reference. `kind` and `slot` say where the C code
finds its value; the other attributes go into modelDescription.xml and the documentation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf, isfinite
from typing import Self

from slipmode.fmu.description.options import ExportOptions
from slipmode.fmu.inputs import (
    AnyModel,
    carried_frequencies,
    place,
    relative_range,
    tone_names,
)
from slipmode.fmu.variables.variable import Kind, Quantity, Variable
from slipmode.rom import Model, SlipmodeError, kernel
from slipmode.rom.laws.directions import ContactDirection, contact_directions
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.table.local.tone_model import ToneModel

_ANGLE = "the integral of its frequency, 0 to 2 pi"
_ENERGY = "Energy dissipated at the contacts since the start"


@dataclass(frozen=True)
class _Slots:
    """Slots of outputs, as sm_component_outputs or sm_tone_outputs packs them."""

    amplitude: int
    angle: int
    power: int
    energy: int
    motion: int  # of contacts and DOFs

    @classmethod
    def of(cls, model: AnyModel) -> Self:
        modes, angles = kernel.MODES, kernel.MODES
        if isinstance(model, ToneModel):
            modes, angles = model.modes, model.reduced.tones
        power = 1 + 2 * modes + angles
        return cls(1, 1 + 2 * modes, power, power + 2, power + 3)


def list_variables(model: AnyModel, newtons: bool, options: ExportOptions) -> list[Variable]:
    """Return all variables, in the order of their value references.

    `newtons` is whether forces are in newtons, not modal; the mode names of the options are those
    of the model. Raises SlipmodeError if a start value is given to a variable that takes none, or
    is not finite.
    """
    inputs = list(_inputs(model, newtons, options))
    modes, names = options.mode_names, tuple(v.name for v in inputs)
    if isinstance(model, ToneModel):
        outputs = [*_tone_states(model, modes, names), *_results(model, modes, names)]
    else:
        outputs = list(_outputs(model, modes, names))
    variables = [
        Variable("time", Kind.OUTPUT, 0, Quantity.TIME, "Simulated time"),
        *inputs,
        *_parameters(model, options),
        *outputs,
    ]
    if options.contact:
        variables += _motion(model, options, variables)
    return _with_starts(variables, options.start)


def states(variables: Sequence[Variable]) -> list[Variable]:
    """Return the continuous states, in the order of their derivatives."""
    named = {v.name: v for v in variables}
    return [named[v.derivative_of] for v in variables if v.derivative_of is not None]


def _with_starts(variables: list[Variable], start: Mapping[str, float]) -> list[Variable]:
    settable = {v.name: v for v in variables if v.kind in (Kind.INPUT, Kind.START)}
    for name, value in start.items():
        if name not in settable:
            raise SlipmodeError(f"start: {name} must be one of {', '.join(settable)}")
        if not isfinite(value):
            raise SlipmodeError(f"start: {name} must be finite, got {value}")
        if name.startswith("force_") and abs(value) > (settable[name].maximum or inf):
            most = settable[name].maximum
            raise SlipmodeError(
                f"start: {name} must be at most {most:g} (largest_force), got {value:g}"
            )
    return [replace(v, start=start[v.name]) if v.name in start else v for v in variables]


def _inputs(model: AnyModel, newtons: bool, options: ExportOptions) -> Iterator[Variable]:
    force = (Quantity.FORCE, Quantity.FORCE_RATE)
    modal_force = (Quantity.MODAL_FORCE, Quantity.MODAL_FORCE_RATE)
    rows = (
        ("force", "Amplitude", *(force if newtons else modal_force)),
        ("frequency", "Frequency", Quantity.FREQUENCY, Quantity.FREQUENCY_RATE),
        ("phase", "Phase", Quantity.ANGLE, Quantity.FREQUENCY),
    )
    holds = "The input changes at this rate until it is set again"
    range_of_modes = relative_range(model)
    moving = "the modes of tone" if isinstance(model, ToneModel) else "mode"
    for mode, letter in enumerate(tone_names(model, options.mode_names)):
        natural = float(carried_frequencies(model)[mode])
        for word, title, quantity, rate in rows:
            name = f"{word}_{letter}"
            start, least, most = 0.0, None, None
            if word == "frequency":
                start, (least, most) = natural, (natural * end for end in range_of_modes)
            if name in options.largest_force:
                least, most = -options.largest_force[name], options.largest_force[name]
            said = f"{title} of the force on {moving} {letter}"
            yield Variable(name, Kind.INPUT, place(word, mode), quantity, said, start, least, most)
            slot = place(f"{word}_rate", mode)
            said = f"Rate of {name}. {holds}"
            yield Variable(f"{word}_rate_{letter}", Kind.INPUT, slot, rate, said, start=0.0)
    if is_homogeneous(model.law, model.reduced.n_contacts):
        said = "Factor on the friction limits and preloads of the model"
        slot = place("limit_scale")
        yield Variable("limit_scale", Kind.INPUT, slot, Quantity.RATIO, said, 1.0, 0.0)
        said = f"Rate of limit_scale. {holds}"
        slot = place("limit_scale_rate")
        yield Variable("limit_scale_rate", Kind.INPUT, slot, Quantity.RATIO_RATE, said, 0.0)


def _parameters(model: AnyModel, options: ExportOptions) -> Iterator[Variable]:
    damped = () if isinstance(model, ToneModel) else options.mode_names
    for mode, letter in enumerate(damped):
        said = f"Modal damping of mode {letter}, negative for a self-excited mode"
        damping = float(model.reduced.modal_damping[mode])
        name = f"damping_{letter}"
        yield Variable(name, Kind.PARAMETER, mode, Quantity.DAMPING, said, damping)
    slot, said = kernel.MODES, "Relative tolerance of an internal step"
    limits = (options.tolerance, 1e-13, 1e-2)
    yield Variable("tolerance", Kind.PARAMETER, slot, Quantity.RATIO, said, *limits)
    if options.contact:
        slot, said = kernel.MODES + 1, "Whether contact motion is computed; otherwise it is 0"
        yield Variable("contact_wanted", Kind.PARAMETER, slot, None, said, start=True)
    if isinstance(model, Model) and model.samples is not None:
        slot, said = kernel.MODES + 2, "Sample of the rates of the modes; 0 is the model itself"
        limits = (options.sample, 0.0, float(len(model.samples)))
        yield Variable("sample", Kind.PARAMETER, slot, Quantity.RATIO, said, *limits)


def _outputs(model: Model, modes: Sequence[str], inputs: tuple[str, ...]) -> Iterator[Variable]:
    """Yield states, their derivatives, and what follows from them."""
    amplitudes = tuple(f"{letter}_{part}" for letter in modes for part in ("re", "im"))
    angles = tuple(f"theta_{letter}" for letter in modes)
    dampings = tuple(f"damping_{letter}" for letter in modes)
    dampings += ("sample",) if model.samples is not None else ()
    # combination resonances follow the carrier angles
    needs = (*inputs, *amplitudes, *(angles if model.combinations else ()), *dampings)
    largest, slots = model.table.amplitude_range, _Slots.of(model)

    for k, name in enumerate(amplitudes):
        said, slot = _amplitude_words(modes[k // 2], k % 2), slots.amplitude + k
        size = float(largest[k // 2])
        yield Variable(name, Kind.START, slot, Quantity.AMPLITUDE, said, 0.0, nominal=size)
    for mode, name in enumerate(angles):
        said = f"Carrier phase of mode {modes[mode]}, {_ANGLE}"
        yield Variable(name, Kind.OUTPUT, slots.angle + mode, Quantity.ANGLE, said, nominal=1.0)
    energy, nominal = "dissipated_energy", float(max((model.reduced.frequency * largest) ** 2))
    yield Variable(energy, Kind.OUTPUT, slots.energy, Quantity.ENERGY, _ENERGY, nominal=nominal)

    rates = [(name, Quantity.AMPLITUDE_RATE, needs) for name in amplitudes]
    driven = [modes[min(j, model.reduced.tones - 1)] for j in range(len(modes))]
    rates += [
        (f"theta_{m}", Quantity.FREQUENCY, (f"frequency_{by}",))
        for m, by in zip(modes, driven, strict=True)
    ]
    rates.append((energy, Quantity.POWER, needs))
    for slot, (state, quantity, needed) in enumerate(rates):
        name, said = f"der({state})", f"Rate of {state}"
        yield Variable(name, Kind.RATE, slot, quantity, said, derivative_of=state, needs=needed)

    yield from _results(model, modes, needs)
    said = "Place of the amplitudes in the friction table: inside, or above 90 % of its range"
    needs = (*amplitudes, *(name for name in inputs if name == "limit_scale"))
    yield Variable("table_status", Kind.MARGIN, 0, Quantity.TABLE_STATUS, said, needs=needs)


def _tone_states(
    model: ToneModel, modes: Sequence[str], inputs: tuple[str, ...]
) -> Iterator[Variable]:
    """Yield amplitudes, carrier phases and energy of modes that share a tone.

    The importer cannot set them. Amplitudes jump with the inputs, so that displacements do not.
    """
    slots, quantity = _Slots.of(model), Quantity.AMPLITUDE
    for k, part in product(range(len(modes)), range(2)):
        name, slot = f"{modes[k]}_{('re', 'im')[part]}", slots.amplitude + 2 * k + part
        said = _amplitude_words(modes[k], part)
        yield Variable(name, Kind.OUTPUT, slot, quantity, said, needs=inputs)
    for tone, name in enumerate(tone_names(model, modes)):
        said, slot = f"Carrier phase of tone {name}, {_ANGLE}", slots.angle + tone
        yield Variable(f"theta_{name}", Kind.OUTPUT, slot, Quantity.ANGLE, said)
    yield Variable("dissipated_energy", Kind.OUTPUT, slots.energy, Quantity.ENERGY, _ENERGY)


def _amplitude_words(mode: str, part: int) -> str:
    return f"{('Real', 'Imaginary')[part]} part of the amplitude of mode {mode}"


def _results(model: AnyModel, modes: Sequence[str], needs: tuple[str, ...]) -> Iterator[Variable]:
    """Yield moduli, phases and powers; the powers depend on `needs`."""
    slots, tone = _Slots.of(model), isinstance(model, ToneModel)
    for mode, letter in enumerate(modes):
        own = needs if tone else (f"{letter}_re", f"{letter}_im")
        said = f"Modulus of the amplitude of mode {letter}"
        yield Variable(f"{letter}_abs", Kind.MODULUS, mode, Quantity.AMPLITUDE, said, needs=own)
        said = f"Phase of mode {letter} relative to its carrier"
        yield Variable(f"{letter}_phase", Kind.PHASE, mode, Quantity.ANGLE, said, needs=own)
    said = "Mean power of the forces"
    yield Variable("input_power", Kind.OUTPUT, slots.power, Quantity.POWER, said, needs=needs)
    said = "Mean power dissipated at the contacts"
    slot = slots.power + 1
    yield Variable("dissipated_power", Kind.OUTPUT, slot, Quantity.POWER, said, needs=needs)


def _motion(
    model: AnyModel, options: ExportOptions, variables: Sequence[Variable]
) -> Iterator[Variable]:
    """Yield the motion of contact DOFs and DOFs, and all contact DOFs as arrays.

    The arrays are last: FMI 2.0 has none.
    """
    kinds = (Kind.INPUT, Kind.PARAMETER, Kind.START)
    needed = [v.name for v in variables if v.kind in kinds or v.name.startswith("theta_")]
    needs = tuple(name for name in needed if name != "tolerance")
    directions = contact_directions(model.law, model.reduced.n_contacts)
    rows = (
        ("x", "displacement", Quantity.DISPLACEMENT),
        ("v", "velocity", Quantity.VELOCITY),
        ("f", "force", Quantity.FORCE),
    )
    slot = _Slots.of(model).motion
    arrays = []
    for letter, word, quantity in rows:
        said = f"{word.capitalize()} of all contact DOFs: contact_0_{letter}, ..."
        name, size = f"contact_{letter}", len(directions)
        if size > 0:
            array = Variable(name, Kind.OUTPUT, slot, quantity, said, needs=needs, size=size)
            arrays.append(array)
        for i, direction in enumerate(directions):
            name, said = f"contact_{i}_{letter}", _contact_words(word, direction, i)
            yield Variable(name, Kind.OUTPUT, slot + i, quantity, said, needs=needs)
        slot += size
    for k, dof in enumerate(options.elastic):
        said, quantity = f"Displacement of DOF {dof}", Quantity.DISPLACEMENT
        yield Variable(f"x_{dof}", Kind.OUTPUT, slot + k, quantity, said, needs=needs)
    yield from arrays


def _contact_words(word: str, direction: ContactDirection, i: int) -> str:
    positive = ", positive where it closes" if direction.normal else ""
    if direction.normal and word == "force":
        word, positive = "force beyond the preload", ""
    said = f"{direction.words} {word}".capitalize()
    return f"{said} at contact DOF {i}{positive} ({direction.law})"
