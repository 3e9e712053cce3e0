"""Friction terms and power against the hysteresis loops of the contacts in time."""

import numpy as np
from elastic.family import member

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation


def loop_power(displacement, law, contact, rate):
    """Mean power of one Jenkins element over the second of two equal periods, (samples,)."""
    stiffness = np.broadcast_to(law.stiffness, contact + 1)[contact]
    limit = np.broadcast_to(law.limit, contact + 1)[contact]
    twice = np.append(np.tile(displacement, 2), displacement[0])
    force, work = 0.0, 0.0
    for k in range(1, twice.size):
        step = twice[k] - twice[k - 1]
        after = np.clip(force + stiffness * step, -limit, limit)
        work += 0.5 * (force + after) * step * (k > displacement.size)
        force = after
    return work * rate / (2.0 * np.pi)


def test_the_power_is_that_of_the_loops_where_forces_move_contacts_in_other_directions():
    """The force also acts on the contacts directly: its reaction is not symmetric."""
    case = member(9)
    carrier = case.frequency[:1]
    reduced = rom.reduce(
        case.structure,
        case.modes[:1],
        law=case.law,
        carrier=carrier,
        force_patterns=case.force[:1],
        smallest_response=1e-3,
    )
    problem = ContactProblem.of(reduced, case.law, highest=9)
    a = case.scale[0]
    terms = problem.on(Discretisation(1024, 1), 1e-9).solve([[a]])
    assert terms.residual[0] < 1e-9
    orders, P = np.array(terms.orders)[:, 0], terms.P[0]
    moved = np.einsum("qcd,qd->qc", problem.forces.reaction, P)
    moved[0] -= a * problem.forces.coupling[0]
    moved -= P @ reduced.stiffness  # static flexibility, its sign changed
    angle = np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)
    y = 2.0 * np.real(np.exp(1j * np.outer(angle, orders)) @ moved)
    power = sum(loop_power(y[:, c], case.law, c, carrier[0]) for c in range(y.shape[1]))
    assert abs(terms.power[0] / power - 1.0) < 1e-3
