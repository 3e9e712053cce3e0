"""Patches of contacts within which given motions hardly vary."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.pairing.pairs import ContactPairs


@frozen
class MotionPatches:
    """Hold patches of contacts and the deviations of given motions from them.

    Attributes
    ----------
    patch : (contacts,) ndarray of int
        Patch of each contact, the argument of `ContactPairs.gathered`.
    variation : (motions,) ndarray
        Largest deviation of the displacement of a contact from the mean of its patch, relative to
        the largest displacement of the motion [-]. It is at most the tolerance.
    error : (motions,) ndarray
        Root mean square deviation over the area, relative to the root mean square displacement of
        the motion [-]. Springs with equal stiffness in all directions store on the patches
        1 - error^2 times the energy that they store on the contacts.
    """

    patch: NDArray[np.intp]
    variation: Floats
    error: Floats


def motion_patches(pairs: ContactPairs, shapes: ArrayLike, tolerance: float) -> MotionPatches:
    """Return the patches of contacts that represent given motions within a tolerance.

    A patch is cut across the global axis for which the parts vary least. Cuts are repeated until
    no contact deviates from its patch by more than the tolerance. See "Patches of contacts" in
    docs/theory.md.

    Parameters
    ----------
    pairs : ContactPairs
        Contacts at nodes, from `contact_pairs`.
    shapes : (n,) or (n, motions) array_like
        Displacements of the DOFs in any scale: the modes to retain, with stuck contacts, and
        static displacements due to forces if they matter.
    tolerance : float
        Largest deviation of a contact from its patch, relative to the largest relative
        displacement of each motion [-], above 0 and at most 1.

    Returns
    -------
    MotionPatches
        Patch of each contact, and the deviations for each motion.

    Raises
    ------
    SlipmodeError
        If the tolerance is outside its range, `shapes` has a wrong shape, or a motion moves no
        contact.

    Notes
    -----
    Other motions are not represented within the tolerance: a patch may rotate relative to its
    target, so that one or two patches act like a hinge. A patch slips as a whole, while its
    contacts would slip one by one. Frequency errors decrease with the square of `error`. For the
    error of friction, compare with the result for a smaller tolerance.

    Examples
    --------
    Contacts at all nodes, then the patches for two modes of a reduction::

        fine = rom.contact_pairs(coordinates, dofs, lower, upper, tolerance=1e-4)
        structure = rom.Structure(M, K, contact=fine.W)
        stuck = rom.modes(structure, law).states["stuck"]
        found = rom.motion_patches(fine, stuck.shapes[:, [6, 7]], 0.2)
        pairs = fine.gathered(found.patch)
    """
    if not 0.0 < tolerance <= 1.0:
        raise SlipmodeError(f"tolerance: must be above 0, at most 1, got {tolerance}")
    motion = _relative(pairs, shapes)
    patch = np.zeros(len(pairs.area), dtype=np.intp)
    parts, count = [np.arange(len(patch))], 0
    deviation = np.empty((len(patch), motion.shape[2]))  # from the mean of the patch by area
    while parts:
        own = parts.pop()
        area = pairs.area[own]
        mean = np.tensordot(area / area.sum(), motion[own], axes=1)
        deviation[own] = np.linalg.norm(motion[own] - mean, axis=1)
        if deviation[own].max() <= tolerance:
            patch[own], count = count, count + 1
        else:
            parts += _bisected(own, motion, pairs)
    square = np.sum(motion**2, axis=1)
    error = np.sqrt(pairs.area @ deviation**2 / (pairs.area @ square))
    return MotionPatches(patch, deviation.max(axis=0), error)


def _relative(pairs: ContactPairs, shapes: ArrayLike) -> Floats:
    """Return relative displacements (contacts, 3, motions), the largest of each motion 1."""
    n = pairs.relative.shape[0]
    given = np.asarray(shapes, dtype=float)
    given = given[:, np.newaxis] if given.ndim == 1 else given
    if given.ndim != 2 or len(given) != n or not given.shape[1] or not np.isfinite(given).all():
        raise SlipmodeError(
            f"shapes: must be finite numbers of shape ({n}, motions), got shape {np.shape(shapes)}"
        )
    motion = np.asarray(pairs.relative.T @ given).reshape(len(pairs.area), 3, -1)
    largest = np.linalg.norm(motion, axis=1).max(axis=0)
    if not np.all(largest > 0.0):
        raise SlipmodeError(f"shapes: motion {np.argmin(largest)} moves no contact")
    return np.asarray(motion / largest)


def _bisected(
    own: NDArray[np.intp], motion: Floats, pairs: ContactPairs
) -> list[NDArray[np.intp]]:
    """Return the two parts with the least variation that a plane across a global axis makes."""
    # Nearer contacts are at one place
    extent = 1e-9 * np.ptp(pairs.position, axis=0).max()
    most, halves = -np.inf, [own[:1], own[1:]]  # contacts at one place: split off the first
    for axis in range(3):
        order = own[np.argsort(pairs.position[own, axis], kind="stable")]
        area = np.cumsum(pairs.area[order])
        moment = np.cumsum(pairs.area[order, np.newaxis] * motion[order].reshape(len(own), -1), 0)
        before, behind = area[:-1], area[-1] - area[:-1]
        # the cut reduces the variation by this
        between = np.sum(moment[:-1] ** 2, axis=1) / before
        between += np.sum((moment[-1] - moment[:-1]) ** 2, axis=1) / behind
        between[np.diff(pairs.position[order, axis]) <= extent] = -np.inf
        cut = int(np.argmax(between))
        if between[cut] > most:
            most, halves = float(between[cut]), [order[: cut + 1], order[cut + 1 :]]
    return halves
