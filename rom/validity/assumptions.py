"""Assumptions of the method, and indicators of how a model, a motion or a force violates them.

Forcing frequencies too far from their mode, and two that meet, are refused. Other violations are a
`Finding` with the measured indicator. Scenes show findings in their plan and in the recording; in
Python, findings that are warnings are issued as `ValidityWarning`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.errors import Finding, SlipmodeError
from slipmode.rom.frequencies import carrier_findings, check_carrier, spin_of
from slipmode.rom.laws.directions import skewed_directions
from slipmode.rom.laws.friction import Friction
from slipmode.rom.reduction.combination import CombinationResonance
from slipmode.rom.reduction.force_response import AppliedForces, steady_force
from slipmode.rom.reduction.interaction.mode_proposals import ContactModes, Retention
from slipmode.rom.reduction.reaction import STRAINED, stiffness_loss
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.short_repr import percentage
from slipmode.rom.structure.structure import Structure
from slipmode.rom.validity.friction import friction_findings

_SMALL = 0.3  # largest share of a mode's stiffness that contact motion may take away


def check_carriers(reduced: Reduced, frequency: Floats, forced: Flags) -> None:
    """Refuse points (..., modes) [rad/s] that the slow flow of the forced modes cannot follow.

    `forced` is (modes,). The frequencies of two forced modes must differ.
    """
    for j in np.flatnonzero(forced).tolist():
        omega, spin = float(reduced.frequency[j]), spin_of(reduced.spin, j)
        check_carrier("frequency", "AB"[j], omega, frequency[..., j], spin=spin)
    if reduced.spin is not None and forced.all():
        speeds = frequency / reduced.spin[:, 1]
        if np.ptp(speeds, axis=-1).max() > 1e-6 * speeds.max():
            raise SlipmodeError(
                "frequency: the frequencies of A and B must be their engine orders "
                f"{reduced.spin[:, 1]} times one rotor speed"
            )
    if np.count_nonzero(forced) == 2 and carriers_meet(frequency[..., np.newaxis, :]).any():
        raise SlipmodeError(
            "frequency: the frequencies of modes A and B must differ at each point; modes of one "
            "frequency share a tone, rom.reduce(tones=(0, 0))"
        )


def check_carriers_along(reduced: Reduced, ends: Floats, forced: Flags) -> None:
    """Refuse a straight line between two points (2, modes), as `check_carriers`."""
    check_carriers(reduced, ends, forced)
    if np.count_nonzero(forced) == 2 and carriers_meet(ends):
        raise SlipmodeError(
            "frequency: the frequencies of modes A and B must differ all along the line, and must "
            "not cross"
        )


def forcing_findings(reduced: Reduced, frequency: Floats, forced: Flags) -> list[Finding]:
    """Report forced modes (modes,) far from their forcing (..., modes) [rad/s]."""
    names = [name for name, each in zip("AB", forced, strict=False) if each]
    return carrier_findings("frequency", names, reduced.frequency[forced], frequency[..., forced])


def carriers_meet(frequency: Floats) -> Flags:
    """Return whether two forcing frequencies (..., instants, 2) become equal or cross."""
    gap = frequency[..., 1] - frequency[..., 0]
    return np.asarray(~((gap > 0.0).all(axis=-1) | (gap < 0.0).all(axis=-1)))


def meeting_refusal(keys: str) -> str:
    """Return why forcing frequencies with these keys are refused that meet."""
    return f"{keys}: must differ at all times, and must not cross"


def model_findings(
    reduced: Reduced,
    law: Friction,
    amplitude_range: Floats,
    combinations: Sequence[CombinationResonance] = (),
    names: Sequence[str] = "AB",
) -> list[Finding]:
    """Report violations by a model itself, at the largest amplitudes (modes,) of its table."""
    return [
        *carrier_findings("carrier", names, reduced.frequency, reduced.carrier),
        *contact_findings(reduced, combinations, names),
        *friction_findings(reduced, law, amplitude_range),
    ]


def proposal_findings(
    reduced: Reduced,
    force_patterns: Sequence[Floats],
    frequency: tuple[Floats, Floats],
    slip: Floats,
    names: Sequence[str] = "AB",
) -> list[Finding]:
    """Report modes of the structure that must be retained with the modes (`names`).

    `frequency` are the smallest and the largest forcing frequencies, each (modes,) [rad/s], and
    `slip` (modes,) is the largest |Q_j| / omega_j^2, or infinity if it is not known. Of a model
    from a file the modes are not known.
    """
    if reduced.structure is None or reduced.formulation == "paper":
        return []
    modes, retention, found = ContactModes.of_reduced(reduced), Retention.of(reduced), []
    free = modes.shared.diagonal() / np.maximum(modes.frequency**2, np.finfo(float).tiny)
    tones = zip(names, reduced.modes, force_patterns, *frequency, slip, free, strict=False)
    for name, mode, pattern, low, high, share, most in tones:
        force = reduced.all_shapes.T @ pattern
        slipping = modes.with_slip(float(share / most) if share < most else 1.0)
        for each in slipping.proposals(mode, retention, (float(low), float(high)), force):
            choice = "is close to another mode" if each.order == 1 else "excites another mode"
            found.append(Finding(f"mode {name}", choice, str(each), "warning"))
    return found


def contact_findings(
    reduced: Reduced,
    combinations: Sequence[CombinationResonance] = (),
    names: Sequence[str] = "AB",
) -> list[Finding]:
    """Report modes that contacts hardly affect, and contacts that the modes make soft."""
    if not reduced.n_contacts:
        return []
    if reduced.contacts is None:
        motion = np.linalg.solve(reduced.stiffness, reduced.spring.T)
    else:
        motion = reduced.contacts.reference[:, np.newaxis] * reduced.spring.T
    shares = np.einsum("jc,cj->j", reduced.spring, motion) / reduced.frequency**2
    found = []
    for mode, share in zip(names, shares, strict=False):
        if share < 1e-8:
            reason = (
                f"the share of its stiffness due to contacts is {share:.1e}, so friction does not "
                "affect it. Choose another mode or other contacts"
            )
            found.append(Finding(f"mode {mode}", "does not move the contacts", reason, "warning"))
    if reduced.contacts is not None:
        return found
    loss, _ = stiffness_loss(reduced, combinations)
    if loss > STRAINED:
        reason = (
            f"the response of the modes reduces the contact stiffness by {percentage(loss)}, more "
            f"than {percentage(STRAINED)}. The friction table takes long to compute. Compare with "
            "slipmode validate"
        )
        found.append(Finding("contact stiffness", "is low", reason, "warning"))
    return found


def detuning_findings(tolerance: float, error: float, distance: float) -> list[Finding]:
    """Report a relative distance from the reference frequency if its error exceeds the tolerance.

    `error` is the relative error of friction there, infinity if it is not known.
    """
    if error <= tolerance:
        return []
    if error == np.inf:
        reason = (
            "the friction error there is not known. Tabulate at the forcing frequency, or with "
            "detuning=True"
        )
        return [reference_frequency_finding(distance, reason)]
    size = f"about {percentage(error)}" if error < 1.0 else "100 % or more"
    reason = (
        f"the friction error there is {size} of the largest friction (tolerance "
        f"{percentage(tolerance)}). Call rom.reduce with carrier = this frequency, or "
        "compare with slipmode validate"
    )
    return [reference_frequency_finding(distance, reason)]


def reference_frequency_finding(distance: float, reason: str) -> Finding:
    """Return the warning about a frequency at a relative `distance` from the reference."""
    choice = f"is up to {percentage(distance)} away from the reference frequency of the table"
    return Finding("frequency", choice, reason, "warning")


def direction_findings(structure: Structure, law: Friction) -> list[Finding]:
    """Report directions of a contact that are not orthogonal and equally long."""
    reason = skewed_directions(structure.directions, law)
    return [Finding("contacts", "have skewed directions", reason, "warning")] if reason else []


def share_findings(share: Floats, names: Sequence[str] = "AB") -> list[Finding]:
    """Report modes that contact motion does not merely perturb; share is |Q_j| / omega_j^2."""
    reason = (
        "contact motion changes the modal stiffness by {}, more than {}. The slow flow assumes "
        "a small perturbation. Compare with slipmode validate"
    )
    limit = percentage(_SMALL)
    return [
        Finding(
            f"mode {mode}",
            "is strongly perturbed",
            reason.format(percentage(part), limit),
            "warning",
        )
        for mode, part in zip(names, share, strict=False)
        if part > _SMALL
    ]


def force_findings(applied: AppliedForces, names: Sequence[str] = "AB") -> list[Finding]:
    """Report forces whose direct effect on the contacts no friction table includes.

    A table includes it as a function of the amplitude that the force holds steady. That amplitude
    does not determine a force that moves the contacts about as much as its mode does.
    """
    reduced = applied.reduced
    if reduced.formulation == "paper" or reduced.force_patterns is None:
        return []
    acting = np.abs(applied.residual(applied.past_mode)).max(axis=1)
    through = np.abs(reduced.coupling).max(axis=1)
    # relative to the force through a mode with its static stiffness; friction hardly changes below
    directly = acting * reduced.frequency**2 > 1e-3 * through
    known = (steady_force(reduced)[0] != 0.0).any(axis=1)
    reason = (
        "its direct effect on them is about as large as its effect through the mode. A friction "
        'table does not include it. Use model.table = "none" or rom.steady_state'
    )
    return [
        Finding(f"force {mode}", "acts on the contacts directly", reason, "warning")
        for mode, neglected in zip(names, directly & ~known & (applied.modal != 0.0), strict=False)
        if neglected
    ]
