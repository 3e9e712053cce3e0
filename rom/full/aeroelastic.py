"""A structure under the aerodynamic forces on its modes, at full order."""

from __future__ import annotations

from slipmode.rom.arrays import Floats
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.structure.matrices import as_dense
from slipmode.rom.structure.structure import Structure


def aeroelastic(
    structure: Structure, reduced: Reduced, mode_shapes: Floats | None = None
) -> Structure:
    """The structure with the aerodynamics that its reduction was given.

    Each mode adds M phi Re(c) phi^T M to the stiffness and M phi Im(c) / omega phi^T M to the
    damping, omega being the natural frequency of the structure alone.

    Parameters
    ----------
    structure : Structure
    reduced : Reduced
        Of that structure. Without `aerodynamics` the structure stays as it is.
    mode_shapes : (n, modes) ndarray, optional
        The retained modes in the coordinates of the structure, where these are not the DOFs of
        the one that was reduced.

    Returns
    -------
    Structure
        With dense matrices; it may be self-excited.
    """
    c = reduced.aerodynamics
    if c is None:
        return structure
    along = as_dense(
        structure.mass @ (reduced.mode_shapes if mode_shapes is None else mode_shapes)
    )
    return structure.with_forces(
        (along * c.real) @ along.T, (along * reduced.aerodynamic_damping) @ along.T
    )
