"""The structure of the core that a flow of a tone is made of, and its outputs."""

from __future__ import annotations

from collections.abc import Sequence

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
    modes: Sequence[ToneModes],
    contacts: LocalContacts,
    own: Complexes,
    frequency: Floats,
    outputs: Sequence[ToneOutputs] | None = None,
) -> kernel.Structure:
    """Return the core's structure of modes on one or two tones.

    Parameters
    ----------
    modes, contacts, own, frequency
        See `ToneFlow`.
    outputs : sequence of ToneOutputs, optional
        By tone. Default: the core has no outputs.
    """
    secant = kernel.contiguous(contacts.secant)
    nodes, shares, kinds, tones = secant.shape[:4]
    given = [None] * tones if outputs is None else outputs
    by_others = [
        each.flexibility(nu) - np.diag(g)
        for each, nu, g in zip(modes, frequency, own, strict=True)
    ]
    largest = np.hypot(*np.moveaxis(secant[..., 0, 0], -1, 0)).max()
    tone = kernel.Tone(
        tones=tones,
        contacts=own.shape[1],
        kinds=kinds,
        nodes=nodes,
        shares=shares,
        stiffness=np.zeros(own.shape[1]) if outputs is None else outputs[0].stiffness,
        onset=contacts.onset,
        first=contacts.first,
        spacing=contacts.spacing,
        secant=secant,
        contraction=largest * max(np.linalg.norm(each, 2) for each in by_others),
    )
    carriers = [_carrier(*each) for each in zip(modes, own, frequency, given, strict=True)]
    tone.owned["carrier"] = carriers
    for t, each in enumerate(carriers):
        tone.carrier[t] = each
    if outputs is not None:
        tone.elastic, tone.contact_motion = outputs[0].elastic, int(outputs[0].contact_motion)
    return tone


def split(values: Complexes) -> Floats:
    """Return (..., n) complex numbers as (..., 2, n) real and imaginary parts."""
    return np.ascontiguousarray(np.stack((values.real, values.imag), axis=-2))


def _carrier(
    modes: ToneModes, own: Complexes, frequency: float, outputs: ToneOutputs | None
) -> kernel.Structure:
    besides = np.vstack((modes.static_flexibility.T - np.diag(own), modes.static_displacement))
    carrier = kernel.ToneCarrier(
        slow=_modes(modes.slow, outputs),
        fast=_modes(modes.fast, outputs),
        reference=frequency,
        flexibility=split(besides),
        own=split(own),
    )
    if outputs is not None:
        carrier.amplitudes = outputs.amplitudes
        carrier.output = split(np.vstack((outputs.deficit.T, outputs.force)))
    return carrier


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
