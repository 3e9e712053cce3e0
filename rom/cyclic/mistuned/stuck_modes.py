"""Modes of one disk with stuck contacts, for transients."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.cyclic.mistuned.disk_modes import Excited, MistunedModes
from slipmode.rom.slow.tone.tone_modes import ToneModes


def stuck_modes(
    modes: MistunedModes, pattern: int, springs: Floats, excited: Excited, frequency: float
) -> ToneModes:
    """Return the modes of a pattern with the contact springs (N N_c,), near a frequency [rad/s].

    Displacements are of the free DOFs (N, n_s), without the static displacement besides the modes.
    """
    psi, P = modes.contacts[pattern], modes.tuned.past_modes
    # x = hold (psi q + P y + x_p), with the contact forces y - k_ref x.
    hold = np.linalg.inv(np.eye(springs.size) + P * springs)
    psi_stuck = hold @ psi
    K = np.diag(modes.square[pattern]) + psi.conj().T @ (springs[:, np.newaxis] * psi_stuck)
    shapes = modes.shapes[pattern]

    def on_modes(modal: Complexes, past_modes: Complexes) -> Complexes:
        on_springs = psi_stuck.conj().T @ (springs * past_modes)
        return np.asarray(shapes.conj().T @ modal - on_springs)

    def blades(modal: Complexes, magnitude: complex, deficit: Complexes) -> Complexes:
        return modes.tuned.displacement(shapes @ modal)

    return ToneModes.of(
        0.5 * (K + K.conj().T),
        np.diag(modes.damping[pattern]),
        psi_stuck,
        on_modes(excited.modal, excited.past_modes),
        on_modes(excited.conjugate, excited.past_modes.conj()),
        frequency,
        static_flexibility=hold @ P,
        static_displacement=hold @ excited.past_modes,
        expand=blades,
    )
