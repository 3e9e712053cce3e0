"""Phase resonance of a mode with friction from the contact problem.

At the frequency of a mode at given amplitudes, Re (omega^2 - Omega^2 + i gamma Omega - S / a) = 0.
"""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.slow.branches.solve_points import LOWEST_SQUARE, solve_points
from slipmode.rom.slow.direct.contact_friction import (
    ContactFriction,
    ContactPoints,
    ContactSolutions,
)
from slipmode.rom.slow.slow_flow import ForcedFlow

# Step of finite differences, relative to the unknowns: forces of the contacts jump by about 1e-6
# where a contact turns between two time steps.
_DIFFERENCE = 1e-4


def contact_phase_resonance(
    start: ForcedFlow, mode: int, amplitude: Complexes
) -> tuple[ForcedFlow, Complexes, ContactSolutions] | None:
    """Return the flow at the frequencies of a mode at amplitudes (points, modes), with friction.

    Friction is S (points, modes) [N kg^-1/2]. `start` is the flow without forces near these
    frequencies. None if the contact problem has no solution at one of the amplitudes.
    """
    natural = start.model.reduced.frequency[mode]
    friction, frequency = ContactFriction.of(start.model, None), start.frequency.copy()

    def at(square: Floats) -> tuple[ForcedFlow, Complexes]:
        """Return the flow at frequencies relative to the natural one, and S."""
        frequency[:, mode] = natural * np.sqrt(np.maximum(square[:, 0], LOWEST_SQUARE))
        flow = start.with_frequency(frequency)
        return flow, friction(ContactPoints.of(flow, amplitude))

    def residual(square: Floats) -> Floats:
        flow, S = at(square)
        stiffness = flow.balance(amplitude).stiffness - S / amplitude
        return np.asarray(stiffness[:, [mode]].real / natural**2)

    square, found = solve_points(residual, (frequency[:, [mode]] / natural) ** 2, _DIFFERENCE)
    if not found.all():
        return None
    flow, S = at(square)
    return flow, S, ContactSolutions(friction, np.zeros((len(S), 0), dtype=complex))
