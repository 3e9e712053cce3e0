"""A variable of an FMU."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

from slipmode.fmu.variables.quantities import Quantity


class Type(IntEnum):
    """Data type of a variable, as fmu/src/resources/model.h counts them."""

    REAL = 0
    ENUMERATION = 1
    BOOLEAN = 2
    ARRAY = 3  # of reals: an output of every contact DOF


class Kind(IntEnum):
    """What a variable is, as fmu/src/resources/model.h counts them; what its slot counts."""

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
    kind : Kind
    slot : int
    causality : Causality
    quantity : Quantity or None
        Declared type with its unit; None for a boolean.
    type : Type
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
    parameters : tuple of str
        Names of the parameters that it depends on.
    tunable : bool
        Of a parameter: whether it may change between steps and at events.
    size : int, optional
        Of an array.
    """

    name: str
    description: str
    kind: Kind
    slot: int
    causality: Causality
    quantity: Quantity | None
    type: Type = Type.REAL
    start: float | bool | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    derivative_of: str | None = None
    needs: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    tunable: bool = False
    size: int | None = None

    @property
    def variability(self) -> str:
        """Variability as both versions of the standard call it."""
        if self.causality is Causality.PARAMETER:
            return "tunable" if self.tunable else "fixed"
        return "continuous" if self.type in (Type.REAL, Type.ARRAY) else "discrete"

    @property
    def initial(self) -> str | None:
        """`initial` of an output, a parameter or a local variable; inputs have none."""
        if self.causality in (Causality.INPUT, Causality.INDEPENDENT):
            return None
        return "calculated" if self.start is None else "exact"
