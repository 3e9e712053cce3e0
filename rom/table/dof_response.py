"""Displacement of degrees of freedom besides the modes of a model that has no contacts itself."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.harmonics import Harmonics
from slipmode.rom.short_repr import frozen


@frozen
class DofResponse:
    """Response of the DOFs to contacts and forces, without the modes, at the carriers.

        x = sum_j 2 Re((phi_j a_j + shapes^T p_j) e^(i theta_j)),
        p_j = P_j(|a|) e^(i arg a_j) + by_force_j F_j

    Attributes
    ----------
    shapes : (q, n) ndarray
        Displacements of the DOFs.
    coordinates : Harmonics
        P_j at the nodes of the table, q in place of contacts, in a steady state.
    by_force : (modes, q) complex ndarray
        Per modal force [N kg^-1/2].
    """

    shapes: Floats
    coordinates: Harmonics
    by_force: Complexes

    def at(self, amplitude: Complexes, force: Complexes, scale: Floats) -> Complexes:
        """Return p_j (points, modes, q).

        Amplitudes and modal forces are (points, modes), and the scale of the friction limits
        (points, 1).
        """
        by_contacts = scale[..., np.newaxis] * self.coordinates.at(amplitude / scale)
        return np.asarray(by_contacts + force[..., np.newaxis] * self.by_force)
