"""The variables of an FMU: one list, from which everything else about them is derived.

A variable's place in the list is its value reference. `kind` and `slot` tell the C code where its
value is; the rest goes into modelDescription.xml and the documentation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isfinite

from slipmode.fmu.inputs import place
from slipmode.fmu.variables.quantities import Quantity
from slipmode.fmu.variables.variable import Causality, Kind, Type, Variable
from slipmode.rom import Model, SlipmodeError, kernel
from slipmode.rom.laws.directions import ContactDirection, contact_directions
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.validity import carrier_range

EDGE = 0.9  # part of the friction table beyond which `table_status` says near_edge

# Parameters by slot: the modal dampings, then these.
_TOLERANCE, _CONTACT_WANTED = kernel.MODES, kernel.MODES + 1
PARAMETERS = kernel.MODES + 2

# Outputs of the core by slot: time, (Re, Im) of two amplitudes, two angles, then these.
_ANGLES, _INPUT_POWER, _DISSIPATED_POWER, _DISSIPATED_ENERGY = 5, 7, 8, 9


@dataclass(frozen=True)
class Choice:
    """What the variables depend on besides the model.

    Attributes
    ----------
    mode_names : tuple of str
    newtons : bool
        Whether forces are in newtons, not modal.
    contact : bool
        Whether there is contact motion.
    elastic : tuple of int
        DOFs whose displacement is an output.
    tolerance : float
        Default of the internal tolerance.
    start : mapping of str to float
        Start values by name, of inputs and amplitudes.
    largest : mapping of str to float
        Largest magnitudes by name, of force inputs.
    """

    mode_names: tuple[str, ...]
    newtons: bool
    contact: bool
    elastic: tuple[int, ...]
    tolerance: float
    start: Mapping[str, float]
    largest: Mapping[str, float] = field(default_factory=dict)


def list_variables(model: Model, choice: Choice) -> list[Variable]:
    """All variables, in the order of their value references.

    Raises
    ------
    SlipmodeError
        If a start value is given to a variable that takes none, or is not finite.
    """
    time = Variable("time", "Simulated time", Kind.OUTPUT, 0, Causality.INDEPENDENT, Quantity.TIME)
    inputs = list(_inputs(model, choice))
    needs = _Needs(model, choice, inputs)
    variables = [time, *inputs, *_parameters(model, choice), *_states(model, choice)]
    variables += [*_derivatives(choice, needs), *_outputs(choice, needs)]
    if choice.contact:
        variables += _motion(model, choice, needs)
    return _with_starts(variables, choice.start)


def states(variables: Sequence[Variable]) -> list[Variable]:
    """The continuous states, in the order of their derivatives."""
    named = {v.name: v for v in variables}
    return [named[v.derivative_of] for v in variables if v.derivative_of is not None]


def _with_starts(variables: list[Variable], start: Mapping[str, float]) -> list[Variable]:
    settable = {v.name: v for v in variables if v.kind in (Kind.INPUT, Kind.START)}
    for name, value in start.items():
        if name not in settable:
            raise SlipmodeError(f"start: {name} cannot be given; what can: {', '.join(settable)}")
        if not isfinite(value):
            raise SlipmodeError(f"start: {name} must be finite, got {value}")
        if name.startswith("force_") and abs(value) > (settable[name].maximum or inf):
            most = settable[name].maximum
            raise SlipmodeError(
                f"start: {name} must be at most largest_force, {most:g}, got {value:g}"
            )
    return [replace(v, start=start[v.name]) if v.name in start else v for v in variables]


class _Needs:
    """What variables depend on: names of inputs and states."""

    def __init__(self, model: Model, choice: Choice, inputs: Sequence[Variable]) -> None:
        names = choice.mode_names
        self.dampings = tuple(f"damping_{name}" for name in names)
        self.inputs = tuple(v.name for v in inputs)
        self.amplitudes = tuple(f"{name}_{part}" for name in names for part in ("re", "im"))
        self.angles = tuple(f"theta_{name}" for name in names)
        # combination resonances follow the carrier angles
        followed = (*self.amplitudes, *(self.angles if model.combinations else ()))
        # of the amplitudes; and the friction power, by the rate correction
        self.rate = (*self.inputs, *followed)
        self.margin = (*self.amplitudes, *(n for n in self.inputs if n == "limit_scale"))
        self.motion = (*self.inputs, *self.amplitudes, *self.angles)


def _inputs(model: Model, choice: Choice) -> Iterator[Variable]:
    force = Quantity.FORCE if choice.newtons else Quantity.MODAL_FORCE
    quantities = {"force": force, "frequency": Quantity.FREQUENCY, "phase": Quantity.ANGLE}
    words = {"force": "Amplitude", "frequency": "Frequency", "phase": "Phase"}
    for mode, name in enumerate(choice.mode_names):
        natural = float(model.reduced.frequency[mode])
        lowest, highest = carrier_range(natural)
        for word, quantity in quantities.items():
            called = f"{word}_{name}"
            least, most = (lowest, highest) if word == "frequency" else (None, None)
            if called in choice.largest:
                least, most = -choice.largest[called], choice.largest[called]
            yield Variable(
                called,
                f"{words[word]} of the force on mode {name}",
                Kind.INPUT,
                place(word, mode),
                Causality.INPUT,
                quantity,
                start=natural if word == "frequency" else 0.0,
                minimum=least,
                maximum=most,
            )
            yield Variable(
                f"{word}_rate_{name}",
                f"Rate of {called}, which moves at it until it is set again",
                Kind.INPUT,
                place(f"{word}_rate", mode),
                Causality.INPUT,
                quantity.rate,
                start=0.0,
            )

    if is_homogeneous(model.law, model.reduced.n_contacts):
        description = "Friction limits and preloads relative to the model's"
        yield _scale("limit_scale", description, Quantity.RATIO, 1.0, 0.0)
        description = "Rate of limit_scale, which moves at it until it is set again"
        yield _scale("limit_scale_rate", description, Quantity.RATIO_RATE, 0.0, None)


def _scale(
    name: str, description: str, quantity: Quantity, start: float, minimum: float | None
) -> Variable:
    return Variable(
        name,
        description,
        Kind.INPUT,
        place(name),
        Causality.INPUT,
        quantity,
        start=start,
        minimum=minimum,
    )


def _parameters(model: Model, choice: Choice) -> Iterator[Variable]:
    for mode, name in enumerate(choice.mode_names):
        yield Variable(
            f"damping_{name}",
            f"Modal damping of mode {name}, below 0 if it is self-excited",
            Kind.PARAMETER,
            mode,
            Causality.PARAMETER,
            Quantity.DAMPING,
            start=float(model.reduced.modal_damping[mode]),
            tunable=True,
        )
    yield Variable(
        "tolerance",
        "Relative tolerance of an internal step",
        Kind.PARAMETER,
        _TOLERANCE,
        Causality.PARAMETER,
        Quantity.RATIO,
        start=choice.tolerance,
        minimum=1e-13,
        maximum=1e-2,
        tunable=True,
    )
    if choice.contact:
        yield Variable(
            "contact_wanted",
            "Compute the motion of contacts and DOFs; else it reads 0",
            Kind.PARAMETER,
            _CONTACT_WANTED,
            Causality.PARAMETER,
            None,
            Type.BOOLEAN,
            start=True,
        )


def _states(model: Model, choice: Choice) -> Iterator[Variable]:
    amplitude_range = model.table.amplitude_range
    for mode, name in enumerate(choice.mode_names):
        for part, word in enumerate(("Real", "Imaginary")):
            yield Variable(
                f"{name}_{('re', 'im')[part]}",
                f"{word} part of the amplitude of mode {name}",
                Kind.START,
                1 + 2 * mode + part,
                Causality.OUTPUT,
                Quantity.AMPLITUDE,
                start=0.0,
                nominal=float(amplitude_range[mode]),
            )
    for mode, name in enumerate(choice.mode_names):
        description = f"Carrier angle of mode {name}: the integral of its frequency, in [0, 2 pi)"
        yield _output(f"theta_{name}", description, _ANGLES + mode, Quantity.ANGLE, nominal=1.0)
    yield _output(
        "dissipated_energy",
        "Energy dissipated at the contacts since the start",
        _DISSIPATED_ENERGY,
        Quantity.ENERGY,
        nominal=float(max((model.reduced.frequency * amplitude_range) ** 2)),
    )


def _derivatives(choice: Choice, needs: _Needs) -> Iterator[Variable]:
    damped = needs.dampings
    rates: list[tuple[str, Quantity, tuple[str, ...], tuple[str, ...]]] = [
        *((name, Quantity.AMPLITUDE, needs.rate, damped) for name in needs.amplitudes),
        *((f"theta_{m}", Quantity.ANGLE, (f"frequency_{m}",), ()) for m in choice.mode_names),
        ("dissipated_energy", Quantity.ENERGY, needs.rate, damped),
    ]
    for slot, (state, quantity, needed, parameters) in enumerate(rates):
        yield Variable(
            f"der({state})",
            f"Rate of {state}",
            Kind.RATE,
            slot,
            Causality.LOCAL,
            quantity.rate,
            derivative_of=state,
            needs=needed,
            parameters=parameters,
        )


def _outputs(choice: Choice, needs: _Needs) -> Iterator[Variable]:
    for mode, name in enumerate(choice.mode_names):
        for suffix, kind, quantity, description in (
            ("abs", Kind.MODULUS, Quantity.AMPLITUDE, f"Modulus of the amplitude of mode {name}"),
            ("phase", Kind.PHASE, Quantity.ANGLE, f"Phase of mode {name} against its carrier"),
        ):
            yield Variable(
                f"{name}_{suffix}",
                description,
                kind,
                mode,
                Causality.OUTPUT,
                quantity,
                needs=(f"{name}_re", f"{name}_im"),
            )
    yield _output(
        "input_power",
        "Mean power of the forces",
        _INPUT_POWER,
        Quantity.POWER,
        needs=needs.rate,
        parameters=needs.dampings,
    )
    yield _output(
        "dissipated_power",
        "Mean power dissipated at the contacts",
        _DISSIPATED_POWER,
        Quantity.POWER,
        needs=needs.rate,
        parameters=needs.dampings,
    )
    yield Variable(
        "table_status",
        f"Whether the amplitudes are inside the friction table or beyond {EDGE:.0%} of its range",
        Kind.MARGIN,
        0,
        Causality.OUTPUT,
        Quantity.TABLE_STATUS,
        Type.ENUMERATION,
        needs=needs.margin,
    )


def _motion(model: Model, choice: Choice, needs: _Needs) -> Iterator[Variable]:
    slot = kernel.OUTPUTS_FIXED
    parameters = (*needs.dampings, "contact_wanted")
    moving = partial(_output, needs=needs.motion, parameters=parameters)
    directions = contact_directions(model.law, model.reduced.n_contacts)
    for letter, quantity in (
        ("x", Quantity.DISPLACEMENT),
        ("v", Quantity.VELOCITY),
        ("f", Quantity.FORCE),
    ):
        for i, direction in enumerate(directions):
            description = _contact_words(letter, direction, i)
            yield moving(f"contact_{i}_{letter}", description, slot, quantity)
            slot += 1
    for dof in choice.elastic:
        description = f"Displacement of DOF {dof}"
        yield moving(f"x_{dof}", description, slot, Quantity.DISPLACEMENT)
        slot += 1
    yield from _motion_arrays(len(directions), moving)


def _motion_arrays(size: int, moving: Callable[..., Variable]) -> Iterator[Variable]:
    """All of it once more, last of all: FMI 2.0 has no arrays, and does not know them."""
    for k, (letter, word, quantity) in enumerate(
        (
            ("x", "Displacement", Quantity.DISPLACEMENT),
            ("v", "Velocity", Quantity.VELOCITY),
            ("f", "Force", Quantity.FORCE),
        )
    ):
        description = f"{word} at every contact DOF, as contact_0_{letter}, ... have it"
        one = moving(f"contact_{letter}", description, kernel.OUTPUTS_FIXED + k * size, quantity)
        yield replace(one, type=Type.ARRAY, size=size)


def _contact_words(letter: str, direction: ContactDirection, i: int) -> str:
    words = {"x": "displacement", "v": "velocity", "f": "force"}[letter]
    positive = ", positive where it closes" if direction.normal else ""
    if direction.normal and letter == "f":
        words, positive = "force beyond the preload", ""
    said = f"{direction.words} {words}".capitalize()
    return f"{said} at contact DOF {i}{positive} ({direction.law})"


def _output(
    name: str,
    description: str,
    slot: int,
    quantity: Quantity,
    *,
    nominal: float | None = None,
    needs: tuple[str, ...] = (),
    parameters: tuple[str, ...] = (),
) -> Variable:
    return Variable(
        name,
        description,
        Kind.OUTPUT,
        slot,
        Causality.OUTPUT,
        quantity,
        nominal=nominal,
        needs=needs,
        parameters=parameters,
    )
