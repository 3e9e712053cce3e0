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

from rom.amplitude import Complexes, felt_shift
from rom.matrices import Floats, as_dense, solve
from rom.reduced import Reduced, force_vector
from rom.structure import Structure


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
    """

    modal: Floats
    contact: Floats
    static: Floats
    shift: Complexes

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
        )

    def beyond_shift(self, reduced: Reduced) -> Complexes:
        """Force on the contacts less what they have of it by the shift, (modes, N_c)."""
        return np.asarray(self.contact + 2.0 * self.shift[:, np.newaxis] * reduced.coupling)

    def amplitude_at_rest(
        self, reduced: Reduced, force: Complexes, frequency: Floats
    ) -> Complexes:
        """Amplitudes (modes,) that hold the modes at rest as forces set in.

        A mode's answer to the force of the other is there at once: it begins with a free
        vibration against it, which decays with the mode.

        Parameters
        ----------
        force : (modes,) complex ndarray
            F_j exp(i phase_j) at the start, modal [N kg^-1/2].
        frequency : (modes,) ndarray
            Forcing frequencies [rad/s].
        """
        a = np.zeros(len(force), dtype=complex)
        if reduced.formulation == "paper":
            return a
        stiffness = reduced.modal_stiffness(frequency)
        for j, D in enumerate(stiffness):
            other = np.arange(len(D)) != j
            q = np.zeros(len(D), dtype=complex)
            on_them = 0.5 * force[j] * self.modal[j, other]
            q[other] = np.linalg.solve(D[np.ix_(other, other)], on_them)
            # 2 Re(a + q) = 0 and 2 Re(i Omega_k a + i Omega_j q) = 0
            answered = q[: a.size]
            a -= answered.real + 1j * frequency[j] / frequency * answered.imag
        return a


def _left_over(structure: Structure, reduced: Reduced, f: Floats) -> Floats:
    """Static displacement (n, forces) with stuck contacts, less that of all modes kept."""
    parts = structure.partition()
    stuck = as_dense(parts.E @ solve(parts.K_ee, as_dense(parts.E.T @ f)))
    squares = np.append(reduced.frequency, reduced.passive_frequency) ** 2
    shapes = reduced.all_shapes
    return np.asarray(stuck - (shapes / squares) @ (shapes.T @ f))
