"""Samples of the contact problem for a friction table, and the error of a table against them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from slipmode.rom.arrays import Complexes, Floats
from slipmode.rom.contact.error_norm import SMALLEST_SHARE, ErrorNorm
from slipmode.rom.contact.problem import ContactProblem, TorusProblem
from slipmode.rom.contact.resolution import Mapped
from slipmode.rom.contact.slip_onset import onset_lines, stick
from slipmode.rom.contact.terms import ContactTerms
from slipmode.rom.reduction.combination import Order, tabulated_orders
from slipmode.rom.short_repr import frozen
from slipmode.rom.table.hermite import Table, make_table

if TYPE_CHECKING:
    from tqdm import tqdm

_Solved = TypeVar("_Solved")


@frozen
class Sampling:
    """Where samples come from, what they hold, and what errors of a table are relative to."""

    # Samples (points, columns) at amplitudes (points, modes). The tabulated columns come first.
    # Solves begin with guesses (points, carried) of the others, if these are known.
    at: Callable[[Floats, Complexes | None], Complexes]
    problem: ContactProblem
    amplitude_range: Floats  # (modes,), largest amplitudes [kg^1/2 m]
    noise: float  # relative error of samples due to motion that is not yet periodic
    kept: bool = False  # whether the carried columns are wanted at all nodes

    @property
    def orders(self) -> list[Order]:
        """Harmonics (n, m) behind the tabulated columns: S_j of the modes first, power last."""
        return tabulated_orders(self.problem.combinations, self.amplitude_range.size)

    @cached_property
    def norm(self) -> ErrorNorm:
        """Norm of S_j, before any is known."""
        return ErrorNorm.of(self.problem.reduced, self.amplitude_range)

    @cached_property
    def onset_lines(self) -> Floats:
        """Where samples may have kinks, (lines, modes), see `onset_lines`."""
        return onset_lines(self.problem.reduced, self.problem.law)

    def errors(
        self, table: Table, points: Floats, off: Complexes | Floats, exact: Complexes
    ) -> Floats:
        """Return the largest relative error (...,) of the tabulated columns of a table.

        Errors `off` and values `exact` are (..., columns), at amplitudes (..., modes). Errors at
        amplitudes that are too small to be part of what a table states are 0.
        """
        norm, carrier = self.norm.known(table.nodes()), self.problem.reduced.carrier
        scale = norm.scale(points, exact[..., : carrier.size])
        # An error of S_j changes the power by 2 Omega_j |a_j| times that error.
        power = (scale * points * 2.0 * carrier).sum(axis=-1, keepdims=True)
        power = np.where(power > 0.0, power, 1.0)
        # A combination resonance has the scale of S_j of the mode that it drives.
        driven = scale[..., [term.mode for term in self.problem.combinations]]
        relative = np.abs(off) / np.concatenate((scale, driven, power), axis=-1)
        return np.where(norm.share(points) < SMALLEST_SHARE, 0.0, relative.max(axis=-1))

    def indicators(self, table: Table) -> Floats:
        """Return the error of nodes predicted by neighbours along each axis, (modes, n_a, n_b)."""
        S = table.nodes()
        points = amplitude_pairs(table.node_a, table.node_b, table.modes)
        parts = [unpredicted(table.node_a, S)]
        if table.modes == 2:
            parts.append(unpredicted(table.node_b, S.swapaxes(0, 1)).swapaxes(0, 1))
        return np.array([self.errors(table, points, part, S) for part in parts])

    def table(self, axes: tuple[Floats, Floats], tabulated: Complexes) -> Table:
        """Return the table through the tabulated columns on a grid."""
        # Contacts have no share in structural losses in the paper's formulation.
        loss = self.norm.loss * (self.problem.reduced.formulation == "consistent")
        return make_table(axes[0], axes[1], tabulated, self.orders, loss)


@dataclass(eq=False)
class ContactSamples:
    """Contact terms at many amplitudes, task by task.

    Attributes
    ----------
    torus : TorusProblem
    amplitude_range : (modes,) ndarray
        Largest amplitudes [kg^1/2 m].
    mapped : callable
    bar : tqdm
    carries : bool
        Whether the samples have harmonics of the contacts besides the tabulated columns.
    carriers : (modes, N_c) complex ndarray
        P of the contacts at the largest amplitudes; 0 until they were sampled [m].
    periodicity : float
        Largest distance from periodicity so far.
    solved : int
        Contact problems so far.
    """

    torus: TorusProblem
    amplitude_range: Floats
    mapped: Mapped
    bar: tqdm[Any]
    carries: bool
    carriers: Complexes = field(init=False)
    periodicity: float = 0.0
    solved: int = 0

    def __post_init__(self) -> None:
        contacts = self.torus.problem.reduced.n_contacts
        self.carriers = np.zeros((self.amplitude_range.size, contacts), dtype=complex)

    def __call__(self, amplitudes: Floats, near: Complexes | None = None) -> Complexes:
        """Return the tabulated columns, then those that are carried along, (points, columns).

        `near` are guesses of the latter. Nothing is solved where all contacts stick.
        """
        problem = self.torus.problem
        samples = self._columns(ContactTerms.at_rest(problem, amplitudes))
        moving = ~stick(problem.reduced, problem.law, amplitudes)
        if not moving.any():
            return samples
        guesses = []
        if near is not None and self.carries:  # without the last, what the harmonics leave out
            guesses = [near[moving].reshape(moving.sum(), len(problem.orders) + 1, -1)[:, :-1]]
        rows = []
        solved = in_tasks(self.mapped, self.torus.solve, amplitudes[moving], *guesses)
        for terms in self.mapped(self.torus.on_more_lines, solved):
            terms.check_periodic()
            rows.append(self._columns(terms))
            (at,) = np.nonzero((terms.amplitudes == self.amplitude_range).all(axis=1))
            if at.size:
                self.carriers = terms.P[at[0], : self.amplitude_range.size]
            self.periodicity = max(self.periodicity, float(terms.residual.max()))
            self.solved += len(terms.S)
            self.bar.update(len(terms.S))
        samples[moving] = np.concatenate(rows)
        return samples

    def _columns(self, terms: ContactTerms) -> Complexes:
        """Return the columns of contact terms, (points, columns)."""
        lost = terms.power - terms.leaving - terms.by_forces
        parts = [terms.S, terms.T, (lost + 1j * terms.by_forces)[:, np.newaxis]]
        if self.carries:
            parts += [terms.P.reshape(len(terms.S), -1), terms.left_out]
        return np.concatenate(parts, axis=1)


def in_tasks(
    mapped: Mapped, solve: Callable[..., _Solved], amplitudes: Floats, *beside: Complexes
) -> Iterable[_Solved]:
    """Return what `solve` finds at many amplitudes, in tasks of a fixed size.

    The result does not depend on the number of threads so. `beside` are further arguments of
    `solve`, (points, ...).
    """
    tasks = [slice(first, first + 16) for first in range(0, len(amplitudes), 16)]
    return mapped(solve, *([each[task] for task in tasks] for each in (amplitudes, *beside)))


def amplitude_pairs(node_a: Floats, node_b: Floats, modes: int) -> Floats:
    """Return the amplitudes (n_a, n_b, modes) of a grid. One mode has the first axis only."""
    grid = np.broadcast_arrays(node_a[:, np.newaxis], node_b)
    return np.stack(grid[:modes], axis=-1)


def unpredicted(node: Floats, values: Complexes) -> Floats:
    """Return |values - cubic through two neighbours on either side|, of the shape of values.

    Along the first axis; at its ends through the nearest four. 0 at node = 0, where all harmonics
    are known.
    """
    here = np.arange(1, node.size)[:, np.newaxis]
    window = np.clip(here - 2, 0, node.size - 5) + np.arange(5)
    others = window[window != here].reshape(-1, 4)
    own, known = np.eye(4, dtype=bool), node[others]
    apart = np.where(own, 1.0, known[:, :, np.newaxis] - known[:, np.newaxis])
    reach = np.where(own, 1.0, (node[here] - known)[:, np.newaxis])
    weights = np.eye(node.size)
    weights[here, others] = -np.prod(reach / apart, axis=2)
    weights[0] = 0.0
    return np.asarray(np.abs(np.tensordot(weights, values, axes=1)))
