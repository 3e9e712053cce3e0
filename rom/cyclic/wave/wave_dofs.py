"""Displacement of the DOFs of a sector in a wave, besides its mode."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.cyclic.wave.wave_problem import Carrier
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.table.dof_response import DofResponse

# Largest part of the force deficits that is left out, relative to the largest of them. The
# response to them is about 1 % of a displacement.
_NEGLIGIBLE = 1e-4


def wave_dof_response(
    carriers: Sequence[Carrier], axes: tuple[Floats, ...], deficits: Complexes
) -> DofResponse:
    """Return the response of the other modes of each wave's nodal diameter.

    `deficits` (n_a, [n_b,] modes, N_c) are y_j of the contacts at |a| of the axes [N]. The
    phases of the displacements refer to the modes of a model, see `TravellingWave.tabulate`.
    """
    amplitudes = np.meshgrid(*axes, indexing="ij")
    of_waves = [
        _of_wave(carrier, amplitudes[j], deficits[..., j, :]) for j, carrier in enumerate(carriers)
    ]
    shapes, coordinates, by_force = zip(*of_waves, strict=True)
    P = _side_by_side(coordinates)
    nothing = np.zeros((*P.shape[:-2], P.shape[-1]))
    harmonics = Harmonics(axes, CARRIERS[: len(carriers)], P, nothing)
    return DofResponse(np.vstack(shapes), harmonics, _side_by_side(by_force))


def _of_wave(carrier: Carrier, a: Floats, y: Complexes) -> tuple[Floats, Complexes, Complexes]:
    """Return shapes (q, n_s), coordinates at the nodes (..., q) and by force (q,) of one wave."""
    own, on_mode, moving = carrier.wave.own, carrier.mode_shape, carrier.mode.shape
    _, size, patterns = np.linalg.svd(y.reshape(-1, y.shape[-1]), full_matrices=False)
    patterns = patterns[size > _NEGLIGIBLE * size[0]]
    forces = np.vstack((patterns @ own.contacts.conj(), carrier.force))
    moved = own.response(forces.T, carrier.frequency, carrier.wave.mode).T
    moved[-1] *= 0.5 / (carrier.modal_force or 1.0)
    size = np.abs(on_mode)
    turn = np.divide(on_mode.conj(), size, out=np.ones_like(on_mode), where=size > 0.0)
    shapes = np.vstack((moved * turn, moving * turn - size))
    p = np.concatenate((y @ patterns.conj().T, np.stack((0.0 * a, a), axis=-1)), axis=-1)
    f = np.zeros(len(shapes), dtype=complex)
    f[-2] = 1.0
    # shapes are real: the real part of a complex one has the coordinate p, the imaginary part i p
    both = np.vstack((shapes.real, shapes.imag))
    return both, np.concatenate((p, 1j * p), axis=-1), np.concatenate((f, 1j * f))


def _side_by_side(parts: Sequence[Complexes]) -> Complexes:
    """Return coordinates of the waves (..., q_j) as rows of all coordinates, (..., modes, q)."""
    rows = [
        np.concatenate([part * (i == j) for i, part in enumerate(parts)], axis=-1)
        for j in range(len(parts))
    ]
    return np.stack(rows, axis=-2)
