"""Response curves beside harmonic balance with continuation, in one run: make bench-curves.

Both follow the same curve. Harmonic balance goes from frequency to frequency, its start drawn on
from the last two solutions; it is condensed to the contacts, and of a large structure it has the
component modes. Seconds are of the processor, with BLAS on one thread.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.io
import scipy.sparse

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.cases.blade import blade
from slipmode.runner.report.cases.cases import Case, two_mode
from slipmode.runner.report.measure import one_thread
from slipmode.runner.report.methods.ours import steady_displacement
from slipmode.runner.report.peers.hbm import HarmonicBalance

T = TypeVar("T")

_POINTS = 250  # of a curve
_SOLVED = 80  # of them, by harmonic balance
_PUBLISHED = 29  # every 5 rad/s, as there
_TOLERANCE = 1e-3  # of tables
_DIRECT = 4e-3  # of states without a table
_DAMPING = 1e-6  # of the blade, times its stiffness [s]
_SPRING, _LIMIT, _ALPHA = 2e4, 1.0, 1e-2  # of its dampers [N/m], [N], [m/s]
_FORCE, _RANGE = 1.5, (4e-4,)  # [N], [kg^1/2 m]
_BEAM = "nlvib08_beam.mat", "nlvib08_reference.npz"


@dataclass(frozen=True, eq=False)
class Compared:
    """A curve of mode A, with mode B beside it where there are two.

    Attributes
    ----------
    case : Case
        Its frequencies are the carriers of the table; that of mode A varies.
    span : (first, last)
        [rad/s]
    amplitude : tuple of float, or None
        Range of the table [kg^1/2 m]; None: each state by itself, without one.
    harmonics : int
        Of harmonic balance.
    peer, observed : Case, (modes, its DOFs) ndarray
        What harmonic balance solves, and where it is looked at; default: the same.
    """

    case: Case
    span: tuple[float, float]
    amplitude: tuple[float, ...] | None
    harmonics: int
    peer: Case
    observed: Floats

    @classmethod
    def of(
        cls,
        case: Case,
        span: tuple[float, float],
        amplitude: tuple[float, ...] | None,
        harmonics: int,
    ) -> Compared:
        """With harmonic balance on the structure itself."""
        observed = np.eye(case.structure.n_dofs)[list(case.observed)]
        return cls(case, span, amplitude, harmonics, case, observed)


@dataclass(frozen=True)
class Found:
    """Seconds, and the difference of |x| of mode A at the peak and the worst, relative to it.

    `published` is that from somebody else's curve, NaN where there is none.
    """

    table: float
    curve: float
    points: int
    balance: float
    at_peak: float
    worst: float
    published: float = np.nan

    @property
    def point_ratio(self) -> float:
        """How many times harmonic balance costs a point, table apart."""
        return self.balance / _POINTS * self.points / self.curve

    @property
    def ratio(self) -> float:
        """The same for all points, with the table."""
        return self.balance / (self.table + self.curve * _POINTS / self.points)


def main(arguments: list[str] | None = None) -> None:
    """Print the table; `--published FOLDER` adds the beam of NLvib's example 08."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--published", type=Path, help=f"folder of {' and '.join(_BEAM)}")
    folder = parser.parse_args(arguments).published
    print(
        f"{'curve':>22} {'table':>8} {'a point':>10} {'balance, a point':>17} {'cheaper':>8} "
        f"{'with table':>11} {'at peak':>8} {'worst':>8}"
    )
    compared: list[tuple[Compared, Callable[[Floats], Floats] | None]] = [
        (two_masses(), None),
        (blade_on_springs(), None),
    ]
    if folder is not None:
        compared.append((nlvib_beam(folder), nlvib_curve(folder)))
    for each, published in compared:
        points = _SOLVED if published is None else _PUBLISHED
        found = compare(each, published, points)
        print(
            f"{each.case.name:>22} {found.table:7.2f}s {1e3 * found.curve / found.points:8.3f}ms "
            f"{1e3 * found.balance / _POINTS:15.2f}ms {found.point_ratio:7.0f}x "
            f"{found.ratio:10.1f}x {found.at_peak:8.2%} {found.worst:8.2%}"
        )
        if published is not None:
            print(f"{'published':>22} {found.published:.2%} from ours at most")


def compare(
    compared: Compared, published: Callable[[Floats], Floats] | None, points: int
) -> Found:
    """Both, and what they differ by."""
    case, span = compared.case, np.linspace(*compared.span, points)
    with one_thread():
        reduced = rom.reduce(case.structure, tuple(range(len(case.force))))
        if compared.amplitude is None:
            table, found = 0.0, points
            curve, own = _spent(
                lambda: np.array([_direct(case, reduced, Omega) for Omega in span])
            )
        else:
            table, curve, found, own = _tabulated(case, reduced, compared, span)
        balance, exact = _spent(lambda: np.array(list(_balanced(compared, span))))
    size = np.abs(exact[:, 0])
    apart = np.nan if published is None else np.abs(own - published(span)).max() / own.max()
    return Found(
        *(table, curve, found, balance * _POINTS / points),
        *(float(abs(own.max() / size.max() - 1.0)), float(np.abs(own - size).max() / size.max())),
        float(apart),
    )


