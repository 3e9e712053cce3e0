"""The variables of an FMU: one list, from which everything else about them is derived.

A variable's place in the list is its value reference. `kind` and `slot` tell the C code where its
value is; the rest goes into modelDescription.xml and the documentation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, IntEnum

from fmu.quantities import Quantity
from rom import Coulomb, Model, SlipmodeError, _kernel

EDGE = 0.9  # part of the friction table beyond which `table_status` says near_edge

# Parameters, by slot: two of modal damping, then these.
_TOLERANCE, _CONTACT_WANTED = _kernel.MODES, _kernel.MODES + 1
PARAMETERS = _kernel.MODES + 2


class Type(IntEnum):
    """Data type of a variable, as fmu/src/model.h counts them."""

    REAL = 0
    ENUMERATION = 1
    BOOLEAN = 2


class Kind(IntEnum):
    """What a variable is, as fmu/src/model.h counts them; what its slot counts."""

    OUTPUT = 0  # outputs of sm_component_outputs
    START = 1  # likewise, an amplitude, which may be set before the start
    INPUT = 2  # doubles of sm_inputs
    PARAMETER = 3
    RATE = 4  # derivatives of the states
    MODULUS = 5  # modes
    PHASE = 6  # modes
    MARGIN = 7


class Causality(Enum):
    """Causality of a variable as both versions of the standard call it."""

    INDEPENDENT = "independent"
    PARAMETER = "parameter"
    INPUT = "input"
    OUTPUT = "output"
    LOCAL = "local"


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU.

    Attributes
    ----------
    name : str
        As in `fmu.Component`, where that has it too.
    description : str
    type : Type
    kind : Kind
    slot : int
    causality : Causality
    quantity : Quantity or None
        Declared type with its unit; None for a boolean.
    start : float, bool or None
        None: calculated by the FMU.
    minimum : float, optional
    maximum : float, optional
    nominal : float, optional
        Of a state.
    derivative_of : str, optional
        Name of the state.
    needs : tuple of str
        Names of the inputs and states that it depends on.
    """

    name: str
    description: str
    type: Type
    kind: Kind
    slot: int
    causality: Causality
    quantity: Quantity | None
    start: float | bool | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    derivative_of: str | None = None
    needs: tuple[str, ...] = ()

    @property
    def variability(self) -> str:
        """Variability as both versions of the standard call it."""
        if self.causality is Causality.PARAMETER:
            return "fixed"
        return "continuous" if self.type is Type.REAL else "discrete"

    @property
    def initial(self) -> str | None:
        """`initial` of an output, a parameter or a local variable; inputs have none."""
        if self.causality in (Causality.INPUT, Causality.INDEPENDENT):
            return None
        return "calculated" if self.start is None else "exact"


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
        Start values by name, of inputs, parameters and amplitudes.
    """

    mode_names: tuple[str, ...]
    newtons: bool
    contact: bool
    elastic: tuple[int, ...]
    tolerance: float
    start: Mapping[str, float]


def list_variables(model: Model, choice: Choice) -> list[Variable]:
    """All variables, in the order of their value references.

    Raises
    ------
    SlipmodeError
        If a start value is given to a variable that takes none.
    """
    variables = [_time(), *_inputs(model, choice), *_parameters(model, choice)]
    inputs = [v.name for v in variables if v.kind is Kind.INPUT]
    variables += _states(model, choice)
    variables += _derivatives(model, choice, inputs)
    variables += _outputs(model, choice, inputs)
    if choice.contact:
        variables += _motion(model, choice, inputs)
    return _with_starts(variables, choice.start)


def states(variables: Sequence[Variable]) -> list[Variable]:
    """The continuous states, in the order of their derivatives."""
    named = {v.name: v for v in variables}
    return [named[v.derivative_of] for v in variables if v.derivative_of is not None]


def _with_starts(variables: list[Variable], start: Mapping[str, float]) -> list[Variable]:
    settable = [v.name for v in variables if v.start is not None]
    for name in start:
        if name not in settable:
            raise SlipmodeError(
                f"start: {name} has no start value; those that have: {', '.join(settable)}"
            )
    return [replace(v, start=start[v.name]) if v.name in start else v for v in variables]


def _time() -> Variable:
    return Variable(
        *("time", "Simulated time", Type.REAL, Kind.OUTPUT, 0),
        *(Causality.INDEPENDENT, Quantity.TIME),
    )


def _input_slot(field: str, mode: int) -> int:
    offset: int = _kernel.INPUTS.fields[field][1]  # type: ignore[index]
    return offset // 8 + mode


def _inputs(model: Model, choice: Choice) -> Iterator[Variable]:
    force = Quantity.FORCE if choice.newtons else Quantity.MODAL_FORCE
    for mode, name in enumerate(choice.mode_names):
        of = f"of the force on mode {name}"
        moving = "moves at this rate until it is set again"
        natural = float(model.reduced.frequency[mode])
        for field, description, quantity, start, minimum in (
            ("force", f"Amplitude {of}", force, 0.0, None),
            ("force_rate", f"Rate of the amplitude: it {moving}", force.rate, 0.0, None),
            ("frequency", f"Frequency {of}", Quantity.FREQUENCY, natural, 0.0),
            (
                *("frequency_rate", f"Rate of the frequency: it {moving}"),
                *(Quantity.FREQUENCY.rate, 0.0, None),
            ),
            ("phase", f"Phase {of}", Quantity.ANGLE, 0.0, None),
            ("phase_rate", f"Rate of the phase: it {moving}", Quantity.ANGLE.rate, 0.0, None),
        ):
            yield Variable(
                *(f"{field}_{name}", description, Type.REAL, Kind.INPUT),
                *(_input_slot(field, mode), Causality.INPUT, quantity),
                start=start,
                minimum=minimum,
            )


def _parameters(model: Model, choice: Choice) -> Iterator[Variable]:
    for mode, name in enumerate(choice.mode_names):
        yield Variable(
            *(f"damping_{name}", f"Modal damping phi^T C phi of mode {name}", Type.REAL),
            *(Kind.PARAMETER, mode, Causality.PARAMETER, Quantity.DAMPING),
            start=float(model.reduced.modal_damping[mode]),
            minimum=0.0,
        )
    yield Variable(
        *("tolerance", "Relative tolerance of an internal step", Type.REAL),
        *(Kind.PARAMETER, _TOLERANCE, Causality.PARAMETER, Quantity.RATIO),
        start=choice.tolerance,
        minimum=1e-13,
        maximum=1e-2,
    )
    if choice.contact:
        yield Variable(
            *("contact_wanted", "Compute contact and elastic motion; else they read 0"),
            *(Type.BOOLEAN, Kind.PARAMETER, _CONTACT_WANTED, Causality.PARAMETER, None),
            start=True,
        )


def _states(model: Model, choice: Choice) -> Iterator[Variable]:
    limit = model.table.limit
    modes = choice.mode_names
    for mode, name in enumerate(modes):
        for part, words in enumerate(("Real", "Imaginary")):
            yield Variable(
                *(f"{name}_{('re', 'im')[part]}", f"{words} part of the amplitude of mode {name}"),
                *(Type.REAL, Kind.START, 1 + 2 * mode + part, Causality.OUTPUT),
                Quantity.AMPLITUDE,
                start=0.0,
                nominal=float(limit[mode]),
            )
    for mode, name in enumerate(modes):
        yield Variable(
            *(f"theta_{name}", f"Carrier angle of mode {name}, the integral of its frequency"),
            *(Type.REAL, Kind.OUTPUT, 5 + mode, Causality.OUTPUT, Quantity.ANGLE),
            nominal=1.0,
        )
    energy = float(max((model.reduced.frequency * limit) ** 2))
    yield Variable(
        *("dissipated_energy", "Energy dissipated at the contacts since the start", Type.REAL),
        *(Kind.OUTPUT, 9, Causality.OUTPUT, Quantity.ENERGY),
        nominal=energy,
    )


def _amplitudes(choice: Choice) -> tuple[str, ...]:
    return tuple(f"{name}_{part}" for name in choice.mode_names for part in ("re", "im"))


def _thetas(choice: Choice) -> tuple[str, ...]:
    return tuple(f"theta_{name}" for name in choice.mode_names)


def _power_needs(model: Model, choice: Choice, inputs: Sequence[str]) -> tuple[str, ...]:
    """What the friction power depends on: the rates of the inputs do not enter."""
    values = tuple(name for name in inputs if "_rate" not in name)
    return (*values, *_amplitudes(choice), *(_thetas(choice) if model.near else ()))


def _rate_needs(model: Model, choice: Choice, inputs: Sequence[str]) -> tuple[str, ...]:
    return (*inputs, *_amplitudes(choice), *(_thetas(choice) if model.near else ()))


def _derivatives(model: Model, choice: Choice, inputs: Sequence[str]) -> Iterator[Variable]:
    amplitudes = [
        (name, Quantity.AMPLITUDE, _rate_needs(model, choice, inputs))
        for name in _amplitudes(choice)
    ]
    angles = [
        (f"theta_{name}", Quantity.ANGLE, (f"frequency_{name}",)) for name in choice.mode_names
    ]
    energy = ("dissipated_energy", Quantity.ENERGY, _power_needs(model, choice, inputs))
    for slot, (state, quantity, needs) in enumerate((*amplitudes, *angles, energy)):
        yield Variable(
            *(f"der({state})", f"Rate of {state}", Type.REAL, Kind.RATE, slot, Causality.LOCAL),
            quantity.rate,
            derivative_of=state,
            needs=needs,
        )


def _outputs(model: Model, choice: Choice, inputs: Sequence[str]) -> Iterator[Variable]:
    for mode, name in enumerate(choice.mode_names):
        needs = (f"{name}_re", f"{name}_im")
        yield Variable(
            *(f"{name}_abs", f"Modulus of the amplitude of mode {name}", Type.REAL),
            *(Kind.MODULUS, mode, Causality.OUTPUT, Quantity.AMPLITUDE),
            needs=needs,
        )
        yield Variable(
            *(f"{name}_phase", f"Phase of mode {name} against its force's carrier", Type.REAL),
            *(Kind.PHASE, mode, Causality.OUTPUT, Quantity.ANGLE),
            needs=needs,
        )
    yield Variable(
        *("input_power", "Mean power of the forces", Type.REAL, Kind.OUTPUT, 7),
        *(Causality.OUTPUT, Quantity.POWER),
        needs=_rate_needs(model, choice, inputs),
    )
    yield Variable(
        *("dissipated_power", "Mean power dissipated at the contacts", Type.REAL),
        *(Kind.OUTPUT, 8, Causality.OUTPUT, Quantity.POWER),
        needs=_power_needs(model, choice, inputs),
    )
    yield Variable(
        "table_status",
        f"Whether the amplitudes are inside the friction table or beyond {EDGE:.0%} of its range",
        *(Type.ENUMERATION, Kind.MARGIN, 0, Causality.OUTPUT, Quantity.TABLE_STATUS),
        needs=_amplitudes(choice),
    )


def _motion(model: Model, choice: Choice, inputs: Sequence[str]) -> Iterator[Variable]:
    needs = (*inputs, *_amplitudes(choice), *_thetas(choice))
    contacts = model.reduced.n_contacts
    slot = _kernel.OUTPUTS_FIXED
    for letter, words, quantity in (
        ("x", "Displacement", Quantity.DISPLACEMENT),
        ("v", "Velocity", Quantity.VELOCITY),
        ("f", "Friction force", Quantity.FORCE),
    ):
        for contact in range(contacts):
            yield Variable(
                *(f"contact_{contact}_{letter}", f"{words} at contact {contact}", Type.REAL),
                *(Kind.OUTPUT, slot, Causality.OUTPUT, quantity),
                needs=needs,
            )
            slot += 1
    for dof in choice.elastic:
        yield Variable(
            *(f"x_{dof}", f"Displacement of DOF {dof}", Type.REAL, Kind.OUTPUT, slot),
            *(Causality.OUTPUT, Quantity.DISPLACEMENT),
            needs=needs,
        )
        slot += 1


def scales_with_limit(model: Model) -> bool:
    """Whether one table serves every friction limit: Coulomb friction is homogeneous."""
    return isinstance(model.law, Coulomb)
