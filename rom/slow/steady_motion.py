"""Displacement of degrees of freedom in steady states.

In a steady state with amplitudes a_j the harmonic of the displacement at carrier j is

    x_j = phi_j a_j + sum_k phi_k q_kj + X P_j + static_j F_j / 2,

with the response q_kj of the other modes, the carrier harmonic P_j of the contacts (for elastic
contacts: of their force deficit), the contact shapes X, and the quasi-static response to the
force. A friction table only has the force of P_j on the modes, so the contact problem is solved
again at the amplitudes.
"""

from __future__ import annotations

from functools import cached_property
from typing import Self

import numpy as np

from slipmode.rom.arrays import Complexes, Flags, Floats, check_dof
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.direct.contact_friction import ContactPoints, ContactSolutions
from slipmode.rom.slow.direct.steady_harmonics import Receptance
from slipmode.rom.slow.nonresonant.response import ModalResponse, response_to
from slipmode.rom.slow.slow_flow import ForcedFlow
from slipmode.rom.slow.trajectory import SlowTrajectory
from slipmode.rom.table.model import Model


@frozen
class SteadyMotion:
    """Steady states of a model, at points."""

    model: Model
    amplitude: Complexes  # (points, modes), a_j [kg^1/2 m]
    frequency: Floats  # (points, modes), Omega_j [rad/s]
    # (points, modes), F_j exp(i phase_j), modal [N kg^-1/2]; 0 where the force is not known
    force: Complexes
    applied: AppliedForces | None  # Where the forces act. None: there are no forces.
    scale: Floats  # (points,), friction limits and preloads relative to the model's
    # `AppliedForces.static` (n_dofs, modes) of the structure. None: `applied.static`.
    static: Floats | None = None
    contact: ContactSolutions | None = None  # None: the contact motion is the table's
    # (points,), where the contact motion is the table's although `contact` is given. None: nowhere
    tabulated: Flags | None = None

    @classmethod
    def of(cls, flow: ForcedFlow, amplitude: Complexes, applied: AppliedForces | None) -> Self:
        """Return the steady states of a flow."""
        factor = np.array(flow.inputs["limit_scale"])
        return cls(flow.model, amplitude, flow.frequency, flow.force, applied, factor)

    def displacement(self, dof: int) -> Floats:
        """Return the amplitude of a DOF at each carrier, (points, modes) [m].

        Raises
        ------
        SlipmodeError
            If there is no such DOF.
        """
        reduced = self.model.reduced
        check_dof(dof, reduced.n_dofs)
        if self.contact is None:
            x = self._of_table(dof)
        else:
            modal, carriers = self._at_frequencies
            x = modal @ reduced.all_shapes[dof] + carriers @ reduced.contact_shapes[dof]
        if self.tabulated is not None:
            x = np.where(self.tabulated[:, np.newaxis], self._of_table(dof), x)
        static = self.static
        if static is None and self.applied is not None:
            static = self.applied.static
        if static is not None:
            x = x + 0.5 * static[dof] * self.force
        return np.asarray(2.0 * np.abs(x))

    def _of_table(self, dof: int) -> Complexes:
        """Return the harmonics of a DOF with the contact motion of the table, (points, modes)."""
        reduced, response = self.model.reduced, self._response
        moved = response.modal @ self.model.all_shapes[dof]
        moved += response.contact @ reduced.contact_shapes[dof]
        return np.asarray(reduced.mode_shapes[dof] * self.amplitude + moved[: len(self.amplitude)])

    @cached_property
    def _at_frequencies(self) -> tuple[Complexes, Complexes]:
        """All modes (points, modes, all modes) and contacts (points, modes, N_c) at the carriers.

        By contact problems at the forcing frequencies.
        """
        reduced, modes = self.model.reduced, self.amplitude.shape[1]
        scale = self.scale[:, np.newaxis]
        assert self.contact is not None
        friction, response = self.contact
        points = ContactPoints(
            self.frequency, self.force / scale, self.amplitude / scale, scale, response / scale
        )
        carriers = friction.motion(points).carriers
        pattern = np.zeros((modes, reduced.n_dofs))
        if self.applied is not None:
            pattern = self.applied.per_modal_force
        modal = []
        for Omega, F, P in zip(self.frequency.tolist(), self.force, carriers, strict=True):
            half = 0.5 * F[:, np.newaxis] * pattern
            at = Receptance.of(reduced.at_carrier(Omega), CARRIERS[:modes], half)
            modal.append(at.modal(P))
        found, own = np.array(modal), np.arange(modes)
        found[:, own, own] = self.amplitude
        return found, carriers

    @cached_property
    def _response(self) -> ModalResponse:
        """Carriers of the contacts and response of the modes at the points, the last one twice."""
        points, modes = self.amplitude.shape
        trajectory = SlowTrajectory(  # a step per point, each computed by itself
            time=np.arange(points + 1.0),
            amplitude=np.vstack((self.amplitude, self.amplitude[-1:])),
            angle=np.zeros((points + 1, modes)),
            frequency=self.frequency,
            frequency_rate=np.zeros((points, modes)),
            force=self.force,
            force_rate=np.zeros((points, modes), dtype=complex),
            force_response=self.applied,
            scale=self.scale,
        )
        P = self._contact_carriers(trajectory.effective(self.model)[:points])
        P = np.concatenate((P, P[-1:]))
        return response_to(self.model, trajectory, CARRIERS[:modes], P)

    def _contact_carriers(self, effective: Complexes) -> Complexes:
        """Return P_j (points, modes, N_c) at effective amplitudes (points, modes)."""
        model, scale = self.model, self.scale[:, np.newaxis]
        modulus = np.abs(effective)
        if not model.reduced.n_contacts:
            return np.zeros((*modulus.shape, 0), dtype=complex)
        # the least scale of a march is a tenth of the table's range
        torus = model.contact_problem(0.1 * model.table.amplitude_range)
        terms = torus.on_more_lines(torus.solve(modulus / scale))
        unit = np.divide(effective, modulus, out=np.ones_like(effective), where=modulus > 0.0)
        return scale[..., np.newaxis] * terms.at_carriers(unit)
