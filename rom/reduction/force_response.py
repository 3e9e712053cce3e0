"""What the forces do past their own mode: to the other modes, the contacts, and statically.

A point force on one DOF drives every mode. The one it is near resonance with has its slow flow;
the others answer to it off resonance, the contacts feel it directly, and what neither modes nor
contacts have follows it statically.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.reduction.reduced import Reduced, force_vector
from slipmode.rom.slow.slow_flow import answer_across, felt_shift
from slipmode.rom.structure.matrices import as_dense, solve
from slipmode.rom.structure.structure import Structure


@dataclass(frozen=True, eq=False)
class DirectForce:
    """Forces past their own mode, each per unit of its modal force F_j; 0 where F_j is.

    Attributes
    ----------
    modal : (modes, modes + passive) ndarray
        Force phi_k^T f_j on every mode [-].
    contact : (modes, N_c) ndarray
        Force X^T f_j on the contacts [kg^1/2].
    static : (n, modes) ndarray
        Displacement by the static flexibility that modes and contact shapes leave over
        [kg^1/2 m/N]; 0 where the structure is not known.
    shift : (modes,) complex ndarray
        The part that the amplitude equations have: rom.amplitude.felt_shift.
    across : (modes, modes) complex ndarray
        Displacement of mode k off resonance, [k, j]: rom.amplitude.answer_across.
    """

    modal: Floats
    contact: Floats
    static: Floats
    shift: Complexes
    across: Complexes

    @classmethod
    def of(
        cls,
        reduced: Reduced,
        force: Sequence[Mapping[int, float] | ArrayLike],
        structure: Structure | None = None,
    ) -> Self:
        """Of one {DOF: amplitude} or (n,) pattern per mode, on the structure that was reduced.

        Without the structure the displacement of DOFs lacks the static part.
        """
        f = np.array([force_vector(pattern, reduced.n_dofs) for pattern in force])
        modal = f @ reduced.all_shapes
        own = np.diag(modal)
        f = np.divide(f, own[:, np.newaxis], out=np.zeros_like(f), where=own[:, np.newaxis] != 0)
        static = np.zeros_like(f.T)
        if structure is not None and reduced.formulation == "consistent":
            static = _left_over(structure, reduced, f.T)
        return cls(
            modal=f @ reduced.all_shapes,
            contact=f @ reduced.contact_shapes,
            static=static,
            shift=felt_shift(reduced, force),
            across=answer_across(reduced, force),
        )

    def beyond_shift(self, reduced: Reduced) -> Complexes:
        """Force on the contacts less what they have of it by the shift, (modes, N_c)."""
        return np.asarray(self.contact + 2.0 * self.shift[:, np.newaxis] * reduced.coupling)

    def free_vibration(
        self, reduced: Reduced, jump: Complexes, frequency: Floats, angle: Floats | float = 0.0
    ) -> Complexes:
        """Amplitudes (..., modes) that jumps of the forces add: the modes go on as they were.

        From rest they hold the modes at rest as forces set in. It is what the core does in a step
        that begins with other forces than those it had: see rom/kernel/jump.h.

        Parameters
        ----------
        jump : (..., modes) complex ndarray
            Of F_j exp(i phase_j), modal [N kg^-1/2].
        frequency, angle : (..., modes) ndarray
            Of the carriers at the jump [rad/s], [rad].
        """
        if reduced.formulation == "paper":
            return np.zeros_like(jump)
        turned = jump * np.exp(1j * np.asarray(angle))
        gamma, omega = reduced.modal_damping, reduced.frequency
        damped = np.sqrt(np.maximum(omega**2 - 0.25 * gamma**2, 0.0))
        vibrates = damped > 0.0
        damped = np.where(vibrates, damped, 1.0)
        q = self.across * turned[..., np.newaxis, :]
        answered = q.real.sum(axis=-1)
        moving = (q.imag * frequency[..., np.newaxis, :]).sum(axis=-1)
        own = (turned / (gamma + 2j * (frequency + damped))).real
        left = -answered + 1j * (own + 0.5 * gamma * answered - moving) / damped
        return np.where(vibrates, left * np.exp(-1j * np.asarray(angle)), 0.0)


def _left_over(structure: Structure, reduced: Reduced, f: Floats) -> Floats:
    """Static displacement (n, forces) with stuck contacts, less that of all modes kept."""
    parts = structure.partition()
    stuck = as_dense(parts.E @ solve(parts.K_ee, as_dense(parts.E.T @ f)))
    squares = np.append(reduced.frequency, reduced.passive_frequency) ** 2
    shapes = reduced.all_shapes
    return np.asarray(stuck - (shapes / squares) @ (shapes.T @ f))
