"""Displacements from rest, beats and transients included, beside time integration."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from beside_oracle import run, system_of, vector
from oracles.time_integration import integrate

from slipmode import rom

pytestmark = pytest.mark.oracle

DURATION, SAMPLING = 600.0, 0.5  # [s]: 94 periods of mode A, 5 relaxation times
TIMES = SAMPLING * np.arange(1, round(DURATION / SAMPLING) + 1)
BOTH, FREQUENCIES = (0.15, 0.25), (0.98, 1.65)
# Forces that reach the slip thresholds |A| = 1, |B| = 0.346 without friction.
THRESHOLD = (0.0816, 0.1206)


@dataclass(frozen=True)
class Case:
    """The two masses under a force on each mass, `stiffness` instead of the usual values."""

    law: rom.Friction
    force: tuple[float, ...] = BOTH
    frequency: tuple[float, ...] = FREQUENCIES
    reach: tuple[float, ...] = (4.2, 2.0)
    tolerance: float = 3e-3
    bound: float = 5e-3  # RMS of any displacement, relative: the accuracy of runs in slow time
    stiffness: dict = field(default_factory=dict)
    steps: int = 64  # of the integration, per sample


TANH = rom.Tanh(2.0, 0.02)
STIFF = {"k_c1": 2e7, "k_c2": 4e7}
FAST = {
    "tanh": Case(TANH, tolerance=1e-3, bound=2e-3),
    "one mode": Case(TANH, BOTH[:1], FREQUENCIES[:1], (4.2,), 1e-3, 2e-3),
    "Coulomb, one mode": Case(
        *(rom.Coulomb(2.0), BOTH[:1], FREQUENCIES[:1], (4.2,), 1e-3), steps=512
    ),
    "Jenkins, one mode": Case(*(rom.Jenkins(2.0, 50.0), BOTH[:1], FREQUENCIES[:1], (4.2,), 1e-3)),
    "Iwan, one mode": Case(
        rom.Iwan(3.0, 50.0, -0.5, 0.5, sliders=12), (0.25,), (1.6,), (2.5,), 1e-3
    ),
    "-4 A + 3 B on mode A": Case(TANH, (0.1, 0.3), (1.0, 1.66), tolerance=1e-3, bound=2.5e-3),
    "hardly any slip": Case(TANH, THRESHOLD, reach=(1.5, 0.6)),
    "no slip": Case(rom.Coulomb(1e9), reach=(12.0, 8.0), bound=1.6e-3),
    "no friction": Case(rom.Coulomb(0.0), reach=(20.0, 12.0)),
    "contact modes far above the step": Case(TANH, stiffness=STIFF),
}
SLOW = {
    "tanh, alpha 1e-8": Case(rom.Tanh(2.0, 1e-8), steps=512, tolerance=1e-2),
    "Coulomb": Case(rom.Coulomb(2.0), steps=512),
    "Jenkins": Case(rom.Jenkins(2.0, 50.0)),
    "alpha 1e-4": Case(rom.Tanh(2.0, 1e-4), steps=512),
    "weak B under strong A": Case(TANH, (0.3, 0.01), reach=(14.0, 0.8)),
    "1 : 3": Case(TANH, frequency=(0.98, 2.94), reach=(6.0, 3.0), stiffness={"k2": 9.0}),
}


def mode_of(case):
    """Return the modes that are forced: the first ones, or B under a force at its frequency."""
    return (1,) if case.frequency[0] > 1.5 else tuple(range(len(case.force)))


@pytest.mark.parametrize(
    "case",
    [
        *(pytest.param(case, id=name) for name, case in FAST.items()),
        *(pytest.param(case, id=name, marks=pytest.mark.slow) for name, case in SLOW.items()),
    ],
)
@pytest.mark.filterwarnings("ignore::slipmode.rom.ValidityWarning")
def test_displacements_from_rest(case):
    structure, modes = rom.two_mass(beta=0.01, **case.stiffness), mode_of(case)
    patterns = [{mode: size} for mode, size in zip(modes, case.force, strict=True)]
    elastic = case.law if isinstance(case.law, rom.Jenkins | rom.Iwan) else None
    reduced = rom.reduce(
        structure, modes, carrier=case.frequency, law=elastic, force_patterns=patterns
    )
    model = rom.tabulate(reduced, case.law, case.reach, case.tolerance, harmonics=5)
    names = "AB"[: len(modes)]
    inputs = {f"force_{m}": 1.0 for m in names}
    inputs |= {f"frequency_{m}": Omega for m, Omega in zip(names, case.frequency, strict=True)}
    found = run(model, patterns, TIMES, dofs=range(4), **inputs)

    columns = np.array([vector(pattern, 4).real for pattern in patterns]).T
    coarse, exact = (
        integrate(
            *(system_of(structure, case.law), columns),
            *(lambda t: np.cos(np.outer(t, case.frequency)), DURATION, steps * len(TIMES), steps),
        ).x
        for steps in (case.steps // 2, case.steps)
    )
    for dof in range(4):
        size = np.linalg.norm(exact[:, dof])
        if size < 0.1 * np.linalg.norm(exact):  # only the coupling of the contacts moves it
            continue
        own = np.linalg.norm(exact[:, dof] - coarse[:, dof]) / size
        error = np.linalg.norm(found[f"x_{dof}"] - exact[:, dof]) / size
        assert error <= case.bound + own
