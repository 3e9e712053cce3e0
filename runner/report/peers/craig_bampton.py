"""The classical reduction before time integration: a few bonded modes and constraint modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.fixed_interface import fixed_interface_modes
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.cases.cases import Case


def craig_bampton(case: Case, modes: int) -> tuple[Case, Floats]:
    """The case in the coordinates of Craig and Bampton.

    Returns
    -------
    case : Case
        With modes + N_c coordinates, contacts last.
    basis : (n, modes + N_c) ndarray
        x = basis y.
    """
    parts = case.structure.partition()
    _, shapes = fixed_interface_modes(case.structure, modes)
    static = -np.linalg.solve(as_dense(parts.K_ee), parts.K_ec)
    basis = np.hstack([shapes, as_dense(parts.R) + as_dense(parts.E @ static)])
    M, C, K = (
        0.5 * (projected + projected.T)
        for matrix in (case.structure.mass, case.structure.damping, case.structure.stiffness)
        for projected in (basis.T @ as_dense(matrix @ basis),)
    )
    contacts = range(modes, basis.shape[1])
    structure = rom.Structure(M, K, C, contact=tuple(contacts))
    force = tuple(basis.T @ pattern for pattern in case.excitation.patterns)
    return replace(case, structure=structure, force=force), basis
