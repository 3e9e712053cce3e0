"""A variable of an FMU."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from slipmode.fmu.variables.quantities import Quantity


class Type(IntEnum):
    """Data type of a variable, with the values of fmu/src/resources/model.h."""

    REAL = 0
    ENUMERATION = 1
    BOOLEAN = 2
    ARRAY = 3  # of reals: an output of every contact DOF


class Kind(IntEnum):
    """Kind of a variable, with the values of fmu/src/resources/model.h; what its slot counts."""

    OUTPUT = 0  # outputs of sm_component_outputs; the first is the time
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
