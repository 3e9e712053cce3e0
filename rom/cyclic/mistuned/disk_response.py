"""Blade amplitudes of disks, by pattern and frequency or time."""

from __future__ import annotations

import numpy as np

from slipmode.rom.common import Complexes, Floats, frozen


@frozen
class DiskResponse:
    """Hold the motion of mistuned disks by pattern, against frequency or time.

    Attributes
    ----------
    frequency : (frequencies,) ndarray
        Forcing frequencies [rad/s]; in a transient at the sample times.
    displacement : (patterns, frequencies, N, n_s) complex ndarray
        Harmonics c [m] of the free DOFs of every sector, which move as 2 Re(c exp(i Omega t)).
    """

    frequency: Floats
    displacement: Complexes

    def amplitude(self, dof: int) -> Floats:
        """Return the displacement amplitude of a DOF of every blade.

        Parameters
        ----------
        dof : int
            Free DOF of the sector.

        Returns
        -------
        (patterns, frequencies, N) ndarray
            Amplitudes [m].
        """
        return np.asarray(2.0 * np.abs(self.displacement[..., dof]))

    def peak(self, dof: int) -> Floats:
        """Return the largest displacement amplitude of a DOF over all blades and frequencies.

        Parameters
        ----------
        dof : int
            Free DOF of the sector.

        Returns
        -------
        (patterns,) ndarray
            Peaks [m].
        """
        return np.asarray(self.amplitude(dof).max(axis=(1, 2)))
