"""Reduction of a structure to a few modes and a contact problem of size N_c."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np

from slipmode.rom.arrays import as_floats, in_one_line
from slipmode.rom.errors import SlipmodeError, ValidityWarning, warn
from slipmode.rom.frequencies import check_table_carriers, mode_frequency_findings
from slipmode.rom.laws.contacts import Elastic
from slipmode.rom.laws.directions import skewed_directions
from slipmode.rom.progress import phases
from slipmode.rom.reduction.bonded import reduce_bonded
from slipmode.rom.reduction.force_response import ForcePatterns, forces_on_modes
from slipmode.rom.reduction.reduced import Formulation, Reduced
from slipmode.rom.reduction.structural_damping import with_structural_damping
from slipmode.rom.reduction.stuck import reduce_stuck
from slipmode.rom.reduction.tones import (
    check_tones,
    checked_ratio,
    on_one_tone,
    shared_tones,
    sliding_law,
)
from slipmode.rom.representable import ALLOWED, fits
from slipmode.rom.structure.structure import Structure

__all__ = ["Formulation", "Reduced", "reduce"]

#: Force of another mode on the contacts, relative to theirs, below which the mode follows
#: statically by default. Direct steady states are within 0.07 % of full order with it, within
#: 0.4 % with 1e-3. Tables keep the modes that their tolerance needs.
SMALLEST_RESPONSE = 1e-5


def reduce(
    structure: Structure,
    modes: Sequence[int] = (0, 1),
    formulation: Formulation = "consistent",
    carrier: Sequence[float] | None = None,
    law: Elastic | None = None,
    force_patterns: ForcePatterns | None = None,
    aerodynamics: Sequence[complex] | None = None,
    *,
    tones: Sequence[int] | None = None,
    ratio: float | None = None,
    smallest_response: float = SMALLEST_RESPONSE,
    warned: bool = True,
    progress: bool = False,
) -> Reduced:
    """Return a structure reduced to a few modes with stuck contacts, and its contact DOFs.

    Parameters
    ----------
    structure : Structure
        Structure with n DOFs and N_c contact DOFs.
    modes : sequence of int, default (0, 1)
        Modes with stuck contacts to retain, numbered from 0 as in `rom.modes`: A, or A and B; up
        to 40 modes within 15 % of each other on a tone if they share it.
    formulation : {"consistent", "paper"}
        "consistent" includes residual flexibility, inertia and damping of the contacts, and the
        nonresonant response of modes that do not follow statically. "paper" has constraint modes
        alone, without inertia and damping of the contacts, source Eqs. (13) and (20).
    carrier : sequence of float, optional
        Reference frequencies [rad/s] at which the contact problem is solved, one per mode. They
        should be near the forcing frequencies. Not allowed with "paper". Default: the natural
        frequencies.
    law : elastic law, optional
        Jenkins, Iwan, Sliders, FrictionalContact or Contacts: stuck contacts are its springs.
        Default: rigid friction (Tanh, Coulomb), whose stuck contacts are bonded.
    force_patterns : one {DOF: amplitude} or (n,) array_like per mode, optional
        Distribution of the force on each mode, in any scale. The contact problem then includes
        the quasi-static response of contacts and other modes to the forces, as in a steady state.
        Default: forces shift the effective amplitudes only.
    aerodynamics : sequence of complex, optional
        Aerodynamic influence coefficients c_j [rad^2/s^2], one per mode, for modal forces -c_j
        q_j. The real part adds the modal stiffness Re c_j. The imaginary part adds the modal
        damping Im c_j / omega_j [1/s] with the natural frequency omega_j of the structure alone. A
        mode with negative total damping is self-excited (flutter), see `rom.limit_cycles`.
    tones : sequence of int, optional
        Tone of each mode. Modes on one tone, (0, 0, 0), move under one force at its frequency;
        their frequencies may be equal. (0, 0, 0, 1, 1) has three modes under a first force and two
        under a second one. Shared tones need an elastic law without lift-off, and `rom.tabulate`
        then returns a `ToneModel`. Default: mode j is on tone j, with a force and a frequency of
        its own.
    ratio : float, optional
        Carrier of the second of two modes relative to the first, for instance 3: both are on one
        tone, whose force drives mode A, and a harmonic of the contacts drives mode B (internal
        resonance). `carrier` and `force_patterns` then have one entry. A ratio of integers up to
        9, odd ones if contacts do not lift off. Default: mode B has a tone of its own.
    smallest_response : float, default 1e-5
        Dynamic force of a mode on the contacts relative to the contact forces [-]. Modes follow
        statically from the frequency on at which harmonics of friction cause less. A table
        neglects further modes if its tolerance allows it, see `Accuracy.neglected_modes`.
    warned : bool, default True
        Warn of contact directions and implausible frequencies. A scene reports them in its plan
        instead.
    progress : bool, default False
        Print the phases of the computation and their memory on standard error.

    Returns
    -------
    Reduced
        Modes, contact matrices and couplings for `rom.tabulate` and `rom.steady_state`.

    Raises
    ------
    SlipmodeError
        If a mode does not exist, the bonded structure has rigid-body modes, or a mode has no
        positive stiffness with the aerodynamic coefficients. If a carrier is below 0.62 or above
        10 times the natural frequency of its mode.

    Warns
    -----
    ValidityWarning
        If directions of a frictional contact seem not to be orthogonal or of equal length. If the
        frequency of a mode is outside 1e-3 to 1e6 Hz.

    Examples
    --------
    >>> reduced = rom.reduce(rom.two_mass(), carrier=(0.98, 1.65))
    >>> reduced.frequency
    array([1. , 1.7])
    """
    if formulation not in get_args(Formulation):
        raise SlipmodeError(f"formulation: must be 'consistent' or 'paper', got {formulation!r}")
    chosen = _checked_modes(modes)
    shared = shared_tones(tones, len(chosen))
    if shared:
        sliding_law(law, structure.n_contacts)
    if not (shared or len(chosen) <= 2):
        raise SlipmodeError(
            f"modes: must be one or two modes with a tone each, got {in_one_line(modes)}; more "
            "modes share a tone, tones=(0, 0, ...)"
        )
    if ratio is not None and shared:
        raise SlipmodeError("ratio, tones: leave one out; modes on one tone share a carrier")
    locked = None if ratio is None else checked_ratio(ratio, len(chosen))
    if not 0 <= as_floats("smallest_response", smallest_response) <= 1:
        raise SlipmodeError(f"smallest_response: must be 0 to 1, got {smallest_response}")
    if formulation == "paper":
        if law is not None:
            raise SlipmodeError("formulation: must be 'consistent' for elastic contacts")
        given = {"force_patterns": force_patterns, "aerodynamics": aerodynamics, "ratio": ratio}
        if refused := [key for key, value in given.items() if value is not None]:
            raise SlipmodeError(f"{refused[0]}: formulation must be 'consistent'")
    if law is not None and not isinstance(law, Elastic):
        raise SlipmodeError("law: must be an elastic law; leave it out for rigid friction")
    if law is not None and warned and (skewed := skewed_directions(structure.directions, law)):
        warnings.warn(f"contacts: {skewed}", ValidityWarning, stacklevel=2)
    with phases("reduction", shown=progress):
        if law is None:
            reduced = reduce_bonded(structure, chosen, formulation, smallest_response)
        else:
            elements = law.elements(structure.n_contacts)
            reduced = reduce_stuck(structure, chosen, elements, smallest_response)
    reduced = replace(reduced, structure=structure, tone_numbers=shared)
    if shared:
        given = {"carrier": carrier, "force_patterns": force_patterns}
        given |= {"aerodynamics": aerodynamics}
        check_tones(reduced, given)
    if locked is not None:
        reduced = on_one_tone(reduced, locked, carrier)
        carrier = reduced.carrier.tolist()
    if warned:
        warn(mode_frequency_findings(reduced.mode_names, reduced.frequency))
    if aerodynamics is not None:
        reduced = _aeroelastic(reduced, aerodynamics)
    reduced = with_structural_damping(reduced, structure)
    if carrier is not None:
        reduced = reduced.at_carrier(carrier)
        check_table_carriers(reduced.frequency, reduced.carrier)
    if force_patterns is None:
        return reduced
    f = forces_on_modes(reduced, force_patterns, "force_patterns")
    return replace(reduced, force_patterns=f)


def _checked_modes(modes: Sequence[int]) -> tuple[int, ...]:
    numbers = as_floats("modes", list(modes) if np.iterable(modes) else modes)
    different = set(numbers.ravel().tolist())
    if numbers.ndim != 1 or len(different) != numbers.size or not numbers.size:
        raise SlipmodeError(f"modes: must be one or two different modes, got {in_one_line(modes)}")
    if not all(mode.is_integer() for mode in different):
        raise SlipmodeError(f"modes: must be integers, got {in_one_line(modes)}")
    return tuple(int(mode) for mode in numbers)


def _aeroelastic(reduced: Reduced, aerodynamics: Sequence[complex]) -> Reduced:
    """Return the model with modal stiffness and damping due to aerodynamic forces.

    These act along the retained modes alone, to which the other modes and the contact shapes are
    M-orthogonal.
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
