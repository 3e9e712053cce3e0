"""The reduced-order model: reduced matrices, friction law and friction table in one file."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, astuple, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from rom.errors import SlipmodeError
from rom.friction import Coulomb, Friction, Tanh, limits
from rom.harmonics import Harmonics
from rom.magnitude import LARGEST_PRODUCT, SMALLEST_PRODUCT
from rom.matrices import Floats
from rom.model_content import check_arrays, check_header
from rom.near import NearResonance, Order, near_resonances, tabulated_orders
from rom.quality import Quality
from rom.reduction import Reduced
from rom.refinement import Columns, Sampling, refine
from rom.resolution import choose_resolution, least_force
from rom.softness import check_softness
from rom.tables import Complexes, Table
from rom.torus import ContactTerms, contact_orders, contact_terms

FORMAT = 9  # of the file; raised whenever tables computed before must not be used any more

# Damaged files make zipfile, zlib and numpy raise nearly anything.
_UNREADABLE = Exception
REDUCED_ARRAYS = (
    *("frequency", "carrier", "modal_damping", "mode_shapes", "contact_shapes"),
    *("mass", "damping", "stiffness", "spring", "damper", "contact_motion", "carried_mass"),
    *(
        "passive_frequency",
        "passive_damping",
        "passive_shapes",
        "passive_inertia",
        "passive_damper",
    ),
    "damping_coupling",
)
_STUCK = 1e-6  # contact motion that is rounding, relative to that without friction
_POINTS_PER_TASK = 16  # fixed, so that the answer does not depend on the number of threads


@dataclass(frozen=True, eq=False)
class Model:
    """Everything that a simulation in slow time needs.

    Attributes
    ----------
    reduced : Reduced
    law : Tanh or Coulomb
    table : Table
    harmonics : Harmonics or None
        Of the contact displacement, where they were asked for.
    near : tuple of NearResonance
    quality : Quality
    """

    reduced: Reduced
    law: Friction
    table: Table
    harmonics: Harmonics | None
    near: tuple[NearResonance, ...]
    quality: Quality

    @property
    def modes(self) -> int:
        """Number of modes, 1 or 2."""
        return len(self.reduced.modes)

    @property
    def hash(self) -> str:
        """Hexadecimal content hash: equal for equal models."""
        return _digest(self._header(), self._content())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model to one file (an .npz archive), with its content hash."""
        header = self._header()
        content = self._content()
        stored = json.dumps(header | {"hash": _digest(header, content)})
        target = Path(path)
        temporary = target.with_name(f"{target.name}.{os.getpid()}.part")
        try:
            with temporary.open("wb") as file:
                np.savez(file, allow_pickle=False, header=np.array(stored), **content)
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Model:
        """Read a model.

        Raises
        ------
        SlipmodeError
            If the file is missing, of another version, damaged (its hash does not fit), or no
            model all the same.
        """
        path = Path(path)
        try:
            with np.load(path, allow_pickle=False) as archive:
                content = {name: archive[name] for name in archive.files}
            header = json.loads(str(content.pop("header")))
            expected = header.pop("hash")
        except FileNotFoundError:
            raise SlipmodeError(f"{path}: no such model file") from None
        except _UNREADABLE as error:
            shown = " ".join(str(error).split())
            raise SlipmodeError(f"{path}: not a readable model file ({shown})") from None
        if header.get("format") != FORMAT:
            raise SlipmodeError(
                f"{path}: model format {header.get('format')} is not {FORMAT}; tabulate it again"
            )
        if _digest(header, content) != expected:
            raise SlipmodeError(f"{path}: damaged: its content does not fit its hash")
        try:
            check_header(header)
            check_arrays(header, content)
            limit = [float(value) for value in content["limit"]]
            law = Tanh(limit, header["alpha"]) if header["law"] == "tanh" else Coulomb(limit)
        except SlipmodeError as error:
            raise SlipmodeError(f"{path}: {error}") from None
        reduced = Reduced(
            formulation=header["formulation"],
            modes=tuple(header["modes"]),
            **{name: content[name] for name in REDUCED_ARRAYS},
        )
        table = Table(content["node_a"], content["node_b"], content["values"], len(reduced.modes))
        near = tuple(NearResonance(*term) for term in header["near"])
        quality = Quality(**header["quality"])
        harmonics = None
        if header["orders"]:
            orders = tuple((n, m) for n, m in header["orders"])
            harmonics = Harmonics(table.axes, orders, content["P"], content["left_out"])
        return cls(reduced, law, table, harmonics, near, quality)

    def _header(self) -> dict[str, Any]:
        return {
            "format": FORMAT,
            "formulation": self.reduced.formulation,
            "modes": list(self.reduced.modes),
            "law": "tanh" if isinstance(self.law, Tanh) else "coulomb",
            "alpha": self.law.alpha,
            "near": [list(astuple(term)) for term in self.near],
            "orders": [list(order) for order in self.harmonics.orders] if self.harmonics else [],
            "quality": asdict(self.quality),
        }

    def _content(self) -> dict[str, np.ndarray]:
        arrays = {name: np.asarray(getattr(self.reduced, name)) for name in REDUCED_ARRAYS}
        if self.harmonics:
            arrays |= {"P": self.harmonics.P, "left_out": self.harmonics.left_out}
        return arrays | {
            "limit": limits(self.law, self.reduced.n_contacts),
            "node_a": self.table.node_a,
            "node_b": self.table.node_b,
            "values": self.table.values,
        }


