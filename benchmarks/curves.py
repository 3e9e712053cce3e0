"""Response curves beside harmonic balance with continuation: make bench-curves.

Both follow the same curve with as many points, each at the least effort that keeps it within 0.5 %
of the curve of far more harmonics. Harmonic balance proceeds from frequency to frequency, its
initial guess extrapolated from the last two solutions; it is condensed to the contacts, and large
structures are reduced to component modes for it. Seconds are of the processor, with BLAS on one
thread.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.sparse

from benchmarks.blade import blade
from benchmarks.cases import Case, two_mode
from benchmarks.measure import one_thread, processor_time
from benchmarks.peers.hbm import HarmonicBalance
from benchmarks.slow_case import steady_displacement
from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.slow.branches.forced import LARGEST_STEP
from slipmode.rom.structure.matrices import as_dense

_POINTS = 250  # of a curve
_TURNS = 5  # of which the median counts, of table and curve
_TOLERANCE = 1e-2  # of tables: 0.2 to 0.4 % in amplitude
# The fewest within 0.5 %: 13 are 0.58 % off 27 harmonics, on the blade 21 are 0.62 % off 61.
_TWO_MODE_HARMONICS, _BLADE_HARMONICS = 15, 25


@dataclass(frozen=True, eq=False)
class Compared:
    """A curve of mode A, with mode B beside it where there are two.

    `reduced` is the case that harmonic balance solves if it is another, and its displacements of
    the observed DOFs, (modes, DOFs).
    """

    case: Case  # its frequencies are the carriers of the table; the frequency of mode A varies
    span: tuple[float, float]  # [rad/s]
    amplitude: tuple[float, ...]  # range of the table [kg^1/2 m]
    harmonics: int  # of harmonic balance
    reduced: tuple[Case, Floats] | None = None


def two_masses() -> Compared:
    """Return the two-mode scene: A through its resonance, B beside its own."""
    return Compared(two_mode(), (0.94, 1.02), (4.0, 2.0), _TWO_MODE_HARMONICS)


def blade_on_springs(dampers: int) -> Compared:
    """Return a blade of 3000 DOFs with dampers on some nodes, each behind a spring."""
    parts = blade(3000, 2 * dampers)
    n, nodes = parts["mass"].shape[0], parts["contact"][dampers:] + 2  # halfway, out of its plane
    spring = 4e4 / dampers * np.ones(dampers)  # [N/m]
    tie = scipy.sparse.csr_array((spring, (nodes, np.arange(dampers))), shape=(n, dampers))
    springs = scipy.sparse.csr_array((spring, (nodes, nodes)), shape=(n, n))
    K = scipy.sparse.block_array(
        [[parts["stiffness"] + springs, -tie], [-tie.T, scipy.sparse.diags_array(spring)]]
    )
    M = scipy.sparse.block_diag((parts["mass"], 1e-6 * scipy.sparse.eye_array(dampers)), "csr")
    structure = rom.Structure(M, K.tocsr(), 1e-6, contact=list(range(n, n + dampers)))
    tip, force = n - 1, 1.5  # [N]
    omega = float(rom.reduce(structure, (0,)).frequency[0])
    law = rom.Tanh(limit=2.0 / dampers, alpha=1e-2)
    name = f"blade, {dampers} dampers"
    case = Case(name, structure, law, ({tip: force},), (omega,), observed=(tip,))
    span = 0.99 * omega, 1.01 * omega
    modes = full.component_modes(structure, law, case.force, 7.0 * span[1])
    basis = as_dense(modes.projection.basis)
    peer = replace(case, structure=modes.structure, force=(force * basis[tip],), observed=(0,))
    return Compared(case, span, (4e-4,), _BLADE_HARMONICS, (peer, basis[[tip]]))


def balanced(compared: Compared, span: Floats) -> Iterator[Complexes]:
    """Yield the carriers (modes,) by harmonic balance at successive frequencies."""
    before: list[Complexes] = []
    case = compared.case
    observed = np.eye(case.structure.n_dofs)[list(case.observed)]
    peer, rows = compared.reduced or (case, observed)
    balance = HarmonicBalance(peer, compared.harmonics)
    for Omega in span:
        start = None if len(before) < 2 else 2.0 * before[-1] - before[-2]
        found = balance.at((Omega, *peer.frequency[1:])).solve(start)
        before = [*before[-1:], found.contact]
        yield np.einsum("jn,jn->j", found.displacement, rows)


def compare(compared: Compared) -> str:
    """Measure both methods; return the line of the table."""
    case, span = compared.case, np.linspace(*compared.span, _POINTS)
    with one_thread():
        table, curve, count, own = _tabulated(compared, span)
        seconds, exact = processor_time(lambda: np.array(list(balanced(compared, span))))
    size = np.abs(exact[:, 0])
    at_peak = abs(own.max() / size.max() - 1.0)
    worst = np.abs(own - size).max() / size.max()
    return (
        f"{case.name:>22} {table:7.3f}s {1e3 * curve / count:8.4f}ms "
        f"{1e3 * seconds / _POINTS:15.2f}ms {seconds / _POINTS * count / curve:7.0f}x "
        f"{seconds / (table + curve):10.1f}x {at_peak:8.2%} {worst:8.2%}"
    )


def _tabulated(compared: Compared, span: Floats) -> tuple[float, float, int, Floats]:
    """Seconds of the table and of the curve, its points, and |x| at frequencies."""
    case, largest_step, spent = compared.case, LARGEST_STEP, []
    reduced = rom.reduce(case.structure, tuple(range(len(case.force))))
    for _ in range(_TURNS):
        anew = reduced.at_carrier(case.frequency)  # without cached contact problems
        table, model = processor_time(
            partial(rom.tabulate, anew, case.law, compared.amplitude, _TOLERANCE)
        )
        follow = partial(rom.response_curve, model, case.frequency, case.force, "frequency_A")
        seconds, curve = processor_time(partial(follow, compared.span, largest_step=largest_step))
        spent.append((table, seconds))
        largest_step *= curve.parameter.size / _POINTS
    last = np.nextafter(curve.parameter.max(), 0.0)
    states = [curve.at(min(Omega, last))[0][0] for Omega in span]
    own = np.array([np.abs(steady_displacement(model, case, a)[0]) for a in states])
    table, seconds = np.median(spent, axis=0).tolist()
    return table, seconds, curve.parameter.size, own


def main() -> None:
    """Print the table."""
    print(
        f"{'curve':>22} {'table':>8} {'a point':>10} {'balance, a point':>17} {'cheaper':>8} "
        f"{'with table':>11} {'at peak':>8} {'worst':>8}"
    )
    for make in (two_masses, partial(blade_on_springs, 2), partial(blade_on_springs, 8)):
        print(compare(make()), flush=True)


if __name__ == "__main__":
    main()
