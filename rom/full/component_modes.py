"""Full order on component modes, after Craig and Bampton, for structures of any size.

The basis has the modes of the structure with its contacts held, by bonds (fixed interface) or by
the springs of stuck contacts, up to a frequency; and the static shapes S = K_h^-1 B of the loads B
on contacts and forces. Modes above that frequency are represented by their part P of the static
shapes alone. With omega the first frequency that is left out, the error of the receptance B^T (K_h
- nu^2 M)^-1 B is at most

    nu^4 sum_k>n (phi_k^T B)^2 / (omega_k^4 (omega_k^2 - nu^2)) <= nu^4 P^T M P / (omega^2 - nu^2),

P^T M P = sum_k>n (phi_k^T B)^2 / omega_k^4, because static shapes include the orders 0 and 2 in
nu. For bonded contacts S are constraint modes, and this bounds the error of the dynamic stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.full.structures import Projection
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.force_response import Forces
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.force_vector import force_vector
from slipmode.rom.structure.held import Held, bonded, stuck
from slipmode.rom.structure.matrices import Matrix, as_dense
from slipmode.rom.structure.solvers.mass import contact_mass
from slipmode.rom.structure.structure import Structure


@frozen
class ComponentModes:
    """Hold a structure in the coordinates of its component modes.

    Attributes
    ----------
    projection : Projection
        Structure and basis of the coordinates. Its methods `excitation` and `state` convert forces
        and states to the coordinates.
    frequency : (modes,) ndarray
        Natural frequencies with held contacts [rad/s].
    receptance_error : float
        Bound of the truncation error of the undamped linear receptances at contacts and forces, up
        to the frequency `highest`, relative to their static value [-]. For bonded contacts it
        bounds the error of their dynamic stiffness, relative to its parts due to stiffness and
        inertia. Infinite if the modes end below that frequency.
    """

    projection: Projection
    frequency: Floats
    receptance_error: float

    @property
    def structure(self) -> Structure:
        """Structure in these coordinates, with a unit mass matrix."""
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
    """Return component modes for full-order integration of a large structure.

    Parameters
    ----------
    structure : Structure
        Dense or sparse structure. Its stiffness with held contacts is factorised once; a
        factorisation by `rom.reduce` with this law is used again.
    law : Tanh, Coulomb, or an elastic law
        Contacts are bonded for rigid laws, and held by the springs of stuck contacts for elastic
        laws.
    forces : sequence of {DOF: amplitude} or (n,) array_like
        Distribution of the forces, in any scale, for instance `Excitation.patterns`.
    highest : float
        Frequency [rad/s] up to which receptances are accurate: the highest relevant harmonic of
        the forcing, for instance the seventh harmonic of the fastest force.
    modes : int, optional
        Number of modes. Default: the smallest number that meets the tolerance, 1 to 256.
    tolerance : float, default 1e-3
        Bound of the relative receptance error [-], between 0 and 1. Signals have a far smaller
        error if high harmonics are weak. Compare with half as many modes.

    Returns
    -------
    ComponentModes
        Structure in the coordinates of the modes, and the error bound that is reached.

    Raises
    ------
    SlipmodeError
        If `highest`, `tolerance` or `modes` is outside its range, or there is no force.

    References
    ----------
    Craig, R. R., M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
    (1968).

    Examples
    --------
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
    loaded = _loaded(structure, law, f, highest)
    size = loaded.held.size
    if modes is not None and not 1 <= modes <= size:
        raise SlipmodeError(f"modes: must be 1 to {size}, got {modes}")
    inertia = as_dense(structure.mass @ loaded.static)
    # eight modes, doubled until they are enough
    most = min(256, size) if modes is None else modes
    count = min(8, most) if modes is None else modes
    while True:
        omega, shapes = loaded.held.modes(count + 1)
        errors = loaded.errors(omega, shapes.T @ inertia, highest)
        if omega.size == size:
            errors[-1] = 0.0
        good = 1 + np.flatnonzero(errors[1 : most + 1] <= tolerance)
        if modes is not None or good.size or omega.size > most or omega.size == size:
            break
        count = min(2 * count, most)
    found = int(good[0]) if modes is None and good.size else min(most, omega.size)
    projection = Projection.on(
        structure, shapes[:, :found], loaded.static, max(highest, float(omega[found - 1]))
    )
    return ComponentModes(projection, omega[:found], float(errors[found]))


@dataclass(frozen=True)
class _Loaded:
    """A structure with held contacts, and its static response to loads."""

    held: Held
    static: Floats  # (n, loads), static shapes S
    # S^T M S that modes represent, (loads,): without the mass that stays at bonded contacts.
    inertia: Floats
    # Reference of the errors, (loads,): the static receptance S^T K_h S; for a bonded contact the
    # stiffness of its shape with its inertia at the highest frequency.
    scale: Floats

    def errors(self, omega: Floats, part: Floats, highest: float) -> Floats:
        """Return the error bound with 0, 1, ... modes, (modes + 1,); `part` is phi^T M S.

        The last bound takes the last frequency for the first that is left out.
        """
        represented = np.vstack((np.zeros_like(self.inertia), np.cumsum(part**2, axis=0)))
        rest = self.inertia - represented
        share = np.divide(rest, self.scale, out=np.zeros_like(rest), where=self.scale > 0)
        above = np.append(omega, omega[-1]) ** 2 - highest**2
        errors = np.full(above.size, np.inf)
        reached = above > 0
        largest = np.maximum(share.max(axis=1)[reached], 0.0)
        errors[reached] = largest * highest**4 / above[reached]
        return errors


def _loaded(structure: Structure, law: Friction | Elastic, f: Floats, highest: float) -> _Loaded:
    """Hold the contacts as `rom.reduce` does, and load them and the forces f (n, forces)."""
    K, M = structure.stiffness, structure.mass
    if isinstance(law, Elastic):
        reference = law.elements(structure.n_contacts).reference
        held = stuck(structure, reference)
        static = held.solve(np.hstack((as_dense(structure.directions), f)))
        springs = reference[:, np.newaxis] * as_dense(structure.directions.T @ static) ** 2
        receptance = _quadratic(static, K) + springs.sum(axis=0)
        return _Loaded(held, static, _quadratic(static, M), receptance)
    held = bonded(structure)
    R = as_dense(structure.partition().R)
    static = held.solve(np.hstack((-as_dense(K @ R), f)))
    contacts = slice(R.shape[1])
    static[:, contacts] += R
    inertia, scale = _quadratic(static, M), _quadratic(static, K)
    scale[contacts] += highest**2 * inertia[contacts]
    inertia[contacts] -= np.diag(contact_mass(M, structure.massless, structure.directions))
    return _Loaded(held, static, inertia, scale)


def _quadratic(shapes: Floats, matrix: Matrix) -> Floats:
    """Return s^T matrix s of each shape, (shapes,)."""
    return np.asarray(np.einsum("nk,nk->k", shapes, as_dense(matrix @ shapes)))
