"""All claims, in the order of the paper."""

from __future__ import annotations

from collections.abc import Callable

from slipmode.runner.paper.claims import friction_claims, motion_claims, resonance_claims
from slipmode.runner.paper.claims.claim import Claim
from slipmode.runner.paper.study import Study

_CLAIMS: tuple[Callable[[Study], Claim], ...] = (
    motion_claims.fixed_interface_modes,
    motion_claims.contact_inertia,
    motion_claims.small_contact_motion,
    motion_claims.two_periods,
    motion_claims.straight_trajectories,
    motion_claims.rectangle,
    motion_claims.drifting_loop,
    motion_claims.sinusoidal_sum,
    motion_claims.forces_agree,
    motion_claims.errors_grow,
    motion_claims.contacts_agree,
    friction_claims.shift_of_mode_a,
    friction_claims.damping_of_mode_a,
    friction_claims.damping_of_mode_b,
    friction_claims.quiet_below_threshold,
    friction_claims.damping_at_one,
    friction_claims.deepest_damping,
    resonance_claims.peak_of_mode_a,
    resonance_claims.detuning_of_mode_b,
    resonance_claims.superposition,
    resonance_claims.three_numbers,
    resonance_claims.peak_of_both,
    resonance_claims.lower_than_alone,
    resonance_claims.tends_to_mode_b,
    resonance_claims.superposition_as_plotted,
    resonance_claims.superposition_in_one_norm,
    resonance_claims.dip_at_mode_b,
)


def claims(study: Study) -> list[Claim]:
    """Judge every claim."""
    return [claim(study) for claim in _CLAIMS]
