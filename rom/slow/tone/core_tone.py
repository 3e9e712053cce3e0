"""The structure of the core that a flow of a tone is made of, and its outputs."""

from __future__ import annotations

import numpy as np

from slipmode.rom import kernel
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.short_repr import frozen
from slipmode.rom.slow.tone.tone_modes import DampedModes, ToneModes
from slipmode.rom.table.local.local_contacts import LocalContacts


@frozen
class ToneOutputs:
    """Outputs of the core, as harmonics that are linear in modes, force deficits and the force.

    Attributes
    ----------
    amplitudes, elastic : int
        Numbers of modal amplitudes, and of displacements of DOFs after them. The last row is the
        work conj(f) x of the force.
    contact_motion : bool
        Whether displacements, velocities and forces of the contacts are outputs as well.
    modal : (K, R) complex ndarray
        Outputs by modal coordinates, K = amplitudes + elastic + 1.
    deficit : (K, N_c) complex ndarray
        Outputs by force deficits.
    force : (K,) complex ndarray
        Outputs by the magnitude of the force.
    stiffness : (N_c,) ndarray
        Stiffnesses of sticking contacts [N/m].
    """

    amplitudes: int
    elastic: int
    contact_motion: bool
    modal: Complexes
    deficit: Complexes
    force: Complexes
    stiffness: Floats


def core_tone(
    modes: ToneModes,
    contacts: LocalContacts,
    own: Complexes,
    frequency: float,
    outputs: ToneOutputs | None = None,
) -> kernel.Structure:
    """Return the core's structure of a tone.

    Parameters
    ----------
    modes, contacts, own, frequency
        See `ToneFlow`.
    outputs : ToneOutputs, optional
        Default: the core has no outputs.
    """
    nodes = contacts.secant.x
    spacing = (nodes[-1] - nodes[0]) / (nodes.size - 1)
    parts = [contacts.secant(nodes), spacing * contacts.secant(nodes, 1)]
    # (nodes, kinds, value or slope, real or imaginary)
    secant = np.array(parts).reshape(2, nodes.size, 2, contacts.kinds)
    by_others = modes.flexibility(frequency) - np.diag(own)
    besides = np.vstack((modes.static_flexibility.T - np.diag(own), modes.static_displacement))
    tone = kernel.Tone(
        slow=_modes(modes.slow, outputs),
        fast=_modes(modes.fast, outputs),
        contacts=own.size,
        kinds=contacts.kinds,
        nodes=nodes.size,
        reference=frequency,
        flexibility=split(besides),
        own=split(own),
        stiffness=np.zeros(own.size) if outputs is None else outputs.stiffness,
        onset=contacts.onset,
        first=nodes[0],
        spacing=spacing,
        secant=kernel.contiguous(secant.transpose(1, 3, 0, 2)),
        contraction=np.abs(parts[0]).max() * np.linalg.norm(by_others, 2),
    )
    if outputs is not None:
        for name in ("amplitudes", "elastic", "contact_motion"):
            setattr(tone, name, int(getattr(outputs, name)))
        tone.output = split(np.vstack((outputs.deficit.T, outputs.force)))
    return tone


def split(values: Complexes) -> Floats:
    """Return (..., n) complex numbers as (..., 2, n) real and imaginary parts."""
    return np.ascontiguousarray(np.stack((values.real, values.imag), axis=-2))


def _modes(modes: DampedModes, outputs: ToneOutputs | None) -> kernel.Structure:
    return kernel.ToneModes(
        count=modes.pole.size,
        pole=split(modes.pole),
        excitation=split(modes.excitation),
        conjugate=split(modes.conjugate),
        motion=split(modes.motion.T),
        projection=split(modes.projection.T),
        output=None if outputs is None else split((outputs.modal @ modes.shapes).T),
    )
