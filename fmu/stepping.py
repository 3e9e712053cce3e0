"""The interface that the runner steps: inputs go in, outputs come out, step by step."""

from __future__ import annotations

from typing import Protocol

from slipmode.rom import SlipmodeError
from slipmode.rom.arrays import Floats


class StoppedError(SlipmodeError):
    """Report a step that is not possible; the component keeps its state.

    Parameters
    ----------
    message : str
        Reason, and what to do.
    time : float
        Present time of the component [s].
    outputs : (steps, outputs) ndarray
        Outputs of the previous steps in this call, in the order and units of
        `Component.output_names`. NaN in the last row: outputs that cannot be computed.
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
    """Define the interface that `Component` and imported FMUs have in common.

    Attributes
    ----------
    input_names : tuple of str
        Names of the inputs, see `Component`.
    output_names : tuple of str
        Names of the outputs, see `Component`.
    """

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]

    def set_inputs(self, **values: float) -> None:
        """Set inputs by name; other inputs keep their values.

        Parameters
        ----------
        **values : float
            Values by name of the input, in the units of `Component`.
        """

    def do_step(self, time: float, duration: float) -> None:
        """Advance by one communication step.

        Parameters
        ----------
        time : float
            Present time [s].
        duration : float
            Length of the step [s], > 0.
        """

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the present time.

        Returns
        -------
        dict of str to float
            Values by name, in the units of `Component`.
        """
        ...

    def run(self, durations: Floats, inputs: Floats) -> Floats:
        """Advance by many communication steps in one call.

        Parameters
        ----------
        durations : (steps,) ndarray
            Length of each step [s].
        inputs : (steps, inputs) ndarray
            Inputs at the start of each step, in the order of `input_names`.

        Returns
        -------
        (steps, outputs) ndarray
            Outputs at the end of each step, in the order of `output_names`.
        """
        ...
