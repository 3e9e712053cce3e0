"""Tables of given rates of free vibration, and the samples of a model that are such rates.

With s_j = -delta_j + i omega_j, and s_0j at rest, the friction terms and their rate correction are
as in `rom.model_of_rates`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from slipmode.rom.arrays import Complexes, Floats, in_one_line
from slipmode.rom.contact.error_norm import ErrorNorm
from slipmode.rom.errors import SlipmodeError
from slipmode.rom.laws.no_contacts import NoContacts
from slipmode.rom.reduction.combination import tabulated_orders
from slipmode.rom.reduction.modes_alone import modes_alone
from slipmode.rom.reduction.reduced import Reduced
from slipmode.rom.table.hermite import Table, make_table, surface_values
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.table.model import Model
from slipmode.rom.table.refinement.sampling import amplitude_pairs

AnyModel = TypeVar("AnyModel", bound=Model | ToneModel)


def sample_of(model: AnyModel, sample: int) -> AnyModel:
    """Return the model with one of its samples as its rates.

    Parameters
    ----------
    model : Model
        Model of `rom.model_of_rates` with samples, or of an identification.
    sample : int
        1 to the number of samples; 0 is the model itself.

    Returns
    -------
    Model
        Model with the damping and frequency of the sample, and without samples.

    Raises
    ------
    SlipmodeError
        If the model has no such sample. Only models of rates, without contacts, have samples.
    """
    samples = model.samples if isinstance(model, Model) else None
    count = 0 if samples is None else len(samples)
    if not isinstance(sample, int | np.integer) or not 0 <= sample <= count:
        allowed = (
            f"must be 0 to {count}" if count else "must be 0, because the model has no samples"
        )
        raise SlipmodeError(f"sample = {in_one_line(sample)}: {allowed}")
    if samples is None or sample == 0 or isinstance(model, ToneModel):
        return model
    s = samples[sample - 1]
    points, at_rest = node_amplitudes(model.table), s[0, 0]
    reduced = modes_at_rest(at_rest, model.reduced.mode_shapes)
    S, orders = friction_terms(s, at_rest, points), tabulated_orders((), model.modes)
    loss = ErrorNorm.of(reduced, model.table.amplitude_range).loss
    table = make_table(model.table.node_a, model.table.node_b, S, orders, loss)
    return replace(model, reduced=reduced, table=with_rate_correction(table, s), samples=None)


def node_amplitudes(table: Table) -> Floats:
    """Return the amplitudes at the nodes, (n_a, n_b, modes)."""
    return amplitude_pairs(table.node_a, table.node_b, table.modes)


def friction_terms(s: Complexes, at_rest: Complexes, amplitudes: Floats) -> Complexes:
    """Return S_j, and no power that is lost elsewhere, (..., modes + 1)."""
    S = (s - at_rest) * (s - at_rest.conj()) * amplitudes
    return np.concatenate((S, np.zeros((*S.shape[:-1], 1))), axis=-1)


def with_rate_correction(table: Table, s: Complexes) -> Table:
    """Return the table with the rate correction of s_j (n_a, n_b, modes), for exact decays."""
    modes, nodes, points = table.modes, (table.node_a, table.node_b), node_amplitudes(table)
    through = surface_values(*nodes, s, [(0, 0)] * modes).view(complex)
    slopes = through[:, :, 1 : 1 + modes].swapaxes(2, 3)  # by j and k
    samples = (points[..., np.newaxis] * slopes).reshape(*points.shape[:2], modes**2)
    odd = [(j != k, j != k) for j in range(modes) for k in range(modes)]
    return replace(table, rate_correction=surface_values(*nodes, samples, odd))


def modes_at_rest(at_rest: Complexes, mode_shapes: Floats) -> Reduced:
    """Return modes without contacts that have the rates s_0j at rest."""
    natural, damping = np.abs(at_rest), -2.0 * at_rest.real
    return modes_alone(natural, damping, mode_shapes, NoContacts().elements(0))
