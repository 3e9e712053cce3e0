"""Whether friction limits are plausible at the amplitudes that are reached."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipmode.rom.arrays import Flags, Floats
from slipmode.rom.contact.slip_onset import largest_load
from slipmode.rom.errors import Finding
from slipmode.rom.laws.elements import FRICTIONAL
from slipmode.rom.laws.friction import Friction, RigidFriction, Tanh, limits
from slipmode.rom.reduction.force_response import steady_coupling
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.representable import round_down
from slipmode.rom.short_repr import short_list

# Least friction limit relative to the elastic force on a stuck contact, at the largest amplitudes.
# A smaller one is likely in another unit: prefixes of units are factors of 1000.
_EXCEEDED = 1e-2
# Largest and smallest tanh velocity, relative to the velocity of sliding without friction.
_BLURRED, _SHARP = 2.0, 1e-10
_DASHPOT = "acts as a dashpot"


def friction_findings(reduced: Reduced, law: Friction, amplitude: Floats) -> list[Finding]:
    """Report friction that does nothing, or hardly acts, at the largest amplitudes (modes,)."""
    found = frictionless_findings(law, reduced.n_contacts)
    limit = limits(law, reduced.n_contacts)
    force = elastic_force(reduced, amplitude)
    touched = (force > 0.0) & (limit > 0.0)
    if not touched.any():
        return found
    where, share = _least_holding(law, limit, force, touched)
    load = largest_load(reduced, law, amplitude)
    of_tanh = []
    if isinstance(law, Tanh):
        of_tanh = _tanh_findings(reduced, law, amplitude, np.maximum(limit, force), touched)
    if share < _EXCEEDED:
        reason = (
            f"{where} {share:.1e} times the elastic force at the largest amplitude, less than "
            f"{_EXCEEDED:g} times. Check whether the force or the amplitude is too large, or the "
            "limit is in another unit"
        )
        found.append(Finding("friction", "hardly acts", reason, "warning"))
    elif (
        0.0 < load < 1.0
        and not any(each.choice == _DASHPOT for each in of_tanh)
        and not _creeps(reduced, law, amplitude)
    ):
        reason = (
            f"no contact slips or opens. The largest load on a contact is {load:.3g} times its "
            f"limit, so contacts slip from {1.0 / load:.3g} times the largest amplitude on. Check "
            "whether the force or the amplitude is too small, or the limit is in another unit"
        )
        found.append(Finding("friction", "does not act", reason, "warning"))
    return [*found, *of_tanh]


def frictionless_findings(law: Friction, contacts: int) -> list[Finding]:
    """Report contacts without friction: a limit of 0, or a friction coefficient of 0.

    With a coefficient of 0 a contact still opens, so that is only information.
    """
    free = np.flatnonzero((limits(law, contacts) == 0.0) & ~_is_preloaded(law, contacts))
    found = []
    if free.size:
        reason = f"the friction limit is 0 at {_contact_list(free, contacts)}"
        found.append(Finding("friction", "is zero", reason, "warning"))
    if not isinstance(law, RigidFriction):
        element = law.elements(contacts).element
        smooth = element[(element["law"] == FRICTIONAL) & (element["friction"] == 0.0)]
        if smooth.size:
            where = _contact_list(smooth["column"][:, 0], contacts)
            reason = f"the friction coefficient is 0 at {where}. They only open and close"
            found.append(Finding("friction", "is zero", reason))
    return found


def _contact_list(numbers: NDArray[np.intp], contacts: int) -> str:
    """Return the numbers of some of the contact DOFs in words."""
    if numbers.size == contacts:
        return "all contacts"
    word = "contact" if numbers.size == 1 else "contacts"
    return f"{word} {short_list(map(str, numbers))}"


def elastic_force(reduced: Reduced, amplitude: Floats) -> Floats:
    """Return the largest force on contacts that stick, (..., N_c) [N], at (..., modes)."""
    reference = 1.0 if reduced.contacts is None else reduced.contacts.reference
    return np.asarray(2.0 * np.abs(amplitude) @ np.abs(reduced.coupling) * reference)


def _is_preloaded(law: Friction, contacts: int) -> Flags:
    """Return which contact DOFs (N_c,) have a limit that follows from a preload."""
    preloaded = np.zeros(contacts, dtype=bool)
    if not isinstance(law, RigidFriction):
        for element in law.elements(contacts).element:
            if element["law"] == FRICTIONAL:
                preloaded[element["column"][: element["tangents"] + 1]] = True
    return preloaded


def _least_holding(
    law: Friction, limit: Floats, force: Floats, touched: Flags
) -> tuple[str, float]:
    """Return where the limit is the smallest share of the elastic force, in words, and the share.

    A preload is small at the edge of an area in contact, so preloaded contacts are summed.
    """
    preloaded = _is_preloaded(law, limit.size)
    single, together = np.flatnonzero(touched & ~preloaded), touched & preloaded
    shares = {f"the limit of contact {k} is": float(limit[k] / force[k]) for k in single}
    if together.any():
        whole = float(limit[together].sum() / force[together].sum())
        shares["the sum of the limits of preloaded contacts is"] = whole
    return min(shares.items(), key=lambda each: each[1])


def _creeps(reduced: Reduced, law: Friction, amplitude: Floats) -> bool:
    """Return whether tanh contacts below their limit lose a relevant part of the energy.

    Below the limit the law is a dashpot, limit / alpha, loaded by the force 2 Re sum_j L_j a_j
    on a contact that sticks.
    """
    if not isinstance(law, Tanh):
        return False
    square = np.abs(amplitude) ** 2
    limit = limits(law, reduced.n_contacts)
    held = limit > 0.0
    force = square @ np.abs(steady_coupling(reduced)[:, held]) ** 2
    creep = 2.0 * law.alpha * float((force / limit[held]).sum())
    damping = reduced.modal_damping - reduced.aerodynamic_damping
    # A creeping tanh contact that loses a hundredth of the power of structural damping changes
    # the damping; a limit in another unit changes its power by 1e3.
    return creep > 1e-2 * 2.0 * float(damping @ (reduced.carrier**2 * square))


def _tanh_findings(
    reduced: Reduced, law: Tanh, amplitude: Floats, force: Floats, touched: Flags
) -> list[Finding]:
    """Report a velocity alpha at which contacts neither stick nor slide, or too small a one.

    It is compared with the velocity of contacts that forces (N_c,) move freely, at the carrier of
    the mode with the largest force on each contact.
    """
    moved = 2.0 * np.abs(amplitude)[:, np.newaxis] * np.abs(reduced.coupling)
    Omega = reduced.carrier[np.argmax(moved, axis=0)]
    speed = (Omega * force / np.diag(reduced.stiffness))[touched]
    if law.alpha > _BLURRED * speed.max():
        reason = (
            f"alpha = {law.alpha:g} m/s is {law.alpha / speed.max():.2g} times the velocity at "
            f"which contacts slide, more than {_BLURRED:g} times. Contacts neither stick nor "
            f"slide. Use alpha = {round_down(0.1 * speed.max()):g} m/s or less"
        )
        return [Finding("friction", _DASHPOT, reason, "warning")]
    if law.alpha < _SHARP * speed.min():
        reason = (
            f"alpha = {law.alpha:g} m/s is {law.alpha / speed.min():.1e} times the velocity at "
            f"which contacts slide, less than {_SHARP:g} times. The contact solution does not "
            "resolve it. Use Coulomb's law, the exact limit"
        )
        return [Finding("friction", "changes too sharply", reason, "warning")]
    return []
