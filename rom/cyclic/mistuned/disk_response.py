"""Blade amplitudes of disks, by pattern and frequency or time."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import frozen


@frozen
class DiskResponse:
    """Motions of disks by pattern, along frequencies or in time.

    Attributes
    ----------
    frequency : (frequencies,) ndarray
        Forcing frequencies [rad/s], in a transient those at its times.
    displacement : (patterns, frequencies, N, n_s) complex ndarray
        c of the free DOFs of every sector, which move by 2 Re(c exp(i Omega t)) [m].
    """

    frequency: Floats
    displacement: Complexes

    def amplitude(self, dof: int) -> Floats:
        """Return the amplitude of a DOF of every blade, (patterns, frequencies, N) [m]."""
        return np.asarray(2.0 * np.abs(self.displacement[..., dof]))

    def peak(self, dof: int) -> Floats:
        """Return the largest amplitude of a DOF over blades and frequencies, (patterns,) [m]."""
        return np.asarray(self.amplitude(dof).max(axis=(1, 2)))
