"""Contacts between two surfaces, their local frames, and patches that they are gathered into."""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.matrices import Sparse, as_csc
from slipmode.rom.structure.pairing.surfaces import Indices


@frozen
class ContactPairs:
    """Hold contacts between a surface and its target for `Structure` and `FrictionalContact`.

    Attributes
    ----------
    relative : (n, 3 contacts) sparse matrix
        Displacement of the surface relative to the target along x, y, z at each contact, per
        displacement of each DOF [-].
    frames : (contacts, 3, 3) ndarray
        Orthonormal right-handed rows t_1, t_2, n [-]; n points from the surface into the target.
    area : (contacts,) ndarray
        Contact areas [m^2].
    gap : (contacts,) ndarray
        Initial distance along n [m], 0 where the meshes touch or overlap.
    position : (contacts, 3) ndarray
        Positions on the surface [m].
    nodes : tuple of (k,) ndarray of int
        Nodes of the surface in each contact.
    unpaired : (k,) ndarray of int
        Nodes of the surface that have no partner on the target, or are fixed on both sides.
    tangents : {1, 2}
        Number of tangential directions of each contact in W.
    """

    relative: Sparse = field(repr=False)
    frames: Floats
    area: Floats
    gap: Floats
    position: Floats
    nodes: tuple[Indices, ...]
    unpaired: Indices
    tangents: int

    @property
    def W(self) -> Sparse:  # noqa: N802
        """Contact directions W (n, N_c) [-] for `Structure`, a sparse matrix.

        Columns of each contact are its tangential directions and then its normal, which is
        positive as the contact closes.

        Raises
        ------
        SlipmodeError
            If the nodes of a contact are fixed in one of its directions.
        """
        kept = self.frames[:, [*range(self.tangents), 2]]
        W = as_csc(self.relative @ scipy.sparse.block_diag(kept.swapaxes(1, 2)))
        length = np.sqrt(W.power(2).sum(axis=0))
        if np.any(length <= 1e-12):
            contact, place = divmod(int(np.argmin(length)), self.tangents + 1)
            axis = "normal" if place == self.tangents else f"tangent {place + 1}"
            raise SlipmodeError(
                f"dofs: contact {contact}, at node {self.nodes[contact][0]}, is fixed on both "
                f"sides along its {axis}; put it into a patch with others "
                "(ContactPairs.gathered), or remove its node from surface"
            )
        return W

    def gathered(self, patches: int | ArrayLike) -> ContactPairs:
        """Return one contact for each patch of contacts.

        The displacement of a patch is the mean displacement of its contacts, weighted by area. A
        patch does not resist rotation relative to the target; at least three patches are needed to
        resist all rotations.

        Parameters
        ----------
        patches : int or (contacts,) array_like of int
            Number of patches of about equal area, or the number of the patch of each contact.

        Returns
        -------
        ContactPairs
            One contact for each patch, with the sum of the areas and the mean of the gaps.

        Raises
        ------
        SlipmodeError
            If the normals of a patch differ so much that it has no mean normal, or if `patches`
            has a wrong shape or value.
        """
        patch = _patch_of(patches, self.position, self.area)
        count, contacts = int(patch.max()) + 1, len(self.area)
        area = np.bincount(patch, self.area).astype(float)
        share = scipy.sparse.csc_array(
            (self.area / area[patch], (np.arange(contacts), patch)), shape=(contacts, count)
        )
        mean = (share.T @ self.frames.reshape(contacts, 9)).reshape(count, 3, 3)
        length = np.linalg.norm(mean[:, 2], axis=1)
        # Half: it bends by 60 degrees to each side
        if np.any(length < 0.5):
            raise SlipmodeError(
                f"patches: the normals of patch {np.argmin(length)} differ too much; divide it "
                "into more patches"
            )
        return ContactPairs(
            relative=as_csc(self.relative @ scipy.sparse.kron(share, np.eye(3))),
            frames=local_frames(mean[:, 2] / length[:, np.newaxis], mean[:, 0]),
            area=area,
            gap=np.asarray(share.T @ self.gap),
            position=np.asarray(share.T @ self.position),
            nodes=tuple(
                np.concatenate([self.nodes[k] for k in np.flatnonzero(patch == p)])
                for p in range(count)
            ),
            unpaired=self.unpaired,
            tangents=self.tangents,
        )


def local_frames(normals: Floats, tangent: Floats | None = None) -> Floats:
    """Return right-handed frames (contacts, 3, 3), rows t_1, t_2, n, of normals n (contacts, 3).

    t_1 is the part of `tangent`, (3,) or one per contact, across the normal. Default: one global
    axis for all contacts: x, unless y or z is at least twice as far from every normal. Where a
    normal is along that direction: the global axis farthest from the normal.
    """
    axes = np.eye(3)
    across = np.sqrt(np.maximum(1.0 - normals**2, 0.0))  # sine of angle to each axis
    if tangent is None:
        least = across.min(axis=0)
        tangent = axes[np.argmax(least >= 0.5 * least.max())]
    t_1 = tangent - np.sum(tangent * normals, axis=1, keepdims=True) * normals
    along = np.linalg.norm(t_1, axis=1) < 0.1 * np.linalg.norm(tangent, axis=-1)
    if along.any():
        other, n = axes[np.argmax(across[along], axis=1)], normals[along]
        t_1[along] = other - np.sum(other * n, axis=1, keepdims=True) * n
    t_1 /= np.linalg.norm(t_1, axis=1)[:, np.newaxis]
    return np.stack((t_1, np.cross(normals, t_1), normals), axis=1)


def _patch_of(patches: int | ArrayLike, position: Floats, area: Floats) -> Indices:
    """Return the patch of each contact, (contacts,), from 0: as given, or by bisection."""
    given: Any = np.asarray(patches)
    if given.dtype.kind not in "iu" or given.ndim > 1:
        raise SlipmodeError("patches: must be a number of patches, or an integer per contact")
    if given.ndim == 0:
        if not 1 <= given <= len(area):
            raise SlipmodeError(
                f"patches: must be 1 to {len(area)}, the number of contacts, got {given}"
            )
        return _bisected(int(given), position, area)
    if given.size != len(area):
        raise SlipmodeError(
            f"patches: must be one integer for each of {len(area)} contacts, got {given.size}"
        )
    return np.asarray(np.unique(given, return_inverse=True)[1], dtype=np.intp)


def _bisected(count: int, position: Floats, area: Floats) -> Indices:
    """Return patches of equal area: halved across the longest global axis, again and again."""
    patch = np.zeros(len(area), dtype=np.intp)
    parts = [(np.arange(len(area)), 0, count)]
    while parts:
        own, first, wanted = parts.pop()
        patch[own] = first
        if wanted == 1:
            continue
        half = wanted // 2
        axis = np.argmax(np.ptp(position[own], axis=0))
        own = own[np.argsort(position[own, axis], kind="stable")]
        filled = np.cumsum(area[own])
        middle = 1 + int(np.argmin(np.abs(filled - half / wanted * filled[-1])))
        middle = min(max(middle, half), len(own) - (wanted - half))
        parts += [(own[:middle], first, half), (own[middle:], first + half, wanted - half)]
    return patch
