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
    displacements have the phases of those of the modes of a model, see `TravellingWave.tabulate`.
    """
    shapes, coordinates, by_force = [], [], []
    for j, carrier in enumerate(carriers):
        y, own = deficits[..., j, :], carrier.wave.own
        _, size, patterns = np.linalg.svd(y.reshape(-1, y.shape[-1]), full_matrices=False)
        patterns = patterns[size > _NEGLIGIBLE * size[0]]
        forces = np.vstack(((patterns @ own.contacts.conj()), carrier.force))
        moved = own.response(forces.T, carrier.frequency, carrier.wave.mode).T
        moved[-1] *= 0.5 / (carrier.modal_force or 1.0)
        shape, retained = carrier.mode.shape, carrier.mode_shape
        size_of = np.abs(retained)
        turn = np.divide(retained.conj(), size_of, out=np.ones_like(retained), where=size_of > 0.0)
        # shapes are real: a complex one times p is its real part times p and imaginary times i p
        moved = np.vstack((moved * turn, shape * turn - size_of))
        shapes += [moved.real, moved.imag]
        a = np.meshgrid(*axes, indexing="ij")[j][..., np.newaxis]
        p = np.concatenate((y @ patterns.conj().T, 0.0 * a, a), axis=-1)
        f = np.zeros(len(moved), dtype=complex)
        f[-2] = 1.0
        coordinates.append(np.concatenate((p, 1j * p), axis=-1))
        by_force.append(np.concatenate((f, 1j * f)))
    ends = np.cumsum([0, *(each.shape[-1] for each in coordinates)])
    nodes, modes = deficits.shape[:-2], len(carriers)
    P = np.zeros((*nodes, modes, ends[-1]), dtype=complex)
    of_forces = np.zeros((modes, ends[-1]), dtype=complex)
    for j in range(modes):
        P[..., j, ends[j] : ends[j + 1]] = coordinates[j]
        of_forces[j, ends[j] : ends[j + 1]] = by_force[j]
    harmonics = Harmonics(axes, CARRIERS[:modes], P, np.zeros((*nodes, ends[-1])))
    return DofResponse(np.vstack(shapes), harmonics, of_forces)
