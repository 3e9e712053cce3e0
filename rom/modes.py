"""Modes to choose from, with free, stuck and bonded contacts, and their contact motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Floats, check_count, in_one_line
from slipmode.rom.errors import SlipmodeError, warn
from slipmode.rom.frequencies import mode_frequency_findings
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.progress import phases
from slipmode.rom.reduction.interaction.mode_proposals import ContactModes, ModeProposal, Retention
from slipmode.rom.short_repr import frozen
from slipmode.rom.structure.held import Held, bonded, bonded_mode_count, stuck
from slipmode.rom.structure.labels import DIRECTIONS
from slipmode.rom.structure.matrices import as_dense
from slipmode.rom.structure.structure import Structure


@frozen
class ModeSet:
    """Hold the lowest modes of the structure with its contacts in one state.

    Attributes
    ----------
    frequency : (count,) ndarray
        Natural frequencies [rad/s]; 0 for rigid-body modes.
    damping : (count,) ndarray
        Damping ratios phi^T C phi / (2 omega) [-]; 0 for rigid-body modes.
    shapes : (n, count) ndarray
        Mass-normalised mode shapes [kg^-1/2].
    contact : (count, N_c) ndarray
        Contact displacements W^T phi of the mode shapes [kg^-1/2]; 0 for bonded contacts.
    effective_mass : (count, 3) ndarray or None
        Effective modal mass along x, y, z, relative to the mass [-]; None without labels.
    """

    frequency: Floats
    damping: Floats
    shapes: Floats
    contact: Floats
    effective_mass: Floats | None

    @property
    def hertz(self) -> Floats:
        """Natural frequencies (count,) [Hz]."""
        return np.asarray(self.frequency / (2.0 * np.pi))


@frozen
class ModeTable:
    """Hold the lowest modes for each state of the contacts; `print` shows a table.

    Attributes
    ----------
    states : mapping of "free", "stuck", "bonded" to ModeSet
        Modes with free, stuck and bonded contacts; "stuck" only with a law, with which there may
        be fewer bonded modes.
    reference : {"stuck", "bonded"}
        State whose modes `rom.reduce` numbers.
    free_mode : (count,) ndarray of int
        Free mode with the most similar shape for each reference mode.
    stiffness_share : (count,) ndarray
        Share of stiffness due to contacts [-]: relative loss of modal stiffness if the contacts
        slip freely.
    contact : (count, N_c) ndarray
        Contact displacement of each reference mode [kg^-1/2]; for bonded contacts, of the free
        mode. `print` shows it relative to the largest.
    pairs : tuple of (int, int)
        Pairs of modes A and B that suit a reduction, best first. Friction acts on both modes at
        common contacts, and none of them must be retained with a neighbour.
    together : tuple of ModeProposal
        For each mode, if it is forced: the modes that must be retained with it (`others`), because
        they are close (`order` 1) or a harmonic of the contacts excites them (`order` 2 to 9), how
        much they change its amplitude (`effect` [-]), the `reason`, and how to retain them
        (`advice`).
    """

    states: Mapping[str, ModeSet]
    reference: str
    free_mode: NDArray[np.intp]
    stiffness_share: Floats
    contact: Floats
    pairs: tuple[tuple[int, int], ...]
    together: tuple[ModeProposal, ...] = ()

    def __str__(self) -> str:
        chosen = self.states[self.reference]
        masses = chosen.effective_mass is not None
        head = f"{'mode':>4}" + "".join(f"{name + ' Hz':>11}" for name in self.states)
        head += f"{self.reference + ' rad/s':>13} {'damping':>8}"
        head += "".join(f"{'m_' + k:>7}" for k in DIRECTIONS[:3]) if masses else ""
        head += f"  {'stiffness share':>15}  contacts"
        lines = [head]
        largest = np.abs(self.contact).max() or 1.0
        for k in range(chosen.frequency.size):
            line = f"{k:4}"
            for state in self.states.values():  # with bonded contacts there may be fewer modes
                line += f"{state.hertz[k]:11.5g}" if k < state.hertz.size else f"{'':11}"
            line += f"{chosen.frequency[k]:13.5g} {chosen.damping[k]:8.2%}"
            if chosen.effective_mass is not None:
                line += "".join(f"{share:7.1%}" for share in chosen.effective_mass[k])
            motion = self.contact[k] / largest
            most_moved = np.argsort(-np.abs(motion), kind="stable")[:3]
            line += f"  {self.stiffness_share[k]:15.2%}  "
            lines.append(line + ", ".join(f"{c}: {motion[c]:.2f}" for c in most_moved))
        named = ", ".join(f"{a} and {b}" for a, b in self.pairs)
        lines.append(
            f"recommended pairs: {named}"
            if named
            else "no pair of modes is separated from its neighbours and affected by friction"
        )
        return "\n".join([*lines, *map(str, self.together)])


def modes(
    structure: Structure, law: Elastic | None = None, n: int = 10, progress: bool = False
) -> ModeTable:
    """Return the lowest modes with free, stuck and bonded contacts.

    Use it to choose the modes for `rom.reduce`.

    Parameters
    ----------
    structure : Structure
        Structure with n DOFs and N_c contact DOFs.
    law : elastic law, optional
        Law whose springs model the stuck contacts. Default: rigid friction, with bonded
        contacts.
    n : int, default 10
        Number of modes of each state.
    progress : bool, default False
        Print the phases of the computation on standard error.

    Returns
    -------
    ModeTable
        Frequencies, damping ratios, shapes and contact displacements of the modes.

    Raises
    ------
    SlipmodeError
        If n is below 1, the law is not elastic, or all DOFs are contact DOFs of a rigid law.

    Warns
    -----
    ValidityWarning
        If a natural frequency other than 0 is outside 0.001 Hz to 1 MHz: mass and stiffness may
        be swapped, or in other units.

    Examples
    --------
    >>> rom.modes(rom.two_mass(), n=2).states["bonded"].frequency
    array([1. , 1.7])
    """
    check_count("n", n)
    if law is not None and not isinstance(law, Elastic):
        raise SlipmodeError(
            f"law: must be elastic; leave it out for rigid friction, got {in_one_line(law)}"
        )
    elastic_dofs = bonded_mode_count(structure)
    if law is None and elastic_dofs == 0:
        raise SlipmodeError(
            f"contact: all {structure.n_modes} DOFs are contacts, so there is no mode with bonded "
            "contacts; give an elastic law"
        )
    count = min(n, elastic_dofs if law is None else structure.n_modes)
    with phases("modes", shown=progress):
        free = _mode_set(structure, stuck(structure, np.zeros(structure.n_contacts)), count)
        fixed = {}
        if elastic_dofs > 0:
            held = bonded(structure, may_float=True)
            fixed["bonded"] = _mode_set(structure, held, min(n, elastic_dofs))
        states = {"free": free, **fixed}
        if law is not None:  # last, for `reduce` to find this factorisation
            reference = law.elements(structure.n_contacts).reference
            springs = _mode_set(structure, stuck(structure, reference), count)
            states = {"free": free, "stuck": springs, **fixed}
    name = "bonded" if law is None else "stuck"
    chosen = states[name]
    similarity = np.abs(chosen.shapes.T @ as_dense(structure.mass @ free.shapes))
    similar = np.argmax(similarity, axis=1)
    omega = chosen.frequency
    vibrating = np.flatnonzero(omega > 0.0)
    warn(mode_frequency_findings(vibrating.astype(str).tolist(), omega[vibrating])[:1])
    ratio = np.divide(free.frequency[similar], omega, out=np.ones(count), where=omega > 0)
    stiffness_share = np.clip(1.0 - ratio**2, 0.0, 1.0)
    contact = free.contact[similar] if law is None else chosen.contact
    weight = np.ones(structure.n_contacts) if law is None else reference
    moved = np.abs(contact) * np.sqrt(weight)
    if law is None:  # from the loss of stiffness, as no spring is known
        size = np.linalg.norm(moved, axis=1, keepdims=True)
        moved *= np.sqrt(stiffness_share)[:, np.newaxis] * omega[:, np.newaxis]
        moved = np.divide(moved, size, out=np.zeros_like(moved), where=size > 0.0)
    damping = 2.0 * chosen.damping * omega
    coupled = ContactModes(np.arange(count), omega, damping, moved @ moved.T)
    even = law is not None and not law.elements(structure.n_contacts).odd
    together = tuple(
        proposal
        for mode in vibrating.tolist()
        for proposal in coupled.proposals(mode, Retention((mode,), law is not None, even))
    )
    pairs = _pairs(coupled, stiffness_share, together)
    return ModeTable(states, name, similar, stiffness_share, contact, pairs, together)


def _mode_set(structure: Structure, held: Held, count: int) -> ModeSet:
    frequency, shapes = held.modes(count)
    damped = 0.5 * np.einsum("nk,nk->k", shapes, as_dense(structure.damping @ shapes))
    vibrating = frequency > 0
    ratio = np.divide(damped, frequency, out=np.zeros(count), where=vibrating)
    if structure.loss is not None:
        lost = 0.5 * np.einsum("nk,nk->k", shapes, as_dense(structure.loss @ shapes))
        ratio += np.divide(lost, frequency**2, out=np.zeros(count), where=vibrating)
    contact = np.asarray(structure.directions.T @ shapes).T
    return ModeSet(frequency, ratio, shapes, contact, _effective_mass(structure, shapes))


def _effective_mass(structure: Structure, shapes: Floats) -> Floats | None:
    """Return (phi^T M r)^2 / r^T M r for unit motion r in x, y, z; None without labels."""
    if structure.labels is None:
        return None
    unit = (structure.labels.direction[:, np.newaxis] == np.arange(1, 4)).astype(float)
    moved = as_dense(structure.mass @ unit)
    total = np.einsum("nk,nk->k", unit, moved)
    share = np.asarray(shapes.T @ moved) ** 2
    return np.asarray(np.divide(share, total, out=np.zeros_like(share), where=total > 0))


def _pairs(
    modes: ContactModes, stiffness_share: Floats, together: Sequence[ModeProposal]
) -> tuple[tuple[int, int], ...]:
    """Return the pairs with the largest effect of friction at contacts that both modes move."""
    close = [each.mode for each in together if each.order == 1]
    # With enough stiffness due to contacts; rigid-body modes have none
    fit = np.flatnonzero((stiffness_share >= 1e-3) & ~np.isin(modes.number, close))
    share = modes.shared[np.ix_(fit, fit)] / np.outer(modes.frequency[fit], modes.frequency[fit])
    effect = {
        (int(fit[a]), int(fit[b])): float(share[a, b]) for a, b in combinations(range(fit.size), 2)
    }
    return tuple(sorted(effect, key=lambda pair: -effect[pair])[:3])
