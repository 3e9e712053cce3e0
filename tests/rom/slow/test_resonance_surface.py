"""Resonance surfaces: drawn, as a table, and in the units asked for."""

import numpy as np
import pytest

from slipmode import rom
from slipmode.rom import SlipmodeError

HERTZ = rom.Units("Hz", "mm")


@pytest.fixture(scope="module")
def surface():
    model = rom.tabulate(rom.reduce(rom.two_mass(beta=0.01)), rom.Coulomb(2.0), (4.0, 2.0), 1e-2)
    axes = np.linspace(0.95, 1.0, 4), np.linspace(1.6, 1.7, 3)
    return rom.resonance(model, ({0: 0.15}, {1: 0.25}), *axes)


def test_columns_have_a_row_per_pair_of_frequencies(surface):
    columns = surface.columns(dof=1, units=HERTZ)
    assert {values.shape for values in columns.values()} == {(12,)}
    k = 2 * 3 + 1  # A 2, B 1
    assert columns["frequency_A [Hz]"][k] == pytest.approx(surface.frequency_A[2] / (2 * np.pi))
    assert columns["frequency_B [Hz]"][k] == pytest.approx(surface.frequency_B[1] / (2 * np.pi))
    assert columns["B_re"][k] + 1j * columns["B_im"][k] == surface.amplitude[2, 1, 1]
    size = 2e3 * abs(surface.mode_shapes[1, 1] * surface.amplitude[2, 1, 1])
    assert columns["B at DOF 1 [mm]"][k] == pytest.approx(size)


def test_it_is_drawn_as_it_is(surface):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    axes = surface.plot(figure.subplots(1, 2), units=HERTZ)
    for j, ax in enumerate(axes):
        (mesh,) = ax.collections
        drawn = np.asarray(mesh.get_array()).reshape(3, 4)
        np.testing.assert_allclose(drawn, np.abs(surface.amplitude[..., j]).T)
        assert ax.get_xlabel() == "frequency A [Hz]"


def test_a_dof_that_is_not_there_is_named(surface):
    with pytest.raises(SlipmodeError, match=r"^dof: must be 0 to 3, got 4"):
        surface.displacement(4)


def test_it_is_a_table_of_pandas(surface):
    pytest.importorskip("pandas")
    assert surface.to_dataframe().shape == (12, 6)
