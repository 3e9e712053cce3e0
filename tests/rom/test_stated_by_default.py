"""What the shortest calls state about their error holds on structures that nobody chose.

Drawn bodies (tests/support/elastic/family.py) with 1 to 30 Jenkins, Iwan or frictional contacts
that may open, default tolerances, at 1 % and 100 % of a force. Reference: integration in full.
"""

import pytest
from elastic.family import member

from slipmode import rom
from slipmode.rom import full

SEEDS = range(40)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_direct_states_and_curves(seed):
    case = member(seed)
    law, Omega, force = case.law, case.frequency[:1], case.force[0]
    if isinstance(law, rom.Jenkins) and seed % 3 == 0:
        law = rom.Iwan(4.0 * law.limit, law.stiffness, chi=-0.5, beta=0.3)
    try:
        reduced = rom.reduce(case.structure, case.modes[:1], law=law, force_patterns=[force])
        largest = 0.998 * 1.2 * case.scale[0]
        model = rom.tabulate(reduced.at_carrier(Omega), law, (largest,), warned=False)
        curve = rom.response_curve(model, Omega, [force], "force", (0.01, 1.0))
    except rom.SlipmodeError as refusal:
        pytest.skip(f"refused: {refusal}")
    for end, size in ((0, 0.01), (-1, 1.0)):
        if abs(curve.parameter[end] / size - 1.0) > 1e-6:
            continue  # the curve leaves the table before
        excitation = full.Excitation.harmonic(case.structure, [size * force], Omega)
        try:
            exact = full.steady_amplitude(
                *(case.structure, law, excitation),
                outputs=reduced.mode_shapes.T @ case.structure.mass,
                tolerance=1e-4,
                steps_per_period=256,
            )
            state = rom.steady_state(reduced, law, Omega, [size * force])
        except rom.SlipmodeError as refusal:
            pytest.skip(f"refused: {refusal}")
        reference = exact.amplitude[0, 0]
        own = 2e-4 * abs(reference)  # of full order: windows, and steps of second order
        assert abs(state.amplitude[0] - reference) <= state.error[0] + own
        assert abs(curve.amplitude[end, 0] - reference) <= curve.error[end, 0] + own
