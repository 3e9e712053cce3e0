"""Fit of one law to the raw signals of all records, with initial amplitudes for each record.

Levenberg-Marquardt with the Schur complement over the records: the parameters of the law are
common to all records, the initial amplitudes of a record appear in its signal alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from slipmode.rom import SlipmodeError
from slipmode.rom.common import Complexes, Flags, Floats, frozen
from slipmode.rom.identification.decay_flow import Decays, as_columns
from slipmode.rom.identification.slow_laws import WIDTH, LawForm, SlowLaw

# Step of forward differences in the scale of each parameter. Derivatives have errors of about
# the same size, which change the path to the optimum but not the optimum itself.
DIFFERENCE = 1e-5
LEAST_RECORDS = 3  # of which a scatter is stated
# Relative size of eigenvalues of the normal matrix that derivatives with errors of DIFFERENCE
# cannot distinguish from zero.
SINGULAR = DIFFERENCE**2


@frozen
class Normal:
    """Normal equations of each record.

    Attributes
    ----------
    matrix : (records, unknowns, unknowns) ndarray
    right : (records, unknowns) ndarray
    cost : (records,) ndarray
        Sums of squared errors relative to the sums of squares of the signals.
    """

    matrix: Floats
    right: Floats
    cost: Floats

    def eliminated(self, first: int) -> Normal:
        """Return the equations that remain after elimination of the first unknowns."""
        own, mixed = self.matrix[:, :first, :first], self.matrix[:, :first, first:]
        both = np.concatenate([mixed, self.right[:, :first, np.newaxis]], axis=2)
        change = mixed.swapaxes(1, 2) @ np.linalg.solve(own, both)
        matrix = self.matrix[:, first:, first:] - change[:, :, :-1]
        return Normal(matrix, self.right[:, first:] - change[:, :, -1], self.cost)


@frozen
class Fit:
    """A law fitted to decays.

    Attributes
    ----------
    law : SlowLaw
    start : (modes, records) ndarray
        Complex initial amplitudes [sensor unit].
    scale : (free parameters,) ndarray
        Units of the parameters in the normal equations.
    normal : Normal
        Of the free parameters, at the fit.
    """

    law: SlowLaw
    start: Complexes
    scale: Floats
    normal: Normal

    def left_out(self) -> list[SlowLaw]:
        """Return the law without each of the records, by one Gauss-Newton step from the fit."""
        total, right = self.normal.matrix.sum(axis=0), self.normal.right.sum(axis=0)
        size = np.sqrt(np.diag(total))
        size[size == 0.0] = 1.0
        laws = []
        for matrix, own in zip(self.normal.matrix, self.normal.right, strict=True):
            relative = (total - matrix) / np.multiply.outer(size, size)
            step = np.linalg.lstsq(relative, (right - own) / size, rcond=SINGULAR)[0] / size
            form = self.law.form
            values = _moved(self.law.values, form, step * self.scale)
            laws.append(replace(self.law, values=form.tied(values)))
        return laws

    def singular(self) -> Flags:
        """Return which free parameters the data do not determine at all, (free parameters,)."""
        total = self.normal.matrix.sum(axis=0)
        size = np.sqrt(np.diag(total))
        absent = size <= DIFFERENCE * size.max()
        size[absent] = 1.0
        eigenvalues, vectors = np.linalg.eigh(total / np.multiply.outer(size, size))
        share = (vectors[:, eigenvalues < SINGULAR] ** 2).sum(axis=1)
        found: Flags = absent | (share > 0.1)
        return found


def fit(decays: Decays, form: LawForm, values: Floats, start: Complexes) -> Fit:
    """Return the fit of a law.

    Parameters
    ----------
    decays : Decays
    form : LawForm
        Values of its free parameters are fitted.
    values : (parameters,) ndarray
        Initial guess, and the values of the other parameters.
    start : (modes, records) ndarray
        Initial guess of the complex initial amplitudes [sensor unit].

    Raises
    ------
    SlipmodeError
        If the initial guess has no finite signals.
    """
    scale = _scale(decays, form)
    initial = 2 * form.modes
    now = _normal(decays, form, values, start, scale)
    if not np.isfinite(now.cost).all():  # an amplitude grows without limit: constant rates
        values = values.copy()
        for k in range(0, WIDTH * form.modes, WIDTH):
            values[k : k + 2] += [1.0, -1.0] * values[k + 2 : k + 4]
            values[k + 2 : k + 4] = 0.0
        values = form.limited(values)
        now = _normal(decays, form, values, start, scale)
    if not np.isfinite(now.cost).all():
        raise SlipmodeError("law: decays by the initial guess are not finite; check the bands")
    damping = 1e-3
    for _ in range(40):
        diagonal = np.einsum("ikk->ik", now.matrix)
        damped = now.matrix + damping * diagonal[:, :, np.newaxis] * np.eye(diagonal.shape[1])
        reduced = Normal(damped, now.right, now.cost).eliminated(initial)
        matrix, right = reduced.matrix.sum(axis=0), reduced.right.sum(axis=0)
        step = np.linalg.lstsq(matrix, right, rcond=1e-14)[0]
        limited = form.limited(_moved(values, form, step * scale))
        allowed = (limited - values)[form.free] / scale
        if np.any(inside := np.isclose(step, allowed)) and not np.all(inside):
            # The others move to where they belong beside parameters at their limits.
            right = (right - matrix[:, ~inside] @ allowed[~inside])[inside]
            step = allowed
            step[inside] = np.linalg.lstsq(matrix[inside][:, inside], right, rcond=1e-14)[0]
        rest = now.right[:, :initial] - damped[:, :initial, initial:] @ step
        moves = np.linalg.solve(damped[:, :initial, :initial], rest[..., np.newaxis])[..., 0]
        new_values = form.limited(_moved(values, form, step * scale))
        new_start = start + np.ascontiguousarray(moves).view(complex).T * _initial_sizes(
            decays, start
        )
        new = _normal(decays, form, new_values, new_start, scale)
        decrease = 1.0 - new.cost.sum() / now.cost.sum()
        if decrease > 0.0:
            values, start, now = new_values, new_start, new
            damping = max(0.1 * damping, 1e-9)
            if decrease < 1e-5:
                break
        else:
            damping *= 10.0
            if damping > 1e6:
                break
    law = SlowLaw(form, form.tied(values), decays.reference)
    return Fit(law, start, scale, now.eliminated(initial))


def _moved(values: Floats, form: LawForm, change: Floats) -> Floats:
    moved = values.copy()
    moved[form.free] += change
    return moved


def _scale(decays: Decays, form: LawForm) -> Floats:
    """Return changes of the free parameters that change a phase by about a radian in a record."""
    rate = 1.0 / (decays.steps * decays.step)
    own = [rate, rate, rate, rate, 1.0, 1.0, 1.0, 1.0]
    a = decays.reference
    scale = own * form.modes
    if form.modes == 2:
        scale += [rate / a[1]] * 2 + [rate * a[1] / a[0] ** 2] * 2
    return np.array(scale)[form.free]


def _initial_sizes(decays: Decays, start: Complexes) -> Floats:
    return np.maximum(np.abs(start), 1e-3 * decays.reference[:, np.newaxis])


def _normal(
    decays: Decays, form: LawForm, values: Floats, start: Complexes, scale: Floats
) -> Normal:
    """Return normal equations: initial amplitudes (real, imaginary) first, then parameters."""
    initial, free = 2 * form.modes, np.flatnonzero(form.free)
    unknowns = initial + len(free)
    theta = np.tile(values[:, np.newaxis], 1 + unknowns)
    z = np.tile(start[:, np.newaxis], (1, 1 + unknowns, 1))
    sizes = _initial_sizes(decays, start)
    for k in range(initial):
        z[k // 2, 1 + k] += DIFFERENCE * (1j if k % 2 else 1.0) * sizes[k // 2]
    theta[free, 1 + initial + np.arange(len(free))] += DIFFERENCE * scale
    nodes = decays.nodes(form.tied(theta), z)
    records = len(decays.records)
    matrix = np.empty((records, unknowns, unknowns))
    right, cost = np.empty((records, unknowns)), np.full(records, np.inf)
    if not np.isfinite(nodes).all():
        return Normal(matrix, right, cost)
    for i, of_record in enumerate(decays.squares):
        node = as_columns(nodes, i)
        signal, slope = node[:, 0], (node[:, 1:] - node[:, :1]) / DIFFERENCE
        measured = of_record.projected
        error = measured - of_record.gram @ signal  # S^T (y - S x)
        squares = of_record.total - signal @ (measured + error)
        weight = 1.0 / of_record.total  # quiet records count as much as loud ones
        matrix[i] = weight * slope.T @ (of_record.gram @ slope)
        right[i], cost[i] = weight * slope.T @ error, weight * squares
    return Normal(matrix, right, cost)


def jackknife_variance(of_left_out: Floats, axis: int = 0) -> Floats:
    """Return the variance of a quantity from its values without each of n records."""
    n = of_left_out.shape[axis]
    variance: Floats = (n - 1) * np.var(of_left_out, axis=axis)
    return variance


def interval_half_width(deviation: Floats | float, samples: int) -> Floats:
    """Return half the width of the 95 % interval of a deviation from so many samples."""
    return np.asarray(deviation * scipy.special.stdtrit(samples - 1, 0.975))
