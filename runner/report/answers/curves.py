"""Response curves beside harmonic balance with continuation, in one run: make bench-curves.

Both follow the same curve with as many points, each with what it takes at least to be within 0.5 %
of the curve of far more harmonics. Harmonic balance goes from frequency to frequency, its start
drawn on from the last two solutions; it is condensed to the contacts, and of a large structure it
has the component modes. Seconds are of the processor, with BLAS on one thread.
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
from slipmode.rom.slow.branches.forced import LARGEST_STEP
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.cases.blade import blade
from slipmode.runner.report.cases.cases import Case, two_mode
from slipmode.runner.report.measure import one_thread
from slipmode.runner.report.methods.ours import steady_displacement
from slipmode.runner.report.peers.hbm import HarmonicBalance

T = TypeVar("T")

_POINTS = 250  # of a curve
_PUBLISHED = 29  # every 5 rad/s, as there
_TURNS = 5  # of which the median counts, of table and curve
# 0.19 % off at worst where it has two modes (27 harmonics; 15 are 0.25 % off, 13 0.58 %), 0.42 %
# on the blade with two dampers (61; 25 are 0.26 % off, 21 0.62 %)
_TOLERANCE = 1e-2  # of tables
_TWO_MODE_HARMONICS, _BLADE_HARMONICS = 15, 25
_DIRECT = 4e-3  # of states without a table
_DAMPING = 1e-6  # of the blade, times its stiffness [s]
_SPRING, _LIMIT, _ALPHA = 4e4, 2.0, 1e-2  # of all its dampers [N/m], [N], [m/s]
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
    """Seconds of table, curve and harmonic balance, and how many points each curve has.

    Then the difference of |x| of mode A at the peak and the worst, relative to it. `published` is
    that from somebody else's curve, NaN where there is none.
    """

    table: float
    curve: float
    points: int
    balance: float
    solved: int
    at_peak: float
    worst: float
    published: float = np.nan

    @property
    def point_ratio(self) -> float:
        """How many times harmonic balance costs a point, table apart."""
        return self.balance / self.solved * self.points / self.curve

    @property
    def ratio(self) -> float:
        """The same for the whole curve, with the table."""
        return self.balance / (self.table + self.curve)


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
        (blade_on_springs(2), None),
        (blade_on_springs(8), None),
    ]
    if folder is not None:
        compared.append((nlvib_beam(folder), nlvib_curve(folder)))
    for each, published in compared:
        points = _POINTS if published is None else _PUBLISHED
        found = compare(each, published, points)
        print(
            f"{each.case.name:>22} {found.table:7.3f}s {1e3 * found.curve / found.points:8.4f}ms "
            f"{1e3 * found.balance / found.solved:15.2f}ms {found.point_ratio:7.0f}x "
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
        balance, exact = _spent(lambda: np.array(list(balanced(compared, span))))
    size = np.abs(exact[:, 0])
    apart = np.nan if published is None else np.abs(own - published(span)).max() / own.max()
    return Found(
        *(table, curve, found, balance, points),
        *(float(abs(own.max() / size.max() - 1.0)), float(np.abs(own - size).max() / size.max())),
        float(apart),
    )


def _tabulated(
    case: Case, reduced: rom.Reduced, compared: Compared, span: Floats
) -> tuple[float, float, int, Floats]:
    """Seconds of the table and of the curve, its points, and |x| at frequencies."""
    amplitude, largest_step, spent = compared.amplitude, LARGEST_STEP, []
    assert amplitude is not None
    for _ in range(_TURNS):
        anew = reduced.at_carrier(case.frequency)  # nothing is known of it
        table, model = _spent(partial(rom.tabulate, anew, case.law, amplitude, _TOLERANCE))
        follow = partial(rom.response_curve, model, case.frequency, case.force, "frequency_A")
        seconds, curve = _spent(partial(follow, compared.span, largest_step=largest_step))
        spent.append((table, seconds))
        largest_step *= curve.parameter.size / _POINTS
    own = np.array([_displacement(model, case, curve, Omega) for Omega in span])
    table, seconds = np.median(spent, axis=0).tolist()
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


def balanced(compared: Compared, span: Floats) -> Iterator[Complexes]:
    """Carriers (modes,) at successive frequencies."""
    before: list[Complexes] = []
    balance = HarmonicBalance(compared.peer, compared.harmonics)
    for Omega in span:
        start = None if len(before) < 2 else 2.0 * before[-1] - before[-2]
        found = balance.at((Omega, *compared.peer.frequency[1:])).solve(start)
        before = [*before[-1:], found.contact]
        yield np.einsum("jn,jn->j", found.displacement, compared.observed)


def two_masses() -> Compared:
    """The two-mode scene: A through its resonance, B beside its own."""
    return Compared.of(two_mode(), (0.94, 1.02), (4.0, 2.0), _TWO_MODE_HARMONICS)


def blade_on_springs(dampers: int, dofs: int = 3000) -> Compared:
    """A blade of hexahedra with dampers on nodes of it, each behind a spring."""
    parts = blade(dofs, 2 * dampers)
    n, held = parts["mass"].shape[0], parts["contact"][dampers:] + 2  # halfway, out of its plane
    spring = _SPRING / dampers * np.ones(dampers)
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
        f"blade, {dampers} dampers",
        structure,
        rom.Tanh(limit=_LIMIT / dampers, alpha=_ALPHA),
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
    return Compared(case, span, _RANGE, _BLADE_HARMONICS, peer, basis[[tip]])


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
