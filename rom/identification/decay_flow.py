"""Decays by a law of the slow flow, and the sensor signals of these.

All records and all perturbed parameters are integrated together, in slow time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace

import numpy as np
import scipy

from slipmode.rom.common import Complexes, Floats, frozen
from slipmode.rom.identification.records.measurement import Record
from slipmode.rom.identification.slow_laws import SlowLaw, complex_rates, parts

# A step times the fastest rate of slow time is at most x = 0.2. Interpolation between steps has a
# relative error of x^4 / 384 = 4e-6, a step one of x^5 / 120 = 3e-6.
STEP = 0.2
# Rate at which a constant friction force ends a vibration, times the step. The Runge-Kutta method
# is stable up to 2.78.
STOP = 2.0


def integrate(
    values: Floats, start: Complexes, reference: Floats, carrier: Floats, step: float, steps: int
) -> Complexes:
    """Return amplitudes and their derivatives times the step, in the frame of the carriers.

    Parameters
    ----------
    values : (parameters, columns) ndarray
        Values of the law's parameters, one set a column.
    start : (modes, columns, records) ndarray
        Initial amplitudes [sensor unit].
    reference : (modes,) ndarray
        Reference amplitudes [sensor unit].
    carrier : (modes,) ndarray
        Angular frequencies of the frame [rad/s].
    step : float
        Time step of the Runge-Kutta method of fourth order [s].
    steps : int
        Number of steps.

    Returns
    -------
    (steps + 1, 2, modes, columns, records) ndarray
        z and step z', where a_j = z_j e^{i carrier_j t}. Not finite where amplitudes overflow.
    """
    own, (q1, q2) = parts(values[:, :, np.newaxis], len(start))
    shape = reference[:, np.newaxis, np.newaxis]
    frame = 1j * carrier[:, np.newaxis, np.newaxis]
    rates = complex_rates(own, shape, STOP / step)
    coupled = bool(np.any(q1) or np.any(q2))
    detuning = carrier[1] - 2.0 * carrier[0] if len(start) == 2 else 0.0

    def slope(z: Complexes, t: float) -> Complexes:
        found = z * (rates(z.real**2 + z.imag**2) - frame)
        if coupled:
            turn = np.exp(1j * detuning * t)
            found[0] += q1 * turn * z[0].conj() * z[1]
            found[1] += q2 * turn.conjugate() * z[0] ** 2
        return step * found

    z = start.astype(complex)
    nodes = np.empty((steps + 1, 2, *z.shape), complex)
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(steps):
            t = k * step
            k1 = slope(z, t)
            nodes[k] = z, k1
            k2 = slope(z + 0.5 * k1, t + 0.5 * step)
            k3 = slope(z + 0.5 * k2, t + 0.5 * step)
            z = z + (k1 + 2.0 * (k2 + k3) + slope(z + k3, t + step)) / 6.0
        nodes[steps] = z, slope(z, steps * step)
    return nodes


def sampling(
    times: Floats, carrier: Floats, shapes: Complexes, step: float, steps: int
) -> scipy.sparse.csr_array:
    """Return the matrix from the nodes of one record to the samples of its channels.

    Between nodes, amplitudes follow cubic Hermite polynomials.

    Parameters
    ----------
    times : (samples,) ndarray
        [s], from the start of the record.
    carrier : (modes,) ndarray
        [rad/s]
    shapes : (channels, modes) ndarray
        Complex amplitude of each channel relative to the reference channel.
    step, steps
        Of `integrate`.

    Returns
    -------
    (channels samples, 4 modes (steps + 1)) sparse array
        It has the columns of `as_columns`.
    """
    channels, modes = shapes.shape
    cell = np.minimum((times / step).astype(int), steps - 1)
    x = times / step - cell
    hermite = np.array(
        [(1 + 2 * x) * (1 - x) ** 2, x * (1 - x) ** 2, x**2 * (3 - 2 * x), x**2 * (x - 1)]
    )
    carried = shapes[:, :, np.newaxis] * np.exp(1j * np.multiply.outer(carrier, times))
    real = np.stack([carried.real, -carried.imag], axis=2)  # Re(z w) of z = (Re z, Im z)
    data = np.einsum("ks,cmps->cskmp", hermite, real)
    width, rows = 4 * modes, channels * len(times)
    columns = cell[:, np.newaxis] * width + np.arange(2 * width)
    ends = np.arange(rows + 1) * 2 * width
    return scipy.sparse.csr_array(
        (data.reshape(-1), np.tile(columns, (channels, 1)).reshape(-1), ends),
        shape=(rows, (steps + 1) * width),
    )


def as_columns(nodes: Complexes, record: int) -> Floats:
    """Return the nodes of a record as real numbers, (4 modes nodes, columns)."""
    z = np.moveaxis(nodes[..., record], -1, 0)  # (columns, nodes, 2, modes)
    return np.ascontiguousarray(z).view(float).reshape(len(z), -1).T


@frozen
class Squares:
    """Sums of squares of a record, by which its samples are used once and not in each iteration.

    With S the matrix of `sampling`, y the signal and x nodes, |y - S x|^2 is the quadratic form of
    these.

    Attributes
    ----------
    gram : (columns, columns) sparse array
        S^T S
    projected : (columns,) ndarray
        S^T y
    total : float
        |y|^2
    """

    gram: scipy.sparse.csr_array = field(repr=False)
    projected: Floats
    total: float


@frozen
class Decays:
    """Records prepared for the integration of a law, with one slow time for all.

    Attributes
    ----------
    records : sequence of Record
        Usable parts, of the same channels.
    carrier : (modes,) ndarray
        [rad/s]
    shapes : (channels, modes) ndarray
        Complex amplitude of each channel relative to the reference channel.
    reference : (modes,) ndarray
        Reference amplitudes of laws [sensor unit].
    step : float
        [s]
    steps : int
        Of the longest record.
    matrices : sequence of sparse arrays
        See `sampling`.
    squares : sequence of Squares
        Of each record.
    """

    records: Sequence[Record]
    carrier: Floats
    shapes: Complexes
    reference: Floats
    step: float
    steps: int
    matrices: Sequence[scipy.sparse.csr_array] = field(repr=False)
    squares: Sequence[Squares]

    @classmethod
    def of(
        cls,
        records: Sequence[Record],
        carrier: Floats,
        shapes: Complexes,
        reference: Floats,
        rate: float,
    ) -> Decays:
        """Return records with a time step for slow rates up to `rate` [1/s]."""
        duration = max(record.duration for record in records)
        steps = int(np.ceil(duration * rate / STEP)) + 1
        step = duration / steps
        made: dict[tuple[float, int], tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]] = {}
        matrices, squares = [], []
        for r in records:
            key = (r.sample_rate, r.samples)
            if key not in made:
                matrix = sampling(r.times, carrier, shapes, step, steps)
                made[key] = matrix, (matrix.T @ matrix).tocsr()
            matrix, gram = made[key]
            signal = r.signal.reshape(-1)
            matrices.append(matrix)
            squares.append(Squares(gram, matrix.T @ signal, float(signal @ signal)))
        return cls(records, carrier, shapes, reference, step, steps, matrices, squares)

    def only(self, chosen: Sequence[int]) -> Decays:
        """Return some of the records."""
        return replace(
            self,
            records=[self.records[i] for i in chosen],
            matrices=[self.matrices[i] for i in chosen],
            squares=[self.squares[i] for i in chosen],
        )

    def nodes(self, values: Floats, start: Complexes) -> Complexes:
        """Return `integrate` of values (parameters, columns), start (modes, columns, records)."""
        return integrate(values, start, self.reference, self.carrier, self.step, self.steps)

    def signals(self, law: SlowLaw, start: Complexes) -> list[Floats]:
        """Return signals (channels, samples) of each record.

        `start` (modes, records) are the initial amplitudes.
        """
        nodes = self.nodes(law.values[:, np.newaxis], start[:, np.newaxis])
        return [
            (matrix @ as_columns(nodes, i)[:, 0]).reshape(record.signal.shape)
            for i, (record, matrix) in enumerate(zip(self.records, self.matrices, strict=True))
        ]
