"""From the structure's matrices to modal coordinates and a contact problem of size N_c."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np
import scipy.linalg

from slipmode.rom.arrays import Complexes, Floats, as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError, ValidityWarning, warn
from slipmode.rom.frequencies import check_table_carriers, mode_frequency_findings
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.directions import skewed_directions
from slipmode.rom.progress import phases
from slipmode.rom.reduction.fixed_interface import fixed_interface_modes
from slipmode.rom.reduction.force_response import ForcePatterns
from slipmode.rom.reduction.nonresonant import (
    highest_response,
    no_nonresonant_modes,
    nonresonant_modes,
)
from slipmode.rom.reduction.reduced import Formulation, Reduced, force_vector, force_vectors
from slipmode.rom.reduction.stuck import reduce_stuck
from slipmode.rom.representable import ALLOWED, fits
from slipmode.rom.structure.held import bonded as hold_bonded
from slipmode.rom.structure.matrices import as_dense, projection
from slipmode.rom.structure.solvers.definiteness import is_positive_definite
from slipmode.rom.structure.solvers.mobility import mobility
from slipmode.rom.structure.structure import Structure

__all__ = ["Complexes", "Formulation", "Reduced", "force_vector", "reduce"]

#: Force of another mode on the contacts that counts, relative to theirs, by default. Direct steady
#: states are within 0.07 % of full order so, and within 0.4 % at 1e-3; tables take the modes that
#: their tolerance needs.
SMALLEST_RESPONSE = 1e-5

_ROUNDING = 1e-9  # of a matrix entry, relative to the diagonal: no coupling, no inertia


def reduce(
    structure: Structure,
    modes: Sequence[int] = (0, 1),
    formulation: Formulation = "consistent",
    carrier: Sequence[float] | None = None,
    law: Elastic | None = None,
    force_patterns: ForcePatterns | None = None,
    aerodynamics: Sequence[complex] | None = None,
    *,
    smallest_response: float = SMALLEST_RESPONSE,
    warned: bool = True,
    progress: bool = False,
) -> Reduced:
    """Project a structure on one or two modes with stuck contacts, and its contacts.

    Parameters
    ----------
    structure : Structure
    modes : sequence of one or two int
        Modes to retain, of those with stuck contacts: A, or A and B.
    formulation : {"consistent", "paper"}
        "paper": constraint modes alone, damping and inertia of the contacts neglected,
        Eqs. (13), (20). "consistent": residual flexibility of the modes that are not retained,
        inertia and damping of the contacts, the nonresonant response to them of these modes and
        of all others that move differently from what they would statically.
    carrier : sequence of float, optional
        Frequencies at which the contact problem is solved [rad/s], one per mode; the nearer to
        the forcing the better. Not with "paper". Default: the natural frequencies.
    law : elastic law, optional
        Jenkins, Iwan, Sliders, FrictionalContact or Contacts: stuck contacts are its springs.
        Default: rigid friction (Tanh, Coulomb), whose stuck contacts are bonded.
    force_patterns : one {DOF: amplitude} or (n,) array_like per mode, optional
        Where the forces act, as in `fmu.Component`: what they do to the contacts past their own
        mode is in the contact problem then, as it is in a steady state. Default: it only shifts
        the amplitudes (`off_resonance_shift`).
    aerodynamics : sequence of complex, optional
        Aerodynamic influence coefficients c_j [rad^2/s^2], one per mode: a modal force
        -c_j q_j while q_j moves at the natural frequency omega_j of the structure alone. The
        real part is a stiffness, the imaginary part the damping Im c_j / omega_j [1/s], both kept
        at other frequencies. A mode whose damping that makes negative is self-excited (flutter):
        see `limit_cycles`.
    smallest_response : float
        Force of another mode on the contacts, relative to theirs, below which the mode follows
        statically. A table takes fewer modes, as many as its tolerance needs, and states the error
        due to the others (`Accuracy.neglected_modes`).
    warned : bool
        Warn of contact directions and implausible frequencies; a scene has these warnings in its
        plan instead.
    progress : bool, default False
        Whether to say on standard error what a large structure is at, and the memory it takes.

    Raises
    ------
    SlipmodeError
        If a mode does not exist, the bonded structure can move without deforming,
        aerodynamics take away all stiffness of a mode, or a carrier is below 0.62 or above 10
        times the frequency of its mode.

    Warns
    -----
    ValidityWarning
        Where directions of a frictional contact seem not to be at right angles or equally long,
        or the frequency of a mode is outside 1e-3 to 1e6 Hz.
    """
    if formulation not in get_args(Formulation):
        raise SlipmodeError(f"formulation: must be 'consistent' or 'paper', got {formulation!r}")
    numbers = as_floats("modes", list(modes) if np.iterable(modes) else modes)
    chosen = set(numbers.ravel().tolist())
    if numbers.ndim != 1 or len(chosen) != numbers.size or numbers.size not in (1, 2):
        raise SlipmodeError(f"modes: must be one or two different modes, got {in_one_line(modes)}")
    if not all(mode.is_integer() for mode in chosen):
        raise SlipmodeError(f"modes: must be integers, got {in_one_line(modes)}")
    modes = tuple(int(mode) for mode in numbers)
    if not 0 <= as_floats("smallest_response", smallest_response) <= 1:
        raise SlipmodeError(f"smallest_response: must be 0 to 1, got {smallest_response}")
    if law is not None:
        if formulation == "paper":
            raise SlipmodeError("formulation: must be 'consistent' for elastic contacts")
        if not isinstance(law, Elastic):
            raise SlipmodeError("law: is that of elastic contacts; leave it out for rigid ones")
        elements = law.elements(structure.n_contacts)
        if warned and (skewed := skewed_directions(structure.directions, law)):
            warnings.warn(f"contacts: {skewed}", ValidityWarning, stacklevel=2)
        with phases("reduction", shown=progress):
            reduced = reduce_stuck(structure, modes, elements, smallest_response)
    else:
        if formulation == "paper" and force_patterns is not None:
            raise SlipmodeError("force_patterns: formulation must be 'consistent'")
        if formulation == "paper" and aerodynamics is not None:
            raise SlipmodeError("aerodynamics: formulation must be 'consistent'")
        with phases("reduction", shown=progress):
            reduced = _reduce_bonded(structure, modes, formulation, smallest_response)
    if warned:
        warn(mode_frequency_findings("AB", reduced.frequency))
    return _specified(reduced, carrier, force_patterns, aerodynamics)


def _reduce_bonded(
    structure: Structure,
    modes: tuple[int, ...],
    formulation: Formulation,
    smallest_response: float,
) -> Reduced:
    """About the structure whose contacts are bonded."""
    n_elastic = structure.n_dofs - structure.n_contacts
    if not all(0 <= mode < n_elastic for mode in modes):
        raise SlipmodeError(f"modes: must be 0 to {n_elastic - 1}, got {modes}")
    reach = highest_response(1.0) if formulation == "consistent" else 0.0
    omega, shapes = fixed_interface_modes(structure, max(modes) + 1, reach)
    omega, shapes = omega[list(modes)], shapes[:, list(modes)]
    R = structure.partition().R
    constraint_modes = hold_bonded(structure).solve(-(structure.stiffness @ R))
    constraint_modes += as_dense(R)
    if formulation == "paper":
        return _reduce_paper(structure, modes, omega, shapes, constraint_modes)
    return _reduce_consistent(structure, modes, omega, shapes, constraint_modes, smallest_response)


def _specified(
    reduced: Reduced,
    carrier: Sequence[float] | None,
    patterns: ForcePatterns | None,
    aerodynamics: Sequence[complex] | None,
) -> Reduced:
    """With the aerodynamics, the frequencies and the force patterns that it is asked for."""
    if aerodynamics is not None:
        reduced = _aeroelastic(reduced, aerodynamics)
    if carrier is not None:
        reduced = reduced.at_carrier(carrier)
        check_table_carriers(reduced.frequency, reduced.carrier)
    if patterns is None:
        return reduced
    f = force_vectors(patterns, len(reduced.modes), reduced.n_dofs, "force_patterns")
    return replace(reduced, force_patterns=f)


def _aeroelastic(reduced: Reduced, aerodynamics: Sequence[complex]) -> Reduced:
    """With modal stiffness and damping by aerodynamic forces.

    Nothing else changes: they act along the retained modes alone, to which the other modes and
    the contact shapes are M-orthogonal.
    """
    omega = reduced.frequency
    given = np.asarray(aerodynamics)
    numbers = given.dtype.kind in "iufc" and given.shape == omega.shape
    if not (numbers and np.isfinite(given).all() and fits(float(np.abs(given).max()))):
        raise SlipmodeError(
            f"aerodynamics: must be {omega.size} finite complex numbers, one per mode "
            f"[rad^2/s^2], {ALLOWED}, got {aerodynamics}"
        )
    c = given.astype(complex)
    if np.any(c.real <= -(omega**2)):
        j = int(np.argmin(c.real + omega**2))
        raise SlipmodeError(
            f"aerodynamics: the real part for mode {'AB'[j]} must be above -omega^2 = "
            f"{-(omega[j] ** 2):g}, or the mode diverges; got {c[j].real:g}"
        )
    frequency = np.sqrt(omega**2 + c.real)
    return replace(
        reduced,
        frequency=frequency,
        carrier=frequency,
        modal_damping=reduced.modal_damping + c.imag / omega,
        aerodynamics=c,
    )


def _reduce_paper(
    structure: Structure,
    modes: tuple[int, ...],
    omega: Floats,
    Phi: Floats,
    constraint_modes: Floats,
) -> Reduced:
    """Eqs. (13) and (20): K_xx = K_cc - K_ce K_ee^-1 K_ec, coupling K_ce phi, and no more."""
    K = structure.stiffness
    parts = structure.partition()
    stiffness = _symmetric(projection(constraint_modes, K, as_dense(parts.R)))
    spring = projection(Phi, K, as_dense(parts.R))
    nothing = np.zeros_like(stiffness)
    _check_stiffness(stiffness)
    return Reduced(
        formulation="paper",
        modes=modes,
        frequency=omega,
        carrier=omega,
        modal_damping=np.diag(projection(Phi, structure.damping, Phi)).copy(),
        mode_shapes=Phi,
        contact_shapes=constraint_modes,
        mass=nothing,
        damping=nothing,
        stiffness=stiffness,
        spring=spring,
        damper=np.zeros_like(spring),
        contact_motion=_frictionless(stiffness, spring),
        **no_nonresonant_modes(len(modes), *constraint_modes.shape),
    )


def _reduce_consistent(
    structure: Structure,
    modes: tuple[int, ...],
    omega: Floats,
    Phi: Floats,
    constraint_modes: Floats,
    smallest_response: float,
) -> Reduced:
    """Constraint modes made M-orthogonal to the retained modes.

    What the retained modes carry statically is then not counted twice (residual flexibility),
    and they couple to the contacts through stiffness and damping alone.
    """
    M, C, K = structure.mass, structure.damping, structure.stiffness
    X = constraint_modes
    X -= Phi @ projection(Phi, M, X)
    stiffness = _symmetric(projection(X, K, X))
    _check_stiffness(stiffness)
    spring = projection(Phi, K, X)
    nonresonant_omega, nonresonant = nonresonant_modes(
        structure, modes, omega, X, stiffness, smallest_response
    )
    every = np.hstack((Phi, nonresonant))
    modal_damping = projection(every, C, every)
    follows = _symmetric(projection(X, M, X))
    mass = _impact_mass(structure)
    return Reduced(
        formulation="consistent",
        modes=modes,
        frequency=omega,
        carrier=omega,
        modal_damping=np.diag(modal_damping)[: len(modes)].copy(),
        mode_shapes=Phi,
        contact_shapes=X,
        mass=mass,
        damping=_symmetric(projection(X, C, X)),
        stiffness=stiffness,
        spring=spring,
        damper=projection(Phi, C, X),
        contact_motion=_frictionless(stiffness, spring),
        carried_mass=_without_rounding(follows - mass, np.diag(follows)),
        nonresonant_frequency=nonresonant_omega,
        nonresonant_damping=np.diag(modal_damping)[len(modes) :].copy(),
        nonresonant_shapes=nonresonant,
        nonresonant_spring=np.zeros((nonresonant.shape[1], len(stiffness))),
        nonresonant_inertia=projection(nonresonant, M, X),
        nonresonant_damper=projection(nonresonant, C, X),
        damping_coupling=_without_rounding(
            _symmetric(modal_damping) - np.diag(np.diag(modal_damping)), np.diag(modal_damping)
        ),
    )


def _check_stiffness(stiffness: Floats) -> None:
    """Refuse contacts that nothing but friction holds, (N_c, N_c)."""
    if not is_positive_definite(stiffness):
        raise SlipmodeError(
            "stiffness: must be positive definite for motion of the contacts, or they slip away"
        )


def _frictionless(stiffness: Floats, spring: Floats) -> Complexes:
    """How far each mode would draw the contacts without friction or inertia, (modes, N_c)."""
    return np.asarray(-np.linalg.solve(stiffness, spring.T).T, dtype=complex)


def _impact_mass(structure: Structure) -> Floats:
    """(W^T M^-1 W)^-1, (N_c, N_c): what the contacts move while nothing else has time to."""
    return _symmetric(scipy.linalg.inv(mobility(structure.mass, structure.directions)))


def _without_rounding(matrix: Floats, scale: Floats) -> Floats:
    """The matrix with entries set to 0 that are rounding against diagonal entries (n,)."""
    size = np.sqrt(np.abs(np.outer(scale, scale)))
    return np.where(np.abs(matrix) <= _ROUNDING * size, 0.0, matrix)


def _symmetric(matrix: Floats) -> Floats:
    return 0.5 * (matrix + matrix.T)
