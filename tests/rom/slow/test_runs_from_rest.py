"""Runs from rest with elastic contacts: the slow flow with its rate correction, and full order."""

from dataclasses import replace

import numpy as np
import pytest
from elastic.family import Member
from elastic.family_rest import at_full_order, compared, from_rest
from elastic.frictional_beam import LIFT_OFF, SLIDER, TIP, structure

from slipmode import rom

IWAN = rom.Iwan(0.3, 20.0, -0.5, 0.5, sliders=12)


def forced_beam(law, node, force, detuning):
    """The cantilever, its mode A forced at the tip."""
    beam = structure(law, node)
    (omega,) = rom.reduce(beam, (0,), law=law).frequency
    pattern = np.zeros(beam.n_dofs)
    pattern[TIP] = force
    return Member("beam", beam, law, (0,), (pattern,), (omega * (1.0 + detuning),), (1.0,))


@pytest.mark.parametrize(
    ("law", "node", "force", "detuning", "bound", "steady_friction"),
    # measured: 0.40 %, 0.48 %, 0.15 %, 4.2 %, where amplitudes change by 60, 100, 29, 32 % in a
    # cycle; friction as in steady motion: 2.1 %, 0.91 %, 1.2 %, 8.1 %. The second slips for 88 %
    # of the time once it is steady.
    [
        (SLIDER, 5, 0.05, -0.01, 5e-3, 1.8e-2),
        (SLIDER, 5, 0.5, -0.06, 6e-3, 8e-3),
        (IWAN, 5, 0.03, -0.02, 2e-3, 1e-2),
        (LIFT_OFF, 8, 0.05, -0.01, 5e-2, 7e-2),
    ],
    ids=["slider", "slider that hardly sticks", "iwan", "lift-off"],
)
def test_the_rate_correction_brings_strong_contacts_closer(
    law, node, force, detuning, bound, steady_friction
):
    case = forced_beam(law, node, force, detuning)
    reference = at_full_order(case)
    model, run = from_rest(case, reference)
    assert run.error.max() < bound
    assert run.error.max() < run.estimate.max() < 0.4
    bare = replace(model, table=replace(model.table, rate_correction=None))
    assert compared(case, bare, reference).error.max() > steady_friction