def _tabulated(
    case: Case, reduced: rom.Reduced, compared: Compared, span: Floats
) -> tuple[float, float, int, Floats]:
    """Seconds of the table and of the curve, its points, and |x| at frequencies."""
    assert compared.amplitude is not None
    reduced = reduced.at_carrier(case.frequency)
    table, model = _spent(partial(rom.tabulate, reduced, case.law, compared.amplitude, _TOLERANCE))
    seconds, curve = _spent(
        lambda: rom.response_curve(model, case.frequency, case.force, "frequency_A", compared.span)
    )
    own = np.array([_displacement(model, case, curve, Omega) for Omega in span])
    return table, seconds, curve.parameter.size, own


def _direct(case: Case, reduced: rom.Reduced, Omega: float) -> float:
    """|x| without a table: a curve far from the frequency that a table is of."""
    frequency = (Omega, *case.frequency[1:])
    state = rom.steady_state(reduced, case.law, frequency, case.force, _DIRECT)
    return float(np.abs(state.displacement(case.structure)[0, case.observed[0]]))


def _displacement(model: rom.Model, case: Case, curve: rom.ResponseCurve, Omega: float) -> float:
    """|x| of mode A where it is observed, of the only steady state."""
    (a,), _ = curve.at(min(Omega, np.nextafter(curve.parameter.max(), 0.0)))
    return float(np.abs(steady_displacement(model, case, a)[0]))


def _balanced(compared: Compared, span: Floats) -> Iterator[Complexes]:
    """Carriers (modes,) at successive frequencies."""
    before: list[Complexes] = []
    for Omega in span:
        case = replace(compared.peer, frequency=(Omega, *compared.peer.frequency[1:]))
        start = None if len(before) < 2 else 2.0 * before[-1] - before[-2]
        found = HarmonicBalance(case, compared.harmonics).solve(start)
        before = [*before[-1:], found.contact]
        yield np.einsum("jn,jn->j", found.displacement, compared.observed)


def two_masses() -> Compared:
    """The two-mode scene: A through its resonance, B beside its own."""
    return Compared.of(two_mode(), (0.94, 1.02), (4.0, 2.0), 19)


def blade_on_springs(dofs: int = 3000) -> Compared:
    """A blade of hexahedra with dampers on two of its nodes, each behind a spring."""
    parts = blade(dofs, 4)
    n, held = parts["mass"].shape[0], parts["contact"][2:] + 2  # halfway, out of its plane
    spring = _SPRING * np.ones(held.size)
    tie = scipy.sparse.csr_array((spring, (held, np.arange(held.size))), shape=(n, held.size))
    K = scipy.sparse.block_array(
        [
            [parts["stiffness"] + _diagonal(n, held, spring), -tie],
            [-tie.T, scipy.sparse.diags_array(spring)],
        ]
    )
    M = scipy.sparse.block_diag((parts["mass"], 1e-6 * scipy.sparse.eye_array(held.size)), "csr")
    structure = rom.Structure(M, K.tocsr(), _DAMPING, contact=list(range(n, n + held.size)))
    tip = n - 1
    first = rom.reduce(structure, (0,))
    case = Case(
        "blade on springs",
        structure,
        rom.Tanh(limit=_LIMIT, alpha=_ALPHA),
        force=({tip: _FORCE},),
        frequency=(float(first.frequency[0]),),
        observed=(tip,),
    )
    span = 0.99 * case.frequency[0], 1.01 * case.frequency[0]
    modes = full.component_modes(structure, case.law, case.force, 7.0 * span[1])
    basis = as_dense(modes.projection.basis)
    pattern = np.zeros(structure.n_dofs)
    pattern[tip] = _FORCE
    peer = replace(case, structure=modes.structure, force=(basis.T @ pattern,), observed=(0,))
    return Compared(case, span, _RANGE, 25, peer, basis[[tip]])


def nlvib_beam(folder: Path) -> Compared:
    """Example 08 of NLvib: a beam with friction at a DOF."""
    beam: dict[str, Any] = scipy.io.loadmat(folder / _BEAM[0])
    damping = 0.5 * (beam["D"] + beam["D"].T)
    structure = rom.Structure(beam["M"], beam["K"], damping, contact=beam["W"].reshape(-1, 1))
    tip = int(np.abs(beam["T_tip"]).argmax())
    span = 160.0, 300.0
    case = Case(
        *("NLvib 08", structure, rom.Tanh(limit=1.5, alpha=6e-7)),
        force=(beam["Fex1"].ravel(),),
        frequency=(200.0,),
        observed=(tip,),
    )
    return Compared.of(case, span, None, 21)


def nlvib_curve(folder: Path) -> Callable[[Floats], Floats]:
    """Its published first harmonic of the tip, by frequency, as an amplitude |x| / 2."""
    known = np.load(folder / _BEAM[1])
    Omega, size = known["OM_2"], 0.5 * np.abs(known["h1_2"])
    order = np.argsort(Omega)
    return lambda at: np.interp(at, Omega[order], size[order])


def _diagonal(n: int, rows: Any, values: Floats) -> Any:
    return scipy.sparse.csr_array((values, (rows, rows)), shape=(n, n))


def _spent(task: Callable[[], T]) -> tuple[float, T]:
    """Seconds of the processor, and what came out."""
    start = time.process_time()
    found = task()
    return time.process_time() - start, found


if __name__ == "__main__":
    main()
