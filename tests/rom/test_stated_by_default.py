"""What the shortest calls state about their error holds on structures that nobody chose.

Forty drawn bodies (tests/support/elastic/family.py) with 1 to 30 Jenkins, Iwan or frictional
contacts that may open, at 1 % and 100 % of the range of their tables, default tolerances.
Reference: the contact problem with all modes and harmonics in four times the steps, at the
frequency of the answer; and integration of the structure itself.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from elastic.family import Member, member

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation, full

SEEDS = range(40)
SHARES = np.array([0.01, 1.0])  # of the range
HIGHEST = 31  # order of the harmonics of the reference


@dataclass
class Drawn:
    """One mode of a member of the family, its law, and its table by the shortest calls."""

    case: Member
    law: rom.Jenkins | rom.Iwan | rom.FrictionalContact
    reduced: rom.Reduced
    model: rom.Model
    amplitude: np.ndarray

    @classmethod
    def of(cls, seed):
        case = member(seed)
        law, mode = case.law, case.modes[0]
        if isinstance(law, rom.Jenkins) and seed % 3 == 0:
            law = rom.Iwan(4.0 * law.limit, law.stiffness, chi=-0.5, beta=0.3)
        reduced = rom.reduce(case.structure, (mode,), law=law, force_patterns=case.force[:1])
        reach = 1.2 * case.scale[0]
        model = rom.tabulate(reduced, law, (reach,), warned=False)
        return cls(case, law, reduced, model, 0.998 * SHARES * reach)

    def friction(self, amplitude, frequency):
        """S of the reference at one amplitude; None where the motion does not converge."""
        at = self.reduced.at_carrier([frequency])
        grid = Discretisation(4 * self.model.accuracy.steps, 1)
        terms = (
            ContactProblem.of(at, self.law, highest=HIGHEST).on(grid, 1e-7).solve([[amplitude]])
        )
        return terms.S[0, 0] if terms.residual[0] < 1e-4 else None


def drawn(seed):
    try:
        return Drawn.of(seed)
    except rom.SlipmodeError as refusal:
        pytest.skip(f"refused: {refusal}")


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(
            seed,
            marks=[pytest.mark.xfail(strict=True, reason="damping 4.4e-5 off, 4.1e-5 stated")]
            if seed == 33
            else [],
        )
        for seed in SEEDS
    ],
)
def test_tables_and_backbones(seed):
    one = drawn(seed)
    omega = one.reduced.frequency[0]
    gamma = one.reduced.modal_damping[0]
    backbone = rom.backbone(one.model, amplitude=one.amplitude)
    for k, a in enumerate(one.amplitude):
        S = one.friction(a, omega)
        if S is None:
            continue
        stated = one.model.friction_error(np.array([a]))[0]
        assert abs(one.model.table(np.array([a]))[0] - S) <= stated
        Omega = backbone.frequency[k]
        S = one.friction(a, Omega)
        if S is None:
            continue
        # omega^2 - Omega^2 + i gamma Omega - S / a = 2 i zeta Omega^2
        exact = np.sqrt(omega**2 - S.real / a)
        zeta = (gamma * Omega - S.imag / a) / (2.0 * Omega**2)
        assert abs(Omega - exact) <= backbone.frequency_error[k]
        assert abs(backbone.damping[k] - zeta) <= backbone.damping_error[k]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_direct_states_and_curves(seed):
    one = drawn(seed)
    Omega, force = one.case.frequency[:1], one.case.force[0]
    try:
        at_forcing = one.reduced.at_carrier(Omega)
        model = rom.tabulate(at_forcing, one.law, one.amplitude[-1:], warned=False)
        curve = rom.response_curve(model, Omega, [force], "force", (0.01, 1.0))
    except rom.SlipmodeError as refusal:
        pytest.skip(f"refused: {refusal}")
    for end, size in ((0, 0.01), (-1, 1.0)):
        if abs(curve.parameter[end] / size - 1.0) > 1e-6:
            continue  # the curve leaves the table before
        excitation = full.Excitation.harmonic(one.case.structure, [size * force], Omega)
        try:
            exact = full.steady_amplitude(
                *(one.case.structure, one.law, excitation),
                outputs=one.reduced.mode_shapes.T @ one.case.structure.mass,
                tolerance=1e-4,
                steps_per_period=256,
            )
            state = rom.steady_state(one.reduced, one.law, Omega, [size * force])
        except rom.SlipmodeError as refusal:
            pytest.skip(f"refused: {refusal}")
        reference = exact.amplitude[0, 0]
        own = 2e-4 * abs(reference)  # of full order: windows, and steps of second order
        assert abs(state.amplitude[0] - reference) <= state.error[0] + own
        assert abs(curve.amplitude[end, 0] - reference) <= curve.error[end, 0] + own
