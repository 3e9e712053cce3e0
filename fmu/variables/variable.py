"""A variable of an FMU, and its physical quantity: a declared type with a unit."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, IntEnum
from math import pi


@dataclass(frozen=True)
class Unit:
    """A unit and how it is displayed."""

    name: str
    base: dict[str, int] = field(default_factory=dict)  # exponents of SI units and rad; if whole
    display: str | None = None  # name of the display unit
    factor: float = 1.0  # display value of one unit


UNITS = {
    unit.name: unit
    for unit in (
        Unit("1"),
        Unit("s", {"s": 1}),
        Unit("1/s", {"s": -1}),
        Unit("N", {"kg": 1, "m": 1, "s": -2}, "mN", 1e3),
        Unit("N/s", {"kg": 1, "m": 1, "s": -3}),
        Unit("N/kg^0.5"),
        Unit("N/(kg^0.5.s)"),
        Unit("rad/s", {"rad": 1, "s": -1}, "Hz", 1.0 / (2.0 * pi)),
        Unit("rad/s2", {"rad": 1, "s": -2}),
        Unit("rad", {"rad": 1}, "deg", 180.0 / pi),
        Unit("kg^0.5.m"),
        Unit("kg^0.5.m/s"),
        Unit("m", {"m": 1}, "mm", 1e3),
        Unit("m/s", {"m": 1, "s": -1}, "mm/s", 1e3),
        Unit("J", {"kg": 1, "m": 2, "s": -2}, "mJ", 1e3),
        Unit("W", {"kg": 1, "m": 2, "s": -3}, "mW", 1e3),
    )
}


class Quantity(Enum):
    """A declared type: its name, unit ("" for an enumeration) and description."""

    TIME = ("Time", "s", "Time")
    RATIO = ("Ratio", "1", "Dimensionless number")
    RATIO_RATE = ("RatioRate", "1/s", "Rate of a dimensionless number")
    FORCE = ("Force", "N", "Force")
    FORCE_RATE = ("ForceRate", "N/s", "Rate of a force")
    MODAL_FORCE = ("ModalForce", "N/kg^0.5", "Force on a mode of unit modal mass")
    MODAL_FORCE_RATE = ("ModalForceRate", "N/(kg^0.5.s)", "Rate of a modal force")
    FREQUENCY = ("AngularFrequency", "rad/s", "Angular frequency")
    FREQUENCY_RATE = ("AngularFrequencyRate", "rad/s2", "Rate of an angular frequency")
    ANGLE = ("Angle", "rad", "Angle")
    DAMPING = ("ModalDamping", "1/s", "Modal damping")
    AMPLITUDE = ("ModalAmplitude", "kg^0.5.m", "Amplitude of a mode of unit modal mass")
    AMPLITUDE_RATE = ("ModalAmplitudeRate", "kg^0.5.m/s", "Rate of a modal amplitude")
    DISPLACEMENT = ("Displacement", "m", "Displacement")
    VELOCITY = ("Velocity", "m/s", "Velocity")
    ENERGY = ("Energy", "J", "Energy")
    POWER = ("Power", "W", "Power")
    TABLE_STATUS = ("TableStatus", "", "Place of the amplitudes in the friction table")

    def __init__(self, type_name: str, unit: str, description: str) -> None:
        self.type_name = type_name
        self.unit = unit
        self.description = description


class Type(IntEnum):
    """Data type of a variable, with the values of fmu/src/resources/model.h."""

    REAL = 0
    ENUMERATION = 1
    BOOLEAN = 2
    ARRAY = 3  # of reals: an output of every contact DOF


class Kind(IntEnum):
    """Kind of a variable, with the values of fmu/src/resources/model.h; what its slot counts."""

    OUTPUT = 0  # outputs of sm_component_outputs or sm_tone_outputs; the first is the time
    START = 1  # the same outputs: an amplitude, which may be set before the start
    INPUT = 2  # doubles of sm_inputs
    PARAMETER = 3
    RATE = 4  # derivatives of the states
    MODULUS = 5  # modes
    PHASE = 6  # modes
    MARGIN = 7


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU."""

    name: str  # as in `fmu.Component`, if that has the variable too
    kind: Kind
    slot: int
    quantity: Quantity | None  # declared type with its unit; None for a boolean
    description: str
    start: float | bool | None = None  # None: calculated by the FMU
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None  # of a state
    derivative_of: str | None = None  # name of the state
    needs: tuple[str, ...] = ()  # names of the inputs, states and parameters it depends on
    size: int | None = None  # number of elements of an array

    @property
    def type(self) -> Type:
        """Data type."""
        if self.size is not None:
            return Type.ARRAY
        if self.quantity is None:
            return Type.BOOLEAN
        return Type.REAL if self.quantity.unit else Type.ENUMERATION

    @property
    def causality(self) -> str:
        """Causality as both versions of the standard name it."""
        if self.kind is Kind.OUTPUT and self.slot == 0:
            return "independent"
        named = {Kind.INPUT: "input", Kind.PARAMETER: "parameter", Kind.RATE: "local"}
        return named.get(self.kind, "output")

    @property
    def variability(self) -> str:
        """Variability as both versions of the standard name it; real parameters are tunable."""
        if self.kind is Kind.PARAMETER:
            return "tunable" if self.type is Type.REAL else "fixed"
        return "continuous" if self.type in (Type.REAL, Type.ARRAY) else "discrete"

    @property
    def initial(self) -> str | None:
        """`initial` of an output, a parameter or a local variable; inputs have none."""
        if self.causality in ("input", "independent"):
            return None
        return "calculated" if self.start is None else "exact"
