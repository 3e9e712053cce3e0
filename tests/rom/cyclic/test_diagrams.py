"""Frequencies by nodal diameter are published; engine orders meet the modes that they excite."""

import numpy as np
import pytest

from slipmode import rom

figures = pytest.importorskip("matplotlib.figure")

NO_CONTACTS = rom.Jenkins(1.0, 1e-3)  # next to nothing


@pytest.fixture(scope="module")
def diagram():
    return rom.nodal_diameter_diagram(rom.lumped_disk(24), NO_CONTACTS)


def test_frequencies_by_nodal_diameter_are_published(diagram):
    """Of pyHarm's tutorial: 88.264, 169.344, 189.302 Hz at nodal diameters 0, 1 and 2."""
    found = diagram.frequency[:3, 0] / (2.0 * np.pi)
    np.testing.assert_allclose(found, [88.264, 169.344, 189.302], atol=6e-4)
    assert diagram.frequency.shape == (13, 3)
    assert (np.diff(diagram.frequency, axis=1) > 0.0).all()
    columns = diagram.columns(rom.Units("Hz"))
    np.testing.assert_allclose(columns["frequency_0 [Hz]"][:3], found)


def test_stuck_contacts_raise_frequencies(diagram):
    stuck = rom.nodal_diameter_diagram(rom.lumped_disk(24), rom.Jenkins(1.0, 5e4), 1)
    assert (stuck.frequency[1:, 0] > diagram.frequency[1:, 0]).all()
    # blade tips that move alike do not strain the contacts between them
    assert stuck.frequency[0, 0] == pytest.approx(diagram.frequency[0, 0], rel=1e-9)


@pytest.mark.parametrize(("order", "diameter"), [(3, 3), (21, -3), (27, 3), (12, 12)])
def test_engine_orders_meet_the_modes_that_they_excite(diagram, order, diameter):
    campbell = diagram.campbell((0.0, 1e5), [order])
    assert [each.mode for each in campbell.crossings] == [0, 1, 2]
    for each in campbell.crossings:
        omega = diagram.frequency[abs(diameter), each.mode]
        assert (each.nodal_diameter, each.frequency) == (diameter, omega)
        assert order * each.rotor_speed * 2.0 * np.pi / 60.0 == pytest.approx(omega)
    lowest = campbell.crossings[0].rotor_speed
    assert len(diagram.campbell((0.9 * lowest, 1.1 * lowest), [order]).crossings) == 1


def test_the_pictures_have_what_they_name(diagram):
    figure = figures.Figure()
    left, right = figure.subplots(1, 2)
    diagram.plot(left, rom.Units("Hz"))
    assert [line.get_label() for line in left.lines] == ["mode 0", "mode 1", "mode 2"]
    campbell = diagram.campbell((2000.0, 8000.0), [3, 4])
    campbell.plot(right, rom.Units("Hz"))
    *orders, marks = right.lines
    assert len(orders) == 2
    x, y = marks.get_data()
    np.testing.assert_allclose(x, campbell.columns()["rotor_speed"])
    np.testing.assert_allclose(y, campbell.columns(rom.Units("Hz"))["frequency [Hz]"])


def test_refuses_in_one_line(diagram):
    with pytest.raises(rom.SlipmodeError, match="families: must be 1 to 3, got 4"):
        rom.nodal_diameter_diagram(rom.lumped_disk(24), NO_CONTACTS, 4)
    with pytest.raises(rom.SlipmodeError, match="rotor_speed: must be two numbers >= 0, ascend"):
        diagram.campbell((10.0, 5.0), [3])
    with pytest.raises(rom.SlipmodeError, match="engine_orders: must be integers from 1"):
        diagram.campbell((5.0, 10.0), [0])
