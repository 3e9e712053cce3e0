"""What is found in measured loops."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from slipmode.rom import Iwan, Jenkins, Sliders
from slipmode.rom.common import percentage
from slipmode.rom.identification.loops.problem import Fitted
from slipmode.rom.slow import axes_or_new

LoopLaw: TypeAlias = Jenkins | Iwan | Sliders


@dataclass(frozen=True, eq=False, repr=False)
class LoopFit:
    """Hold the law of a joint that was fitted to measured loops.

    Attributes
    ----------
    model : str
        The chosen model in words.
    parameters : dict of str to float
        Stiffness of each element in stick, `spring` [N/m], `backlash` [m], and friction limits
        [N]: `limit`, or `limit_forward` while the displacement rises and `limit_backward` while it
        falls. Of several loops, limits and backlash have the name of the loop before a point. Of
        several elements, `share_1`, `share_2`, ... are their shares of the limits. `chi` and
        `beta` are as in `rom.Iwan`.
    interval : dict of str to (float, float)
        99 % interval of each parameter from the scatter of the cycles; infinite for those that the
        loops do not determine.
    error : dict of str to float
        Rms error of the model over each loop, relative to its peak force [-].
    laws : dict of str to Jenkins, Iwan or Sliders
        Contact law of each loop for structures: without backlash, equal in both directions.
    law_error : dict of str to float
        Rms error of the law with the constant force, relative to the peak force [-].
    mean_force : dict of str to float
        Constant force in addition to the law [N].
    tried : dict of str to float
        Rms errors of all models that were tried [-].
    warnings : tuple of str
        What limits the use of the result, one line each.
    fitted, law_fitted : Fitted
        Fits of the model and of the contact law, from which pictures are made.
    """

    model: str
    parameters: dict[str, float]
    interval: dict[str, tuple[float, float]]
    error: dict[str, float]
    laws: dict[str, LoopLaw]
    law_error: dict[str, float]
    mean_force: dict[str, float]
    tried: dict[str, float]
    warnings: tuple[str, ...]
    fitted: Fitted = field(repr=False)
    law_fitted: Fitted = field(repr=False)

    def __repr__(self) -> str:
        errors = ", ".join(f"{name} {percentage(error)}" for name, error in self.error.items())
        return f"LoopFit: {self.model}; rms error relative to the peak force: {errors}"

    def plot(self, axes: Any = None) -> Any:
        """Plot the measured loops, the model and the contact law.

        Parameters
        ----------
        axes : (loops,) array of Axes, optional
            Matplotlib axes. Default: a new figure.

        Returns
        -------
        (loops,) array of Axes
            Axes of the plots.
        """
        levels = self.fitted.levels
        axes = axes_or_new(axes, 1, len(levels), squeeze=False)
        axes = np.ravel(axes)
        shown = [("C1-", "model", self.fitted)]
        if self.law_fitted is not self.fitted:
            shown.append(("C2--", "contact law", self.law_fitted))
        for i, (level, ax) in enumerate(zip(levels, axes, strict=True)):
            ax.plot(level.used_displacement, level.used_force, "C0", lw=0.6, label="measured")
            for style, name, fitted in shown:
                force = fitted.forces(i)[0]
                ax.plot(level.used_displacement, force, style, lw=1.2, label=name)
            ax.set_title(f"{level.name}: {percentage(self.error[level.name])}")
            ax.set_xlabel("displacement [m]")
        axes[0].set_ylabel("force [N]")
        axes[0].legend()
        return axes
