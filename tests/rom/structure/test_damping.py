"""Damping by ratios, a loss factor and Rayleigh's coefficients."""

import numpy as np
import pytest
import scipy.sparse

from slipmode import rom
from slipmode.rom import SlipmodeError

pytestmark = pytest.mark.quick

MASS = np.diag([1.0, 2.0, 1.5, 1.0])
STIFFNESS = 3.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)


def structure(damping, store=np.array):
    return rom.Structure(store(MASS), store(STIFFNESS), damping, contact=[3])


@pytest.mark.parametrize("store", [np.array, scipy.sparse.csc_array])
def test_rayleigh_damping_is_its_matrix(store, tmp_path):
    given = structure(rom.Rayleigh(0.3, 0.02), store)
    C = 0.3 * MASS + 0.02 * STIFFNESS
    np.testing.assert_allclose(np.asarray(given.damping @ np.eye(4)), C, rtol=1e-15)
    assert given.beta is None
    given.save(tmp_path / "saved.npz")
    loaded = rom.load_structure(tmp_path / "saved.npz")
    np.testing.assert_array_equal(loaded.damping @ np.eye(4), given.damping @ np.eye(4))
    assert structure(rom.Rayleigh(0.0, 0.02)).beta == 0.02


def test_ratios_are_those_of_the_modes():
    frequency = rom.reduce(structure(0.0)).frequency
    found = rom.reduce(structure(rom.Rayleigh.from_ratios((0.01, 0.012), frequency)))
    np.testing.assert_allclose(
        found.modal_damping / (2 * found.frequency), [0.01, 0.012], rtol=1e-12
    )
    one = rom.reduce(structure(rom.Rayleigh.from_ratios((0.01,), frequency[:1])), modes=(0,))
    assert rom.Rayleigh.from_ratios(0.01, frequency[0]) == rom.Rayleigh.from_ratios(
        (0.01,), frequency[:1]
    )
    assert rom.Rayleigh.from_loss_factor(0.02, frequency[0]) == rom.Rayleigh.from_ratios(
        0.01, frequency[0]
    )
    assert one.modal_damping[0] / (2 * one.frequency[0]) == pytest.approx(0.01, rel=1e-12)


def test_a_loss_factor_takes_its_energy_at_each_carrier():
    omega = rom.reduce(structure(0.0)).frequency
    damped = rom.reduce(structure(rom.Rayleigh.from_loss_factor(0.02, omega)))
    # viscous: c omega; hysteretic: eta k, per modal mass
    np.testing.assert_allclose(damped.modal_damping * omega, 0.02 * omega**2, rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rom.Rayleigh(-0.1, 0.0), "damping: alpha must be a finite number >= 0"),
        (lambda: rom.Rayleigh(0.0, np.nan), "damping: beta must be a finite number >= 0"),
        (lambda: rom.Rayleigh.from_ratios((0.01, 0.1), (1.0, 2.0)), "at most by a factor of 2 at"),
        (lambda: rom.Rayleigh.from_ratios((0.01, 0.1), (1.0, 1.0)), "two different frequencies"),
        (lambda: rom.Rayleigh.from_ratios((0.01,), (0.0,)), "must be >= 0 and > 0"),
        (lambda: rom.Rayleigh.from_ratios((0.01, 0.1, 0.1), (1, 2, 3)), "one or two values each"),
    ],
)
def test_refuses_in_one_line(make, message):
    with pytest.raises(SlipmodeError, match=message) as refusal:
        make()
    assert "\n" not in str(refusal.value)
