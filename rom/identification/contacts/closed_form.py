"""Frequency and damping of a mode by the describing functions of its contacts.

The structure is reduced once, with reference springs k at its contacts. With the force deficit
y = (k - N(|x|)) x of the contacts, N from `describing_function`, the carrier harmonic of the
contact motion is

    x = -L a + G y,    G = R + reaction of all other modes,

see `rom.reduction.stuck`. Coupling between contacts is included, harmonics of the contact motion
are not. A sensor at DOF s moves by x_s = s_a a + s_y^T y. It gives a, so x depends on the measured
amplitude alone:

    x = -L x_s / s_a + (G + L s_y^T / s_a) y,
    Omega^2 (1 + 2 i zeta) = omega^2 + i gamma Omega + indirect damping + L^T y / a.

Matrices are those at the measured frequencies.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from slipmode.rom import Reduced, SlipmodeError
from slipmode.rom.common import Complexes, Floats, frozen
from slipmode.rom.identification.contacts.describing_function import describing_function
from slipmode.rom.identification.contacts.groups import SliderGroup

# Motion of the sensor with the mode that is rounding, relative to the largest of the mode.
_NODE = 1e-9
_MOST_STEPS, _CONVERGED = 50, 1e-11  # of Newton's method; rounding is 1e-14


@frozen
class ClosedForm:
    """A mode at measured points.

    Attributes
    ----------
    motion : (points,) ndarray
        Carrier x_s of the sensor, half its amplitude [m].
    frequency : (points,) ndarray
        Measured frequencies [rad/s].
    indirect : (points,) complex ndarray
        Stiffness that returns through dampers from the other modes [rad^2/s^2].
    coupling : (points, N_c) complex ndarray
        L.
    drive : (points, N_c) complex ndarray
        -L x_s / s_a.
    compliance : (points, N_c, N_c) complex ndarray
        G + L s_y^T / s_a.
    of_mode : (points,) complex ndarray
        s_a.
    of_deficit : (points, N_c) complex ndarray
        s_y.
    reference : (N_c,) ndarray
        k [N/m].
    natural : float
        Natural frequency with reference springs [rad/s].
    damping : float
        Damping ratio with reference springs.
    """

    motion: Floats
    frequency: Floats
    indirect: Complexes
    coupling: Complexes
    drive: Complexes
    compliance: Complexes
    of_mode: Complexes
    of_deficit: Complexes
    reference: Floats
    natural: float
    damping: float

    @classmethod
    def of(cls, reduced: Reduced, sensor: int, amplitude: Floats, frequency: Floats) -> Self:
        """Return the mode of a reduction at sensor amplitudes [m] and frequencies [rad/s]."""
        assert reduced.contacts is not None
        B = reduced.modal_coupling(frequency)  # (points, modes, N_c)
        D = reduced.modal_stiffness(frequency)
        by_dampers = np.where(np.arange(D.shape[-1]) > 0, -D[:, :, 0], 0.0)[..., np.newaxis]
        response = reduced.response(frequency, np.concatenate((by_dampers, B), axis=2), [True])
        to_mode, to_contacts = response[..., 0], response[..., 1:]
        L = B[:, 0] + np.einsum("pm,pmc->pc", to_mode, B)
        others = np.einsum("pmc,pmd->pcd", B, to_contacts)
        G = reduced.following(frequency) - reduced.stiffness + others
        shapes = reduced.all_shapes[sensor]
        of_mode = shapes[0] + to_mode @ shapes
        of_deficit = reduced.contact_shapes[sensor] - np.einsum("pmc,m->pc", to_contacts, shapes)
        if np.any(np.abs(of_mode) <= _NODE * np.abs(reduced.mode_shapes).max()):
            raise SlipmodeError(
                f"sensor = {sensor}: mode {reduced.modes[0]} does not move this DOF; give a DOF "
                "where its amplitude was measured"
            )
        motion = 0.5 * amplitude
        return cls(
            motion=motion,
            frequency=frequency,
            indirect=np.einsum("pm,pm->p", to_mode, D[:, 0]),
            coupling=L,
            drive=-L * (motion / of_mode)[:, np.newaxis],
            compliance=G
            + L[:, :, np.newaxis] * (of_deficit / of_mode[:, np.newaxis])[:, np.newaxis],
            of_mode=of_mode,
            of_deficit=of_deficit,
            reference=reduced.contacts.reference,
            natural=float(reduced.frequency[0]),
            damping=float(0.5 * reduced.modal_damping[0] / reduced.frequency[0]),
        )

    def rates(
        self, groups: list[SliderGroup], natural: Floats, damping: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return frequency [rad/s], damping ratio and |a| [kg^1/2 m], (laws, points) each.

        `natural` [rad/s] and `damping` [-] are the natural frequency and damping ratio of the mode
        with reference springs, (laws,). NaN where the motion of the contacts does not converge.
        """
        with np.errstate(all="ignore"):
            y = self._deficit(groups)
            a = (self.motion - np.einsum("pc,lpc->lp", self.of_deficit, y)) / self.of_mode
            omega, zeta = natural[:, np.newaxis], damping[:, np.newaxis]
            structural = omega**2 + 2j * zeta * omega * self.frequency
            square = structural + self.indirect + np.einsum("pc,lpc->lp", self.coupling, y) / a
            return np.sqrt(square.real), square.imag / (2.0 * square.real), np.abs(a)

    def _deficit(self, groups: list[SliderGroup]) -> Complexes:
        """Return the carriers of the force deficit y (laws, points, N_c) [N], by Newton."""
        eye = np.eye(self.reference.size)
        scale = np.abs(self.drive).max(axis=-1)
        x = np.broadcast_to(self.drive, (len(groups[0].limit), *self.drive.shape))
        move, least = np.zeros_like(x), np.full(x.shape[:-1], np.inf)
        for _ in range(_MOST_STEPS):
            tried = x - move
            y, by_real, by_imaginary = self._forces(groups, tried)
            residual = tried - self.drive - np.einsum("pcd,lpd->lpc", self.compliance, y)
            error = np.abs(residual).max(axis=-1) / scale
            better = error < least
            x, least = np.where(better[..., np.newaxis], tried, x), np.where(better, error, least)
            if np.all(least <= _CONVERGED):
                break
            J = np.concatenate(
                (
                    eye - self.compliance * by_real[..., np.newaxis, :],
                    1j * eye - self.compliance * by_imaginary[..., np.newaxis, :],
                ),
                axis=-1,
            )
            right = np.concatenate((residual.real, residual.imag), axis=-1)[..., np.newaxis]
            step = np.linalg.solve(np.concatenate((J.real, J.imag), axis=-2), right)[..., 0]
            real, imaginary = np.split(step, 2, axis=-1)
            newton = real + 1j * imaginary
            move = np.where(better[..., np.newaxis], newton, 0.5 * move)
        y = self._forces(groups, x)[0]
        return np.where((least <= _CONVERGED)[..., np.newaxis], y, np.nan)

    def _forces(self, groups: list[SliderGroup], x: Complexes) -> tuple[Complexes, ...]:
        """Return y and its derivatives by the real and the imaginary part of x, (..., N_c)."""
        size = np.maximum(np.abs(x), np.finfo(float).tiny)
        N, slope = np.zeros_like(x), np.zeros_like(x)
        for group in groups:
            limit, stiffness = (
                v[:, np.newaxis, np.newaxis] for v in (group.limit, group.stiffness)
            )
            at = list(group.columns)
            N[..., at], slope[..., at] = describing_function(limit, stiffness, 2.0 * size[..., at])
        lost = self.reference - N
        along = -slope * x / size**2  # dy / d|x| / |x|
        return lost * x, lost + along * x.real, 1j * lost + along * x.imag