def tabulate(
    reduced: Reduced,
    law: Friction,
    amplitude: Sequence[float],
    tolerance: float = 1e-3,
    *,
    near: Sequence[NearResonance] | None = None,
    harmonics: int = 0,
    threads: int | None = None,
    progress: bool = False,
) -> Model:
    """Precompute the friction functions over a range of amplitudes.

    Parameters
    ----------
    reduced : Reduced
    law : Tanh or Coulomb
    amplitude : sequence of float
        Largest amplitude |a_j| of each mode [kg^1/2 m].
    tolerance : float
        Of S_j = Q_j |a_j|, relative to its largest value over the table: half of it for the
        contact problem, the whole for the interpolation.
    near : sequence of NearResonance, optional
        Combination frequencies that the slow flow is to treat as resonant. Default: those near
        the carriers of `reduced`; none in the paper's formulation.
    harmonics : int
        Order up to which harmonics of the contact motion are kept, for the reconstruction of fast
        motion; 0: none. A march needs those that the modes answer to, `ANSWERED_ORDER`.
    threads : int, optional
        Default: one per processor. The result does not depend on it.
    progress : bool
        Show a progress bar on work longer than a second.

    Raises
    ------
    SlipmodeError
        If the tolerance cannot be reached.
    """
    limit = np.asarray(amplitude, dtype=float)
    if limit.shape != (len(reduced.modes),) or not np.all(
        (limit >= SMALLEST_PRODUCT) & (limit <= LARGEST_PRODUCT)
    ):
        raise SlipmodeError(
            f"amplitude: must be {len(reduced.modes)} finite numbers > 0, "
            f"{SMALLEST_PRODUCT:g} to {LARGEST_PRODUCT:g}, got {amplitude}"
        )
    if not 1e-6 <= tolerance <= 0.1:
        raise SlipmodeError(f"tolerance: must be 1e-6 to 0.1, got {tolerance}")
    limits(law, reduced.n_contacts)  # refuses a wrong number of limits before any work
    if near is None:
        near = () if reduced.formulation == "paper" else near_resonances(reduced.carrier)
    check_softness(reduced, tolerance, near)
    resolution = choose_resolution(reduced, law, limit, 0.5 * tolerance, near)
    solve = partial(
        contact_terms,
        reduced,
        law,
        grid=resolution.grid,
        tolerance=0.1 * tolerance,
        smallest_scale=0.1 * limit,
        near=near,
        highest=max(harmonics, 1),
    )
    orders = contact_orders(reduced, near, harmonics) if harmonics else []
    columns = Columns(
        orders=tuple(tabulated_orders(near, limit.size)),
        drives=(*range(limit.size), *(term.mode for term in near)),
        swing=2.0 * reduced.carrier * limit,
        least=least_force(reduced, limit),
        loss=_structural_loss(reduced),
        carried=(len(orders) + 1) * reduced.n_contacts if orders else 0,
    )
    with (
        ThreadPoolExecutor(threads or os.cpu_count()) as pool,
        tqdm(unit=" points", desc="friction table", delay=1.0, disable=not progress) as bar,
    ):
        samples = _Samples(solve, columns, pool, bar)
        table, carried, error = refine(Sampling(samples, columns), limit, tolerance)
    quality = Quality(
        tolerance=tolerance,
        interpolation=error,
        resolution=resolution.error,
        periodicity=samples.periodicity,
        steps=resolution.grid.steps,
        lines=resolution.grid.lines,
    )
    kept = _harmonics(table, orders, carried) if orders else None
    reduced = replace(reduced, contact_motion=_contact_motion(reduced, solve, limit))
    return Model(reduced, law, table, kept, tuple(near), quality)


