"""A blade of trilinear hexahedra of any size, with contacts on one of its faces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Floats
from slipmode.rom.full import FullMotion
from slipmode.rom.full.integration import Integrator
from slipmode.rom.laws.friction import Friction
from slipmode.rom.structure.matrices import as_dense

_E, _NU, _RHO = 2.0e11, 0.3, 7800.0  # steel [Pa], [-], [kg/m^3]
_LENGTH, _WIDTH, _THICKNESS = 0.2, 0.1, 0.008  # [m]
_ACROSS = 8  # elements through the thickness
DAMPING_RATIO = 4e-3
CYCLES, SAMPLES = 160, 16  # of a run: cycles of mode A, samples a cycle


def blade(dofs: int, contacts: int) -> dict[str, Any]:
    """Return the matrices of a blade that is clamped at one end.

    Elements of a box are products of line elements, so the matrices are sums of Kronecker
    products of the matrices of three lines, integrated exactly.

    Parameters
    ----------
    dofs : int
        Approximate number of DOFs.
    contacts : int
        Spread over one of the wide faces; each is a DOF in its plane, along the blade.

    Returns
    -------
    dict
        "mass", "stiffness" (sparse), "contact" (DOF indices).
    """
    columns = max(2, round(np.sqrt(dofs / (3 * (_ACROSS + 1) * 2))))
    cells = (2 * columns, columns, _ACROSS)
    lines = [
        _line(count, length / count)
        for count, length in zip(cells, (_LENGTH, _WIDTH, _THICKNESS), strict=True)
    ]
    gradients = {(a, b): _integral(lines, a, b) for a in range(3) for b in range(3)}
    lame = _E * _NU / ((1 + _NU) * (1 - 2 * _NU))
    shear = _E / (2 * (1 + _NU))
    laplacian = sum(gradients[a, a] for a in range(3))
    stiffness: Any = 0.0
    for (a, b), gradient in gradients.items():
        block = lame * gradient + shear * gradients[b, a] + (shear * laplacian if a == b else 0.0)
        place = scipy.sparse.csr_array(([1.0], ([a], [b])), shape=(3, 3))
        stiffness = scipy.sparse.kron(block, place, "csr") + stiffness
    mass = scipy.sparse.kron(_RHO * _integral(lines, None, None), np.eye(3), "csr")
    nodes = np.arange(mass.shape[0] // 3).reshape([count + 1 for count in cells])
    clamped = 3 * nodes[0].size
    along = max(1, round(np.sqrt(2 * contacts)))
    face = nodes[1:, :, -1]
    rows = np.linspace(0, len(face) - 1, along).astype(int)
    across = np.linspace(0, face.shape[1] - 1, -(-contacts // along)).astype(int)
    touching = face[np.ix_(rows, across)].ravel()[:contacts]
    return {
        "mass": mass[clamped:, clamped:],
        "stiffness": stiffness[clamped:, clamped:],
        "contact": 3 * touching - clamped,
    }


def _line(count: int, h: float) -> tuple[Any, Any, Any]:
    """Integrals of N_i N_j, N_i' N_j and N_i' N_j' over a line of elements of length h [m]."""
    return (
        _assembled(h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]]), count),
        _assembled(0.5 * np.array([[-1.0, -1.0], [1.0, 1.0]]), count),
        _assembled(np.array([[1.0, -1.0], [-1.0, 1.0]]) / h, count),
    )


def _assembled(element: Floats, count: int) -> Any:
    diagonal = np.full(count + 1, element[0, 0] + element[1, 1])
    diagonal[0], diagonal[-1] = element[0, 0], element[1, 1]
    below, above = np.full(count, element[1, 0]), np.full(count, element[0, 1])
    bands: Any = scipy.sparse.diags_array([below, diagonal, above], offsets=[-1, 0, 1])
    return scipy.sparse.csr_array(bands)


def _integral(lines: list[tuple[Any, Any, Any]], a: int | None, b: int | None) -> Any:
    """Integral of dN_i/dx_a dN_j/dx_b over the box; N itself where the axis is None."""
    product: Any = np.eye(1)
    for axis, (plain, slope, slopes) in enumerate(lines):
        if axis == a == b:
            factor = slopes
        elif axis == a:
            factor = slope
        elif axis == b:
            factor = slope.T
        else:
            factor = plain
        product = scipy.sparse.kron(product, factor, "csr")
    return product


class DenseCase(NamedTuple):
    """A structure of few DOFs, forced beside one or two of its modes, all of which slip."""

    name: str
    structure: rom.Structure
    reduced: rom.Reduced
    law: Friction | rom.Jenkins
    force: tuple[Floats, ...]
    frequency: tuple[float, ...]

    def times(self, cycles: int = CYCLES) -> Floats:
        """Return the times of 16 samples a cycle of mode A [s]."""
        period = 2.0 * np.pi / self.frequency[0]
        return np.asarray(period / SAMPLES * np.arange(1, cycles * SAMPLES + 1))

    def integrated(self, steps: int, cycles: int = CYCLES) -> Callable[[], FullMotion]:
        """Prepare full order from rest; it yields displacements of the retained modes."""
        excitation = full.Excitation.harmonic(self.structure, self.force, self.frequency)
        rows = self.reduced.mode_shapes.T @ as_dense(self.structure.mass)
        integrator = Integrator(self.structure, self.law, excitation, rows, steps_per_period=steps)
        return lambda: integrator.run(self.times(cycles))


def jenkins_blade(
    contacts: int,
    *,
    dofs: int = 3000,
    modes: int = 2,
    coordinates: int | None = None,
    stiffness: float = 1e8,
    slipping: float = 0.15,
) -> DenseCase:
    """Return a blade with Jenkins contacts on component modes; most contacts slip at resonance.

    Parameters
    ----------
    modes : int
        1 or 2; mode B is forced to half the amplitude of mode A.
    coordinates : int, optional
        How many the component modes have. Default: as many as seven harmonics need.
    stiffness : float
        k_t of a contact [N/m].
    slipping : float
        Friction limit over the median contact force of the stuck structure at its peaks.
    """
    matrices, stuck = blade(dofs, contacts), rom.Jenkins(1.0, stiffness)
    retained = tuple(range(modes))
    omega = rom.reduce(rom.Structure(**matrices, damping=0.0), retained, law=stuck).frequency
    damping = (
        rom.Rayleigh.from_ratios([DAMPING_RATIO] * 2, omega.tolist())
        if modes == 2
        else 2.0 * DAMPING_RATIO / float(omega[0])
    )
    structure = rom.Structure(**matrices, damping=damping)
    tip = np.zeros(structure.n_dofs)
    tip[-1] = 1.0
    count = None if coordinates is None else coordinates - contacts - 1
    small = full.component_modes(structure, stuck, [tip], 7.0 * float(omega[-1]), modes=count)
    pattern = tip @ small.projection.basis
    amplitude = np.abs(pattern[:modes]) / (2.0 * DAMPING_RATIO * omega**2)
    sizes = amplitude[0] / amplitude * np.array([1.0, 0.5])[:modes]
    directions = np.abs(as_dense(small.structure.directions)[:modes])
    moved = (directions * (amplitude * sizes)[:, np.newaxis]).sum(axis=0)
    law = rom.Jenkins(slipping * stiffness * float(np.median(moved)), stiffness)
    force = tuple(pattern * size for size in sizes)
    reduced = rom.reduce(small.structure, retained, law=law, force_patterns=force)
    frequency = tuple((0.99 * omega).tolist())
    return DenseCase(f"blade, {contacts} Jenkins", small.structure, reduced, law, force, frequency)
