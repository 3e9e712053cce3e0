"""The slow flow, Eqs. (18) and (19), in the frame of the forcing, at many points.

mass_j a_j' + stiffness_j a_j = F_j exp(i phase_j) / 2 + Q_j(|a_A|, |a_B|) a_j
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.detuning import coupling_factor
from slipmode.rom.reduction.force_response import AppliedForces, ForcePatterns, phasor
from slipmode.rom.reduction.nonlinear.stiffness import hardening
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.model import Model


def slow_flow(model: Model, force_patterns: ForcePatterns | None = None) -> kernel.Structure:
    """Return the slow flow as the core reads it, with the effects of the forces besides a mode."""
    if force_patterns is None:
        return shifted_flow(model, 0.0)
    applied = AppliedForces.of(model.reduced, force_patterns)
    flow = shifted_flow(model, applied.shift)
    _store(flow.cross_response, applied.cross_response)
    _store(flow.other_modes, applied.other_modes)
    return flow


def shifted_flow(model: Model, shift: Complexes | float) -> kernel.Structure:
    """Return the slow flow with effective amplitudes a_j + shift_j F_j exp(i phase_j)."""
    reduced = model.reduced
    paper = int(reduced.formulation == "paper")
    flow = kernel.SlowFlow(paper=paper, table=model.table.kernel(), ratio=reduced.ratio)
    _store(flow.natural, reduced.frequency)
    _store(flow.carrier, reduced.carrier)
    if reduced.spin is not None:
        _store(flow.spin, np.ascontiguousarray(reduced.spin[:, 0]))
    _store(flow.damping, reduced.modal_damping)
    _store(flow.coupling_ratio, reduced.coupling_coefficients)
    _store(flow.hardening, hardening(reduced))
    _store(flow.off_resonance, np.full(model.modes, shift, dtype=complex))
    for k, term in enumerate(model.combinations):
        flow.combination[k] = kernel.Combination(term.mode, term.n, term.m)
    return flow


def _store(field: Any, values: Complexes | Floats) -> None:
    """Store values (modes, ...) in a field of the core, which has a row for each possible mode."""
    rows = np.frombuffer(field, dtype=values.dtype).reshape(kernel.MODES, -1)
    given = values.reshape(len(values), -1)
    rows[: given.shape[0], : given.shape[1]] = given


def inputs_of(
    force: Complexes,
    frequency: Floats,
    force_rate: ArrayLike = 0.0,
    frequency_rate: ArrayLike = 0.0,
    angle: ArrayLike = 0.0,
) -> NDArray[np.void]:
    """Return the inputs of the core, one for each row of arrays (points, modes).

    `force` is F_j exp(i phase_j), modal [N kg^-1/2], with its rate; `frequency` Omega_j [rad/s],
    with its rate; `angle` theta_j [rad] of the carriers, on which combination resonances depend.
    """
    modes = force.shape[1]
    inputs = kernel.inputs(len(force))
    moving = np.zeros_like(force) + np.asarray(force_rate)
    size = np.abs(force)
    phase = np.angle(np.where(size > 0.0, force, moving))  # from rest, that in which it grows
    rotated = moving * np.exp(-1j * phase)
    given = {
        "force": size,
        "force_rate": rotated.real,
        "phase": phase,
        "phase_rate": np.divide(rotated.imag, size, out=np.zeros_like(size), where=size > 0.0),
        "frequency": frequency,
        "frequency_rate": frequency_rate,
        "angle": angle,
    }
    for name, values in given.items():
        inputs[name][:, :modes] = values
    return inputs


def rates(
    flow: kernel.Structure,
    inputs: NDArray[np.void],
    amplitude: Complexes,
    *,
    may_leave: bool = False,
) -> Complexes:
    """Return da/dt (points, modes) at amplitudes (points, modes), with all terms of the slow flow.

    Amplitudes outside the friction table are refused; if they `may_leave` it, da/dt is NaN there.
    """
    a = np.ascontiguousarray(amplitude, dtype=complex)
    rate = np.empty_like(a)
    status = kernel.lib.sm_slow_flow_rates(flow, len(a), inputs, a, rate)
    if not (may_leave and status == kernel.OUTSIDE_TABLE):
        kernel.check(status, "amplitude: slow flow")
    return rate


@frozen
class Balance:
    """The amplitude equations of steady motion, at points; NaN outside the friction table.

    Without a'', and without the combination resonances, whose mean over time is zero.
    """

    mass: Complexes  # (points, modes), factor of da_j/dt [rad/s]
    stiffness: Complexes  # (points, modes), factor of a_j [rad^2/s^2]
    friction: Complexes  # (points, modes), Q_j a_j [N kg^-1/2], tending to 0 with a_j
    rate: Complexes  # (points, modes), da_j/dt [kg^1/2 m/s]


@frozen
class ForcedFlow:
    """The slow flow at points with a frequency and a constant force each."""

    model: Model
    # (modes,), shift of the amplitudes at the contacts per force, see `AppliedForces.shift`
    shift: Complexes
    flow: kernel.Structure
    inputs: NDArray[np.void]  # (points,)

    @classmethod
    def of(
        cls,
        model: Model,
        frequency: Floats,
        force: Complexes | float = 0.0,
        shift: Complexes | float = 0.0,
    ) -> Self:
        """Return the flow at frequencies [rad/s] and modal forces [N kg^-1/2] (points, modes)."""
        shifts = np.full(model.modes, shift, dtype=complex)
        forces = np.broadcast_to(force, frequency.shape).astype(complex)
        return cls(model, shifts, shifted_flow(model, shifts), inputs_of(forces, frequency))

    def with_inputs(self, inputs: NDArray[np.void]) -> Self:
        """Return the flow at points with other inputs."""
        return replace(self, inputs=inputs)

    def with_frequency(self, frequency: Floats) -> Self:
        """Return the flow with the same forces at other frequencies (points, modes) [rad/s]."""
        return self.with_inputs(inputs_of(self.force, frequency))

    @property
    def frequency(self) -> Floats:
        """Omega_j (points, modes) [rad/s]."""
        return np.asarray(self.inputs["frequency"][:, : self.model.modes])

    @property
    def force(self) -> Complexes:
        """F_j exp(i phase_j), modal, (points, modes) [N kg^-1/2]."""
        return phasor(self.inputs["force"], self.inputs["phase"])[:, : self.model.modes]

    def balance(self, amplitude: Complexes) -> Balance:
        """Return the terms of the amplitude equations at amplitudes (points, modes)."""
        return Balance(*np.moveaxis(self._balance(amplitude, None), 1, 0))

    def rate_and_jacobian(self, amplitude: Complexes) -> tuple[Floats, Floats]:
        """Return da/dt of `balance` as reals (points, 2 modes), and the Jacobian."""
        unknowns = 2 * amplitude.shape[1]
        jacobian = np.empty((len(amplitude), unknowns, unknowns))
        parts = self._balance(amplitude, jacobian)
        return np.ascontiguousarray(parts[:, 3]).view(float), jacobian

    def _balance(self, amplitude: Complexes, jacobian: Floats | None) -> Complexes:
        """Return the terms (points, 4, modes); the core writes the Jacobian, if there is one."""
        a = np.ascontiguousarray(amplitude, dtype=complex)
        parts = np.empty((len(a), 4, a.shape[1]), dtype=complex)
        arrays = (self.inputs, a, parts, jacobian)
        status = kernel.lib.sm_slow_flow_balance(self.flow, len(a), *arrays)
        if status != kernel.OUTSIDE_TABLE:
            kernel.check(status, "amplitude: slow flow")
        return parts

    def effective(self, amplitude: Complexes) -> Complexes:
        """Return the amplitudes at which the friction table is looked up, (points, modes).

        They include the direct action of the forces on the contacts, and the change of the
        coupling with the forcing frequency.
        """
        factor = coupling_factor(self.model.reduced, self.frequency)
        return np.asarray(factor * (amplitude + self.shift * self.force))
