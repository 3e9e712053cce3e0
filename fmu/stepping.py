"""The interface that the runner steps: inputs go in, outputs come out, step by step."""

from __future__ import annotations

from typing import Protocol

from slipmode.rom import SlipmodeError
from slipmode.rom.arrays import Floats


class StoppedError(SlipmodeError):
    """A step that could not be taken; the component is unchanged.

    Parameters
    ----------
    message : str
        What stopped it, and what to do.

    Attributes
    ----------
    time : float
        Present time of the component [s].
    outputs : (steps, outputs) ndarray
        Outputs of the steps before, in the same call.
    left_table : bool
        Whether an amplitude leaves the friction table, so that a larger table helps.
    """

    def __init__(
        self, message: str, time: float, outputs: Floats, left_table: bool = False
    ) -> None:
        super().__init__(message)
        self.time = time
        self.outputs = outputs
        self.left_table = left_table


class Steppable(Protocol):
    """The interface of `Component`, and of an FMU behind the same names."""

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; the others keep their values."""

    def do_step(self, time: float, duration: float) -> None:
        """Advance from `time` by `duration` > 0."""

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the present time."""
        ...

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Advance by many steps with inputs (steps, inputs); return outputs (steps, outputs)."""
        ...