def _harmonics(table: Table, orders: Sequence[Order], carried: Complexes) -> Harmonics:
    """From the columns that samples carried: P of every order, then what they leave out."""
    nodes = tuple(axis.size for axis in table.axes)
    columns = carried.reshape(*nodes, len(orders) + 1, -1)
    P = np.ascontiguousarray(columns[..., :-1, :])
    return Harmonics(table.axes, tuple(orders), P, np.ascontiguousarray(columns[..., -1, :].real))


def _contact_motion(
    reduced: Reduced, solve: Callable[[Floats], ContactTerms], limit: Floats
) -> Complexes:
    """Carriers of the contacts per a_j (modes, N_c) at the largest amplitudes, where they move."""
    moved = solve(limit[np.newaxis]).P[0, : limit.size] / limit[:, np.newaxis]
    least = _STUCK * np.linalg.norm(reduced.contact_motion, axis=1, keepdims=True)
    sticks = np.linalg.norm(moved, axis=1, keepdims=True) <= least
    return np.where(sticks, reduced.contact_motion, moved)


def _structural_loss(reduced: Reduced) -> Floats:
    """gamma_j Omega_j, where the contacts share in it; nothing in the paper's formulation."""
    loss = reduced.modal_damping * reduced.carrier
    return loss if reduced.formulation == "consistent" else np.zeros_like(loss)


class _Samples:
    """Contact terms at many amplitudes, spread over threads in tasks of a fixed size."""

    def __init__(
        self,
        solve: Callable[[Floats], ContactTerms],
        columns: Columns,
        pool: ThreadPoolExecutor,
        bar: tqdm[Any],
    ) -> None:
        self._solve = solve
        self._columns = columns
        self._pool = pool
        self._bar = bar
        self.periodicity = 0.0

    def __call__(self, amplitudes: Floats) -> Complexes:
        tasks = [
            amplitudes[start : start + _POINTS_PER_TASK]
            for start in range(0, len(amplitudes), _POINTS_PER_TASK)
        ]
        parts = []
        for terms in self._pool.map(self._solve, tasks):
            beyond = np.hstack((terms.P.reshape(len(terms.S), -1), terms.left_out))
            carried = beyond[:, : self._columns.carried]
            lost = (terms.power - terms.leaving)[:, np.newaxis]
            parts.append(np.hstack((terms.S, terms.T, lost, carried)))
            self.periodicity = max(self.periodicity, float(terms.residual.max()))
            self._bar.update(len(terms.S))
        return np.concatenate(parts)


def _digest(header: dict[str, Any], content: dict[str, np.ndarray]) -> str:
    digest = hashlib.sha256(json.dumps(header, sort_keys=True).encode())
    for name in sorted(content):
        array = np.ascontiguousarray(content[name])
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()
