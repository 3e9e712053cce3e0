"""Models of one travelling wave, or of two at two frequencies: friction table, DOFs, cache."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Complexes, Floats, as_floats
from slipmode.rom.contact.detuning import MOST_DETUNING
from slipmode.rom.contact.error_norm import smallest_scale
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.contact.resolution import ResolutionSearch
from slipmode.rom.contact.time_budget import TimeBudget
from slipmode.rom.cyclic.wave.wave_problem import (
    Carrier,
    WaveProblem,
    naming_resonance,
    resonance_findings,
)
from slipmode.rom.error_budget import ErrorBudget
from slipmode.rom.errors import SlipmodeError, warn
from slipmode.rom.laws.law_record import record_of
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import CARRIERS
from slipmode.rom.reduction.modes_alone import modes_alone
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.storage.code_digest import code_digest
from slipmode.rom.table import disk_cache
from slipmode.rom.table.accuracy import Accuracy
from slipmode.rom.table.corrections import with_detuning, with_rate_correction
from slipmode.rom.table.dof_response import DofResponse
from slipmode.rom.table.model import FORMAT, Model, digest
from slipmode.rom.table.refinement.refine import refine
from slipmode.rom.table.refinement.sampling import Sampling
from slipmode.rom.table.tabulation import check_request

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
    name = f"{_key(carriers, [*amplitude, tolerance])}.rom"
    found = disk_cache.find(name, Model.load)
    if found is not None:
        return found, True
    model = wave_model(carriers, amplitude, tolerance)
    disk_cache.keep(name, model.save)
    return model, False


def _key(carriers: Sequence[Carrier], asked: Sequence[float]) -> str:
    """Return a hash of everything that the model depends on."""
    first = carriers[0].wave
    disk, code = first.structure, code_digest("slipmode.rom")
    waves = [[each.wave.nodal_diameter, each.wave.mode, each.frequency] for each in carriers]
    named = [FORMAT, code, "waves", disk.sectors, record_of(first.law), *asked, *waves]
    matrices = (disk.mass, disk.stiffness, disk.damping, disk.own_directions, disk.next_directions)
    arrays: list[np.ndarray] = [disk.left, disk.right, *(each.force for each in carriers)]
    arrays += [part for each in matrices for part in scipy.sparse.find(each)]
    return digest({"named": named}, {str(k): each for k, each in enumerate(arrays)})[:32]


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
    ends, modes = as_floats("amplitude", amplitude), len(carriers)
    check_request(ends, modes, tolerance, amplitude)
    problem = WaveProblem.of_waves(carriers)
    reduced, orders = problem.reduced, CARRIERS[:modes]
    warn(resonance_findings(problem))
    budget, forever, residuals = ErrorBudget(tolerance), TimeBudget(np.inf), [0.0]

    def sample(amplitudes: Floats, near: Complexes | None = None) -> Complexes:
        terms = torus.solve(amplitudes)
        terms.check_periodic()
        residuals.extend(terms.residual)
        at_carriers = terms.P[:, :modes].reshape(len(amplitudes), -1)
        return np.hstack((terms.S, np.zeros((len(amplitudes), 1)), at_carriers))

    with naming_resonance(problem):
        resolution = ResolutionSearch(problem, ends, budget, map, forever).choose()
        torus = problem.on(resolution.grid, resolution.march, smallest_scale(reduced, ends))
        sampling = Sampling(sample, problem, ends, budget.march, kept=True)
        table, deficits, error = refine(sampling, budget.interpolation, forever)
        # Phases between the contacts of a sector are left out: they matter in second order.
        table = with_rate_correction(table, torus, tolerance, map)
        detuning = None
        if modes == 1:
            table, detuning = with_detuning(table, torus, map, tolerance, MOST_DETUNING)
    nodes = tuple(axis.size for axis in table.axes)
    nothing = np.zeros((*nodes, modes, 0))
    unknown = Harmonics(table.axes, orders, nothing.astype(complex), nothing[..., 0, :])
    accuracy = Accuracy(
        tolerance,
        error,
        resolution.error,
        periodicity=float(max(residuals)),
        detuning=detuning,
        steps=resolution.grid.steps,
        lines=resolution.grid.lines,
        solved=len(residuals) - 1,
    )
    assert deficits is not None  # they are kept
    response = _dof_response(carriers, table.axes, deficits.reshape(*nodes, modes, -1))
    return Model(reduced_waves(carriers), NoContacts(), table, unknown, (), accuracy, response)


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
