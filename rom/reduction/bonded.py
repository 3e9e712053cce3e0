"""Reduction about the structure with bonded contacts, Eqs. (8), (13) and (20)."""

from __future__ import annotations

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.reduction.nonresonant import (
    MOST_MODES,
    StuckModes,
    static_from,
    symmetric,
    without_rounding,
)
from slipmode.rom.reduction.reduced import Formulation, Reduced
from slipmode.rom.structure.held import bonded, bonded_mode_count
from slipmode.rom.structure.matrices import as_dense, projection
from slipmode.rom.structure.solvers.mass import contact_mass, is_positive_definite
from slipmode.rom.structure.structure import Structure


def reduce_bonded(
    structure: Structure,
    modes: tuple[int, ...],
    formulation: Formulation,
    smallest_response: float,
) -> Reduced:
    """Return one or two modes with bonded contacts, and contacts with rigid friction."""
    n_elastic = bonded_mode_count(structure)
    if n_elastic == 0:
        raise SlipmodeError(
            f"contact: all {structure.n_modes} DOFs are contacts, so there is no mode with rigid "
            "friction (Tanh, Coulomb); use an elastic law, rom.reduce(..., law=law)"
        )
    if not all(0 <= mode < n_elastic for mode in modes):
        raise SlipmodeError(f"modes: must be 0 to {n_elastic - 1}, got {modes}")
    held = bonded(structure)
    paper = formulation == "paper"
    omega, shapes = held.modes(
        max(modes) + 1, MOST_MODES, 0.0 if paper else static_from(smallest_response)
    )
    R = structure.partition().R
    constraint_modes = held.solve(-(structure.stiffness @ R))
    constraint_modes += as_dense(R)
    found = StuckModes(structure, omega, shapes, modes)
    if paper:
        return _reduce_paper(found, constraint_modes, as_dense(R))
    return _reduce_consistent(found, constraint_modes)


def _reduce_paper(found: StuckModes, constraint_modes: Floats, R: Floats) -> Reduced:
    """Eqs. (13) and (20): K_xx = K_cc - K_ce K_ee^-1 K_ec, coupling K_ce phi, nothing else."""
    K = found.structure.stiffness
    modes = found.arrays(constraint_modes, np.zeros(found.frequency.size, dtype=bool))
    stiffness = symmetric(projection(constraint_modes, K, R))
    spring = projection(modes["mode_shapes"], K, R)
    _check_stiffness(stiffness)
    nothing = np.zeros_like(stiffness)
    changed = {
        "formulation": "paper",
        "damping": nothing,
        "damper": np.zeros_like(spring),
        "damping_coupling": np.zeros((len(spring), len(spring))),
    }
    return Reduced(
        **(modes | changed),
        mass=nothing,
        stiffness=stiffness,
        spring=spring,
        contact_motion=_frictionless(stiffness, spring),
        carried_mass=nothing,
        nonresonant_spring=np.zeros((0, len(stiffness))),
    )


def _reduce_consistent(found: StuckModes, constraint_modes: Floats) -> Reduced:
    """Return modes and constraint modes that are M-orthogonal to the retained modes.

    The static response of the retained modes is then not counted twice (residual flexibility), and
    they couple to the contacts through stiffness and damping alone.
    """
    M, K = found.structure.mass, found.structure.stiffness
    retained = list(found.retained)
    Phi = found.shapes[:, retained]
    X = constraint_modes
    X -= Phi @ projection(Phi, M, X)
    stiffness = symmetric(projection(X, K, X))
    _check_stiffness(stiffness)
    spring = projection(Phi, K, X)
    nonresonant = np.ones(found.frequency.size, dtype=bool)
    nonresonant[retained] = False
    # A blow at the contacts moves this mass while nothing else has time to follow.
    mass = symmetric(contact_mass(M, found.structure.massless, found.structure.directions))
    follows = symmetric(projection(X, M, X))
    return Reduced(
        **found.arrays(X, nonresonant),
        mass=mass,
        stiffness=stiffness,
        spring=spring,
        contact_motion=_frictionless(stiffness, spring),
        carried_mass=without_rounding(follows - mass, np.diag(follows)),
        nonresonant_spring=np.zeros((int(nonresonant.sum()), len(stiffness))),
    )


def _check_stiffness(stiffness: Floats) -> None:
    """Refuse contacts that nothing but friction holds, (N_c, N_c)."""
    if not is_positive_definite(stiffness, "stiffness"):
        raise SlipmodeError(
            "stiffness: must be positive definite for motion of the contacts; otherwise they "
            "drift without bound"
        )


def _frictionless(stiffness: Floats, spring: Floats) -> Complexes:
    """Return the motion of the contacts per modal amplitude without friction, (modes, N_c)."""
    return np.asarray(-np.linalg.solve(stiffness, spring.T).T, dtype=complex)
