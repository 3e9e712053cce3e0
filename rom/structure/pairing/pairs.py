"""Contacts that were found between two surfaces, and fewer that they are gathered into."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.short_repr import short_repr
from slipmode.rom.structure.matrices import Sparse, as_csc
from slipmode.rom.structure.pairing.facets import Indices
from slipmode.rom.structure.pairing.frames import local_frames
from slipmode.rom.structure.pairing.patches import patch_of

_STILL = 1e-12  # length of a direction that moves nothing
_BENT = 0.5  # length of the mean of unit normals: 60 degrees to each side


@dataclass(frozen=True, eq=False)
class ContactPairs:
    """Contacts between a surface and its target, ready for Structure and FrictionalContact.

    Attributes
    ----------
    relative : (n, 3 contacts) sparse matrix
        x, y, z displacement of the surface at each contact less that of the target.
    frames : (contacts, 3, 3) ndarray
        Rows t_1, t_2, n: orthonormal, right-handed, n from the surface into the target.
    area : (contacts,) ndarray
        [m^2]
    gap : (contacts,) ndarray
        Initial distance along n [m], 0 where the meshes touch or overlap.
    position : (contacts, 3) ndarray
        [m]
    nodes : tuple of (k,) ndarray of int
        Nodes of the surface that each contact is made of.
    unpaired : (k,) ndarray of int
        Nodes of the surface that meet nothing, or are held, and so is what they meet.
    tangents : {1, 2}
        Tangential directions that W has of each contact.
    """

    relative: Sparse = field(repr=False)
    frames: Floats
    area: Floats
    gap: Floats
    position: Floats
    nodes: tuple[Indices, ...]
    unpaired: Indices
    tangents: int

    __repr__ = short_repr

    @property
    def W(self) -> Sparse:  # noqa: N802
        """Directions (n, N_c): of each contact its tangents, then its normal, positive closing.

        Raises
        ------
        SlipmodeError
            If a contact cannot move in a direction.
        """
        kept = self.frames[:, [*range(self.tangents), 2]]
        W = as_csc(self.relative @ scipy.sparse.block_diag(kept.swapaxes(1, 2)))
        length = np.sqrt(W.power(2).sum(axis=0))
        if np.any(length <= _STILL):
            contact, place = divmod(int(np.argmin(length)), self.tangents + 1)
            axis = "normal" if place == self.tangents else f"tangent {place + 1}"
            raise SlipmodeError(
                f"dofs: contact {contact}, at node {self.nodes[contact][0]}, is held on both "
                f"sides along its {axis}; gather it with others, or take its node out of surface"
            )
        return W

    def gathered(self, patches: int | ArrayLike) -> ContactPairs:
        """Fewer contacts, each of the contacts of a patch.

        The displacement of a patch is the mean of those of its contacts by area, which is the
        translation of the rigid motion at its centre that fits them best by area. Rotation of a
        patch against the target is free: that takes several patches, three for all rotations.

        Parameters
        ----------
        patches : int or (contacts,) array_like of int
            How many, of about equal area; or a label for each contact, patches in their order.

        Raises
        ------
        SlipmodeError
            If a patch bends so much that it has no normal, or `patches` does not fit.
        """
        patch = patch_of(patches, self.position, self.area)
        count, contacts = int(patch.max()) + 1, len(self.area)
        area = np.bincount(patch, self.area).astype(float)
        share = scipy.sparse.csc_array(
            (self.area / area[patch], (np.arange(contacts), patch)), shape=(contacts, count)
        )
        mean = (share.T @ self.frames.reshape(contacts, 9)).reshape(count, 3, 3)
        length = np.linalg.norm(mean[:, 2], axis=1)
        if np.any(length < _BENT):
            raise SlipmodeError(
                f"patches: patch {np.argmin(length)} bends too much to have one normal; divide "
                "it into more patches"
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
