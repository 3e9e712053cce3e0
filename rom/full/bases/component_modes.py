"""Full order on component modes, as Craig and Bampton take them: for structures of any size.

The modes of the structure with its contacts held, by bonds (fixed interface) or by the springs
that they are while they stick, up to a frequency; and what contacts and forces do statically. Of
modes above that, only their part of the static shapes S = K_h^-1 B of the loads B is left. With P
that part, and omega the first frequency left out, the receptance B^T (K_h - nu^2 M)^-1 B is wrong
by at most

    nu^4 sum_k>n (phi_k^T B)^2 / (omega_k^4 (omega_k^2 - nu^2)) <= nu^4 P^T M P / (omega^2 - nu^2),

P^T M P = sum_k>n (phi_k^T B)^2 / omega_k^4, for static shapes have what is of order 0 and 2 in nu.
Of bonded contacts S is their constraint modes, and the dynamic stiffness is wrong by as much.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.bases.projection import Projection
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.force_response import Forces
from slipmode.rom.reduction.reduced import force_vector
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.held import Held, bonded, stuck
from slipmode.rom.structure.matrices import Matrix, as_dense
from slipmode.rom.structure.solvers.mobility import mobility
from slipmode.rom.structure.structure import Structure

_FIRST = 8  # modes, and a first guess of how far above `highest` they have to reach
_REACH = 1.5
_MOST = 256


@dataclass(frozen=True, eq=False)
class ComponentModes:
    """A structure on its component modes.

    Attributes
    ----------
    projection : Projection
        Its `structure`, `basis`, `to_coordinates`; `excitation` and `state` bring forces and
        states onto the coordinates.
    frequency : (modes,) ndarray
        Of the modes with held contacts [rad/s].
    receptance_error : float
        Bound of what truncation does to the linear receptances at contacts and forces, up to the
        highest frequency asked for, relative to their static value: of the undamped structure,
        contacts held. Of bonded contacts it is their dynamic stiffness, relative to its parts by
        stiffness and inertia. inf if the modes end below that frequency.
    """

    projection: Projection
    frequency: Floats
    receptance_error: float

    __repr__ = short_repr

    @property
    def structure(self) -> Structure:
        """M = I, K, C, W of the coordinates."""
        return self.projection.structure


def component_modes(
    structure: Structure,
    law: Friction | Elastic,
    forces: Forces | Floats,
    highest: float,
    *,
    modes: int | None = None,
    tolerance: float = 1e-3,
) -> ComponentModes:
    """Component modes for full-order integration of a large structure.

    Parameters
    ----------
    structure : Structure
        Dense or sparse; it is factorised once, with the contacts held as a reduction for the same
        law holds them, so that one that was made is used.
    law : Tanh or Coulomb, or an elastic law
        Rigid friction: contacts are bonded. Elastic: held by the law's stuck springs.
    forces : sequence of {DOF: amplitude} or (n,) array_like
        Where forces act; their scale does not matter. `Excitation.patterns` are such.
    highest : float
        Frequency up to which receptances are to be right [rad/s]: that of the highest harmonic
        of the forcing that counts, the seventh of the fastest say.
    modes : int, optional
        How many. Default: as few as keep the bound of the receptance error below the tolerance, at
        least 1 and at most 256.
    tolerance : float, default 1e-3
        Of that bound. Signals change far less where high harmonics are weak: compare with those
        of half as many modes.

    Raises
    ------
    SlipmodeError
        If an argument does not fit.

    References
    ----------
    R. R. Craig, M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
    (1968).

    Examples
    --------
    >>> from slipmode import rom
    >>> from slipmode.rom import full
    >>> structure, law = rom.two_mass(), rom.Tanh(limit=2.0, alpha=0.02)
    >>> excitation = full.Excitation.harmonic(structure, ({0: 0.15},), (0.98,))
    >>> small = full.component_modes(structure, law, excitation.patterns, 7 * 0.98)
    >>> motion = full.integrate(
    ...     small.structure, law, small.projection.excitation(excitation), 10.0,
    ...     outputs=small.projection.basis,
    ... )
    """
    if not (np.isfinite(highest) and highest > 0):
        raise SlipmodeError(f"highest: must be a finite frequency > 0 [rad/s], got {highest}")
    if not 0 < tolerance < 1:
        raise SlipmodeError(f"tolerance: must be between 0 and 1, got {tolerance}")
    f = np.array([force_vector(each, structure.n_dofs, "forces") for each in forces]).T
    if f.ndim != 2:
        raise SlipmodeError("forces: must be at least one")
    held, static, follows, size = _held(structure, law, f, highest)
    if modes is not None and not 1 <= modes <= held.size:
        raise SlipmodeError(f"modes: must be 1 to {held.size}, got {modes}")
    heavy = as_dense(structure.mass @ static)
    omega, shapes, error = _chosen(held, heavy, follows, size, highest, modes, tolerance)
    return ComponentModes(Projection.on(structure, shapes, static), omega, error)


def _held(
    structure: Structure, law: Friction | Elastic, f: Floats, highest: float
) -> tuple[Held, Floats, Floats, Floats]:
    """The structure with held contacts, its static shapes S (n, loads), and two sizes (loads,).

    The inertia of its shape that modes have, S^T M S but for what stays at bonded contacts; and
    what errors are relative to, the static receptance S^T K_h S, or the stiffness of a bonded
    contact's shape with its inertia at the highest frequency.
    """
    K, M = structure.stiffness, structure.mass
    if isinstance(law, Elastic):
        reference = law.elements(structure.n_contacts).reference
        held = stuck(structure, reference)
        static = held.solve(np.hstack((as_dense(structure.directions), f)))
        springs = reference[:, np.newaxis] * as_dense(structure.directions.T @ static) ** 2
        return held, static, _quadratic(static, M), _quadratic(static, K) + springs.sum(axis=0)
    held = bonded(structure)
    R = as_dense(structure.partition().R)
    static = held.solve(np.hstack((-as_dense(K @ R), f)))
    contacts = slice(R.shape[1])
    static[:, contacts] += R
    follows, size = _quadratic(static, M), _quadratic(static, K)
    size[contacts] += highest**2 * follows[contacts]
    follows[contacts] -= np.diag(np.linalg.inv(mobility(M, structure.directions)))
    return held, static, follows, size


def _quadratic(shapes: Floats, matrix: Matrix) -> Floats:
    """s^T matrix s of each shape, (shapes,)."""
    return np.asarray(np.einsum("nk,nk->k", shapes, as_dense(matrix @ shapes)))


def _chosen(
    held: Held,
    heavy: Floats,
    follows: Floats,
    size: Floats,
    highest: float,
    modes: int | None,
    tolerance: float,
) -> tuple[Floats, Floats, float]:
    """Frequencies, modes, and the bound of the error."""
    most = min(_MOST, held.size) if modes is None else modes
    count = min(_FIRST, most) if modes is None else modes
    while True:
        omega, shapes = held.modes(count + 1, _REACH * highest if modes is None else 0.0, most + 1)
        errors = _errors(omega, shapes.T @ heavy, follows, size, highest)
        if omega.size == held.size:
            errors[-1] = 0.0
        good = 1 + np.flatnonzero(errors[1 : most + 1] <= tolerance)
        if modes is not None or good.size or omega.size > most or omega.size == held.size:
            found = int(good[0]) if modes is None and good.size else min(most, omega.size)
            return omega[:found], shapes[:, :found], float(errors[found])
        count = min(2 * omega.size, most)


def _errors(omega: Floats, part: Floats, follows: Floats, size: Floats, highest: float) -> Floats:
    """The bound with 0, 1, ... modes, (modes + 1,); `part` is phi^T M S (modes, loads).

    The last one takes the next frequency for no higher than the last.
    """
    left = follows - np.vstack((np.zeros_like(follows), np.cumsum(part**2, axis=0)))
    share = np.divide(left, size, out=np.zeros_like(left), where=size > 0).max(axis=1)
    above = np.append(omega, omega[-1]) ** 2 - highest**2
    errors = np.full(share.size, np.inf)
    reached = above > 0
    errors[reached] = np.maximum(share[reached], 0.0) * highest**4 / above[reached]
    return errors
