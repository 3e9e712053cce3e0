"""Steady amplitudes and error estimates of full order: closed forms and the oracle."""

import numpy as np
import pytest
from beside_oracle import with_laws
from oracles.system import Frictional, Tanh, Tone, jenkins
from oracles.time_integration import integrate, steady_harmonics

from slipmode import rom
from slipmode.rom import full

FORCE = ({0: 0.15}, {1: 0.25})
FREQUENCY = (0.98, 1.65)


def excitation_of(structure):
    return full.Excitation.harmonic(structure, FORCE, FREQUENCY, phase=(0.3, -1.0))


def joined():
    """Three masses between walls, a slider and a frictional contact."""
    K = 20.0 * (2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))
    structure = rom.Structure(np.diag([1.0, 1.3, 0.8]), K, 0.2 * np.eye(3), contact=np.eye(3))
    law = rom.Contacts(
        [(rom.Jenkins(0.3, 4.0), (0,)), (rom.FrictionalContact(0.4, 0.3, 4.0, 5.0), (1, 2))]
    )
    return structure, law, [jenkins(0.3, 4.0), Frictional(0.4, 0.3, 4.0, 5.0)]


def rigid():
    return rom.two_mass(beta=0.01), rom.Tanh(2.0, 0.05), [Tanh(2.0, 0.05)] * 2


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("case", "force", "Omega"),
    [
        (rigid, (0.15, 0.0), (0.9825,)),
        (joined, (0.5, 0.0), (4.0,)),
        (joined, (0.5, 0.5), (4.0, 6.8)),
    ],
    ids=["tanh", "elastic", "two tones"],
)
def test_they_agree_with_the_oracle_within_both_stated_errors(case, force, Omega):
    structure, law, laws = case()
    n = len(np.asarray(structure.mass))
    columns = [F * np.eye(n)[j] for j, F in enumerate(force[: len(Omega)])]
    excitation = full.Excitation.harmonic(structure, columns, Omega)
    found = full.steady_amplitude(structure, law, excitation, tolerance=1e-4)
    tones = [Tone(*each) for each in zip(Omega, columns, strict=True)]
    orders = np.eye(len(Omega), dtype=int).tolist()
    tolerance, steps = (1e-5, 512) if len(Omega) == 1 else (1e-3, 128)
    exact = steady_harmonics(with_laws(structure, laws), tones, orders, tolerance, steps)
    off = np.abs(found.amplitude - 0.5 * exact.amplitude)
    assert np.all(off <= found.error + exact.error)
    assert np.all(found.error.max(axis=1) < 1e-2 * np.abs(found.amplitude).max(axis=1))
    again = full.steady_amplitude(structure, law, excitation, tolerance=1e-4, start=found.end)
    assert np.all(np.abs(again.amplitude - found.amplitude) <= 2 * (found.error + again.error))


@pytest.mark.oracle
@pytest.mark.parametrize("detuning", [0.0, 1e-3])
def test_the_rest_of_a_slow_transient_is_in_the_error(detuning):
    """A mass with a damping ratio of 1e-4 changes by 1.2 % of its transient in 20 periods."""
    structure = rom.Structure([[1.0]], [[1.0]], damping=[[2e-4]], contact=[0])
    frequency, tolerance = 1.0 + detuning, 0.01
    excitation = full.Excitation.harmonic(structure, [{0: 1.0}], [frequency])
    options = {"periods": 20, "steps_per_period": 32, "most_windows": 1000}
    result = full.steady_amplitude(
        structure, rom.Coulomb(0.0), excitation, tolerance=tolerance, **options
    )
    exact = 0.5 / (1.0 - frequency**2 + 2e-4j * frequency)
    off = abs(result.amplitude[0, 0] - exact)
    assert off <= result.error[0, 0]
    assert off <= 1.5 * tolerance * abs(exact)
    assert result.error[0, 0] <= 3.0 * tolerance * abs(exact)


@pytest.mark.oracle
@pytest.mark.parametrize("case", [rigid, joined])
def test_converged_bounds_its_error(case):
    structure, law, laws = case()
    n, t_end, points = len(np.asarray(structure.mass)), 60.0, 300

    def signals(t):
        return np.cos(np.outer(t, FREQUENCY) + np.array([0.3, -1.0]))

    columns = np.eye(n)[:, :2] * [0.15, 0.25] * (4.0 if case is joined else 1.0)
    exact, rough = (
        integrate(with_laws(structure, laws), columns, signals, t_end, each * points, each)
        for each in (400, 200)
    )
    excitation = full.Excitation.harmonic(structure, list(columns.T), FREQUENCY, phase=(0.3, -1.0))
    result = full.converged(structure, law, excitation, exact.t, steps_per_period=30)
    W = np.asarray(structure.directions)
    for name, true, coarse in (
        ("displacement", exact.x, rough.x),
        ("velocity", exact.v, rough.v),
        ("contact_displacement", exact.x @ W, rough.x @ W),
        ("contact_velocity", exact.v @ W, rough.v @ W),
    ):
        size = np.linalg.norm(true, axis=0)
        error = np.linalg.norm(getattr(result.motion, name) - true, axis=0) / size
        own = np.linalg.norm(coarse - true, axis=0) / size
        assert np.all(own < 3e-3)
        assert np.all(error <= getattr(result, f"{name}_error") + own), name


def test_what_does_not_become_steady_is_refused():
    structure = rom.two_mass(beta=0.01)
    excitation = excitation_of(structure)
    with pytest.raises(rom.SlipmodeError, match="still changes after 2 windows"):
        full.steady_amplitude(
            structure, rom.Coulomb(0.0), excitation, tolerance=1e-12, most_windows=2
        )
