"""Models of one travelling wave, or of two at two frequencies: friction table, DOFs, cache."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import ArrayLike

from slipmode.rom import Model, NoContacts, Reduced, SlipmodeError
from slipmode.rom.common import Complexes, Floats, warn
from slipmode.rom.contact import Harmonics
from slipmode.rom.cyclic.wave.wave_problem import (
    Carrier,
    WaveProblem,
    naming_resonance,
    resonance_findings,
)
from slipmode.rom.reduction import CARRIERS, modes_alone
from slipmode.rom.table import DofResponse, model_from_cache, tabulate_problem

if TYPE_CHECKING:
    from slipmode.rom.cyclic.wave.travelling_wave import TravellingWave

# Largest part of the force deficits that is left out, relative to the largest of them. The
# response to them is about 1 % of a displacement.
_NEGLIGIBLE = 1e-4


def tabulate_waves(
    waves: Sequence[TravellingWave],
    amplitude: Sequence[float],
    force: Sequence[Mapping[int, complex] | ArrayLike | None],
    tolerance: float = 1e-3,
    frequency: Sequence[float | None] = (None, None),
) -> Model:
    """Return the model of two travelling waves of one structure at two frequencies.

    Two engine orders excite them, each near the frequency of its wave. Alternatively one wave is
    self-excited and the other is forced. `rom.limit_cycles` finds the limit cycles of such a
    model, with the force {} of the self-excited wave.

    Parameters
    ----------
    waves : sequence of TravellingWave
        Two waves with one structure and law, and with different frequencies.
    amplitude : sequence of float
        Largest amplitude |a_j| of each wave [kg^1/2 m].
    force : sequence of {DOF: amplitude} or (n_s,) array_like
        Force pattern of each wave, in any scale, see `TravellingWave.modal_force`. None for a wave
        without force.
    tolerance : float, default 0.001
        Relative error of the amplitude equation [-], as in `rom.tabulate`.
    frequency : sequence of float or None, default (None, None)
        Reference frequency of each wave [rad/s], see `TravellingWave.tabulate`.

    Returns
    -------
    Model
        Model of two modes, see `TravellingWave.tabulate`.

    Raises
    ------
    SlipmodeError
        If the waves have different structures or laws, or the tolerance cannot be reached.

    Notes
    -----
    The stability of steady states and limit cycles includes the two amplitudes only. The stability
    against waves of other nodal diameters is not computed; `WaveState.stable` computes it for one
    wave.
    """
    counts = [len(each) for each in (waves, force, frequency)]
    if counts != [2, 2, 2]:
        raise SlipmodeError(f"waves, force, frequency: must have two entries each, got {counts}")
    first, second = waves
    if first.structure is not second.structure or first.law != second.law:
        raise SlipmodeError("waves: must be of the same structure and law")
    carriers = [
        wave.carrier(f, omega) for wave, f, omega in zip(waves, force, frequency, strict=True)
    ]
    if carriers[0].frequency == carriers[1].frequency:
        raise SlipmodeError("waves: must have different frequencies")
    return wave_model(carriers, amplitude, tolerance)


def cached_waves(
    carriers: Sequence[Carrier], amplitude: Sequence[float], tolerance: float
) -> tuple[Model, bool]:
    """Return the model of waves up to |a| (modes,), and whether the cache had it already."""
    first = carriers[0].wave
    disk = first.structure
    waves = [[each.wave.nodal_diameter, each.wave.mode, each.frequency] for each in carriers]
    named = ["waves", disk.sectors, *amplitude, tolerance, *waves]
    matrices = (disk.mass, disk.stiffness, disk.damping, disk.own_directions, disk.next_directions)
    arrays: list[np.ndarray] = [disk.left, disk.right, *(each.force for each in carriers)]
    arrays += [part for each in matrices for part in scipy.sparse.find(each)]
    by_name = {str(k): each for k, each in enumerate(arrays)}
    return model_from_cache(
        first.law, named, by_name, lambda: wave_model(carriers, amplitude, tolerance)
    )


def reduced_waves(carriers: Sequence[Carrier]) -> Reduced:
    """Return one or two waves as modes without contacts, with the sizes of their shapes."""
    carrier = np.array([each.frequency for each in carriers])
    D = np.array([each.mode.stiffness for each in carriers])
    # D = omega^2 - Omega^2 + i gamma Omega
    omega, damping = np.sqrt(D.real + carrier**2), D.imag / carrier
    waves = [each.wave for each in carriers]
    alone, structural = np.array(
        [[w.own.frequency[w.mode], w.own.structural_damping[w.mode]] for w in waves]
    ).T
    return modes_alone(
        omega,
        damping,
        np.abs([each.mode_shape for each in carriers]).T,
        NoContacts().elements(0),
        carrier=carrier,
        aerodynamics=omega**2 - alone**2 + 1j * alone * (damping - structural),
    )


def wave_model(carriers: Sequence[Carrier], amplitude: Sequence[float], tolerance: float) -> Model:
    """Return the model of one or two waves up to amplitudes (modes,) [kg^1/2 m].

    Its DOFs are the free DOFs of a sector, with the sizes of the modes as mode shapes.
    """
    problem = WaveProblem.of_waves(carriers)
    warn(resonance_findings(problem))
    with naming_resonance(problem):
        # Phases between the contacts of a sector are left out: they matter in second order.
        found = tabulate_problem(problem, amplitude, tolerance)
    axes, modes = found.table.axes, len(carriers)
    nothing = np.zeros((*(axis.size for axis in axes), modes, 0))
    unknown = Harmonics(axes, CARRIERS[:modes], nothing.astype(complex), nothing[..., 0, :])
    response = _dof_response(carriers, axes, found.carriers)
    reduced = reduced_waves(carriers)
    return Model(reduced, NoContacts(), found.table, unknown, (), found.accuracy, response)


def _dof_response(
    carriers: Sequence[Carrier], axes: tuple[Floats, ...], deficits: Complexes
) -> DofResponse:
    """Return the response of the other modes of each wave's nodal diameter.

    `deficits` (n_a, [n_b,] modes, N_c) are y_j of the contacts at |a| of the axes [N]. The
    phases of the displacements refer to the modes of a model, see `TravellingWave.tabulate`.
    """
    amplitudes = np.meshgrid(*axes, indexing="ij")
    shapes, coordinates, by_force = [], [], []
    for j, own in enumerate(np.eye(len(carriers))[..., np.newaxis]):
        moved, p, f = _of_wave(carriers[j], amplitudes[j], deficits[..., j, :])
        shapes.append(moved)
        coordinates.append(own * p[..., np.newaxis, :])
        by_force.append(own * f)
    P = np.concatenate(coordinates, axis=-1)
    nothing = np.zeros((*P.shape[:-2], P.shape[-1]))
    harmonics = Harmonics(axes, CARRIERS[: len(carriers)], P, nothing)
    return DofResponse(np.vstack(shapes), harmonics, np.concatenate(by_force, axis=-1))


def _of_wave(carrier: Carrier, a: Floats, y: Complexes) -> tuple[Floats, Complexes, Complexes]:
    """Return shapes (q, n_s), coordinates at the nodes (..., q) and by force (q,) of one wave."""
    own, on_mode, moving = carrier.wave.own, carrier.mode_shape, carrier.mode.shape
    _, size, patterns = np.linalg.svd(y.reshape(-1, y.shape[-1]), full_matrices=False)
    patterns = patterns[size > _NEGLIGIBLE * size[0]]
    forces = own.contacts.conj().T @ patterns.T
    by_contacts = own.response(forces, carrier.frequency, carrier.wave.mode).T
    moved = np.vstack((by_contacts, 0.5 * carrier.by_force))
    size = np.abs(on_mode)
    turn = np.divide(on_mode.conj(), size, out=np.ones_like(on_mode), where=size > 0.0)
    shapes = np.vstack((moved * turn, moving * turn - size))
    p = np.concatenate((y @ patterns.conj().T, np.stack((0.0 * a, a), axis=-1)), axis=-1)
    f = np.zeros(len(shapes), dtype=complex)
    f[-2] = 1.0
    # shapes are real: the real part of a complex one has the coordinate p, the imaginary part i p
    both = np.vstack((shapes.real, shapes.imag))
    return both, np.concatenate((p, 1j * p), axis=-1), np.concatenate((f, 1j * f))
