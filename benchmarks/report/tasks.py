"""What the report measures, in which order: each task makes one section."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from benchmarks import cases
from benchmarks.cases import Case, Chain
from benchmarks.peers import first_order
from benchmarks.report import friction, signals, steady
from benchmarks.report.sections import Row, Section

Task = Callable[[], Section]

_STEADY_SETTINGS = ((0.25, 1e-2), (0.25, 1e-4))  # step [s], change from window to window
_CRAIG_BAMPTON_MODES = (2, 4, 8)


@dataclass(frozen=True)
class Scope:
    """How much is measured."""

    tables: tuple[float, ...]  # tolerances; other methods are compared with the second
    flows: tuple[tuple[float, float], ...]  # communication step [s], tolerance of the slow flow
    refinements: tuple[int, ...]  # full-order steps per sample
    tolerances: tuple[float, ...]  # of LSODA and CVODE
    harmonics: tuple[int, ...]  # of harmonic balance
    steady: slice  # of the steady cases
    surface: int  # frequencies along each axis of a resonance surface
    grids: tuple[int, ...]  # points per period of the paper's scheme
    torus: tuple[tuple[int, int, float], ...]  # our steps, lines, and periodicity of harmonics
    points: int  # amplitude pairs of the friction functions
    alphas: tuple[float, ...]  # of the friction functions [m/s]
    signals: tuple[Callable[[], Case], ...]  # cases with every method
    chains: tuple[Callable[[], Case], ...]  # cases with full order and Craig-Bampton
    structures: tuple[Callable[[], Case], ...]  # cases for accuracy alone


_COARSE_TORUS = ((32, 8, 5e-3), (64, 16, 5e-3), (96, 16, 1e-3), (128, 16, 3e-4))

FULL = Scope(
    tables=(1e-2, 3e-3, 1e-3),
    flows=((20.0, 1e-4), (20.0, 1e-6), (1.0, 1e-6)),
    refinements=(1, 2, 3, 4, 8, 16),
    tolerances=(1e-3, 1e-4, 1e-5, 1e-6),
    harmonics=(1, 3, 5, 7, 11, 15, 21, 31),
    steady=slice(None),
    surface=21,
    grids=(50, 100, 200, 400, 800),
    torus=(*_COARSE_TORUS, (256, 32, 1e-4), (512, 32, 3e-5)),
    points=48,
    alphas=(0.02, 0.005),
    signals=(cases.two_mode, cases.near_commensurate, partial(cases.with_alpha, 0.005)),
    chains=(Chain(50).case, Chain(200).case, partial(Chain(200).case, modal_damping=False)),
    structures=(
        cases.six_dofs_three_contacts,
        cases.general_damping,
        cases.coulomb,
        partial(cases.with_alpha, 0.005),
        partial(cases.with_alpha, 0.1),
        cases.shared_forces,
        partial(Chain(50).case, point_forces=True),
    ),
)

QUICK = Scope(
    tables=(1e-2, 3e-3),
    flows=((20.0, 1e-4), (1.0, 1e-6)),
    refinements=(1, 2, 3, 4),
    tolerances=(1e-3, 1e-5),
    harmonics=(3, 7, 11),
    steady=slice(0, 5, 2),
    surface=11,
    grids=(50, 100),
    torus=_COARSE_TORUS,
    points=16,
    alphas=(0.005,),
    signals=(cases.two_mode,),
    chains=(Chain(50).case,),
    structures=(cases.six_dofs_three_contacts, cases.coulomb, cases.shared_forces),
)


def speed_tasks(scope: Scope) -> list[Task]:
    """Return the tasks of speed against error."""
    return [
        *(partial(_signals, make, scope) for make in scope.signals),
        partial(_steady, scope),
        *(partial(_friction, alpha, scope) for alpha in scope.alphas),
        *(partial(_chain, make, scope) for make in scope.chains),
    ]


def accuracy_tasks(scope: Scope) -> list[Task]:
    """Return the tasks of accuracy on other structures."""
    return [partial(_accuracy, make, scope) for make in scope.structures]


def _signals(make: Callable[[], Case], scope: Scope) -> Section:
    reference = signals.Reference.of(make())

    def rows() -> Iterator[Row]:
        yield from signals.slow_rows(reference, scope.tables, scope.flows)
        yield from signals.slow_rows(reference, scope.tables[-1:], scope.flows[:1], "paper")
        yield from signals.full_rows(reference, scope.refinements)
        peers = {"LSODA": first_order.lsoda}
        if first_order.HAS_CVODE:
            peers["CVODE"] = first_order.cvode
        for name, integrate in peers.items():
            yield from signals.first_order_rows(reference, name, integrate, scope.tolerances)

    return signals.section(reference, list(rows()), scope.tables[1], scope.flows)


def _chain(make: Callable[[], Case], scope: Scope) -> Section:
    reference, refinements = signals.Reference.of(make()), scope.refinements[:4]

    def rows() -> Iterator[Row]:
        yield from signals.slow_rows(reference, scope.tables[:2], scope.flows)
        yield from signals.full_rows(reference, refinements)
        yield from signals.craig_bampton_rows(reference, _CRAIG_BAMPTON_MODES, refinements)

    return signals.section(reference, list(rows()), scope.tables[1], scope.flows)


def _steady(scope: Scope) -> Section:
    reference = steady.SteadyReference.of(cases.steady_cases()[scope.steady])

    def rows() -> Iterator[Row]:
        yield from steady.slow_rows(reference, scope.tables, scope.surface)
        yield from steady.slow_rows(reference, scope.tables[-1:], scope.surface, "paper")
        yield from steady.full_rows(reference, _STEADY_SETTINGS)
        yield from steady.balance_rows(reference, scope.harmonics)

    return steady.section(reference, list(rows()), scope.tables[1])


def _friction(alpha: float, scope: Scope) -> Section:
    reference = friction.FrictionReference(alpha, scope.points)
    rows = friction.friction_rows(reference, scope.torus, scope.grids)
    return friction.section(reference, list(rows))


def _accuracy(make: Callable[[], Case], scope: Scope) -> Section:
    return signals.accuracy_section(make(), scope.tables[1], scope.refinements[:4])
