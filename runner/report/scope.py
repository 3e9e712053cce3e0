"""How much is measured: everything, or a quick look."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from slipmode.runner.report.cases import cases
from slipmode.runner.report.cases.cases import Case


@dataclass(frozen=True)
class Scope:
    """Settings of every method.

    Attributes
    ----------
    tables : tuple of float
        Tolerances of the friction tables.
    flows : tuple of (float, float)
        Communication step [s] and tolerance of the slow flow.
    refinements : tuple of int
        Full-order steps per sample.
    tolerances : tuple of float
        Of LSODA and CVODE.
    slow_tolerances : tuple of float
        Of the integrators that step in Python: Radau and BDF.
    harmonics : tuple of int
        Of the harmonic balance.
    steady : tuple of int
        Which steady cases.
    surface : int
        Frequencies along each axis of a resonance surface.
    grids : tuple of int
        Points per period of the paper's scheme.
    torus : tuple of (int, int, float)
        Steps and lines of ours, and how closely harmonics repeat when a march ends.
    points : int
        Amplitude pairs at which friction functions are compared.
    alphas : tuple of float
        Sharpnesses of friction for the friction functions [m/s].
    signals : tuple of callables
        Cases with every peer.
    chains : tuple of callables
        Cases with the full order and Craig-Bampton alone.
    structures : tuple of callables
        Cases in which accuracy is checked.
    """

    tables: tuple[float, ...]
    flows: tuple[tuple[float, float], ...]
    refinements: tuple[int, ...]
    tolerances: tuple[float, ...]
    slow_tolerances: tuple[float, ...]
    harmonics: tuple[int, ...]
    steady: tuple[int, ...]
    surface: int
    grids: tuple[int, ...]
    torus: tuple[tuple[int, int, float], ...]
    points: int
    alphas: tuple[float, ...]
    signals: tuple[Callable[[], Case], ...]
    chains: tuple[Callable[[], Case], ...]
    structures: tuple[Callable[[], Case], ...]


def _chain_50() -> Case:
    return cases.chain(50)


def _chain_200() -> Case:
    return cases.chain(200)


def _damped_chain_200() -> Case:
    return cases.chain(200, modal_damping=False)


def _point_forced_chain_50() -> Case:
    return cases.point_forced_chain(50)


FULL = Scope(
    tables=(1e-2, 3e-3, 1e-3),
    flows=((20.0, 1e-4), (20.0, 1e-6), (1.0, 1e-6)),
    refinements=(1, 2, 3, 4, 8, 16),
    tolerances=(1e-3, 1e-4, 1e-5, 1e-6),
    slow_tolerances=(1e-3, 1e-4),
    harmonics=(1, 3, 5, 7, 11, 15, 21, 31),
    steady=(0, 1, 2, 3, 4, 5, 6),
    surface=41,
    grids=(50, 100, 200, 400, 800),
    torus=(
        *((32, 8, 5e-3), (64, 16, 5e-3), (96, 16, 1e-3), (128, 16, 3e-4)),
        *((256, 32, 1e-4), (512, 32, 3e-5)),
    ),
    points=48,
    alphas=(0.02, 0.005),
    signals=(cases.two_mode, cases.near_commensurate, cases.sharp),
    chains=(_chain_50, _chain_200, _damped_chain_200),
    structures=(
        cases.six_dofs_three_contacts,
        cases.general_damping,
        cases.coulomb,
        cases.sharp,
        cases.blunt,
        cases.shared_forces,
        _point_forced_chain_50,
    ),
)

QUICK = Scope(
    tables=(1e-2, 3e-3),
    flows=((20.0, 1e-4), (1.0, 1e-6)),
    refinements=(1, 2, 3, 4),
    tolerances=(1e-3, 1e-5),
    slow_tolerances=(),
    harmonics=(3, 7, 11),
    steady=(0, 2, 4),
    surface=21,
    grids=(50, 100),
    torus=((32, 8, 5e-3), (64, 16, 5e-3), (96, 16, 1e-3), (128, 16, 3e-4)),
    points=16,
    alphas=(0.005,),
    signals=(cases.two_mode,),
    chains=(_chain_50,),
    structures=(cases.six_dofs_three_contacts, cases.coulomb, cases.shared_forces),
)
