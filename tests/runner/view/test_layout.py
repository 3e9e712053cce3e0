"""What stands beside the drawings: quantities with readable units, windows, words."""

import numpy as np
import pytest

from slipmode.rom import Units
from slipmode.runner import load_scene, parse_scene, run
from slipmode.runner.recording import channels
from slipmode.runner.view.labels import (
    MOTION_PLOTS,
    find_plots,
    in_units,
    label,
    readable,
    readable_scale,
    reading,
    titled,
)
from slipmode.runner.view.phase_portraits import Portrait, portraits
from slipmode.runner.view.samples import Extents, Latest
from slipmode.runner.view.views import _in_rows, _name


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.000174, "m", "174 µm"),
        (-0.0012, "m", "-1.2 mm"),
        (0.253, "m", "0.253 m"),
        (0.09999, "m", "100 mm"),
        (28.3, "N", "28.3 N"),
        (12000.0, "N", "12 kN"),
        (3e-12, "m", "0.003 nm"),
        (0.0, "m", "0 m"),
        (1.3e-4, "kg^0.5 m", "0.00013 kg^0.5 m"),
    ],
)
def test_quantities_are_written_as_people_write_them(value, unit, text):
    assert readable(value, unit) == text


@pytest.mark.parametrize("batch", [7, 50, 1000])
def test_windows_are_found_however_their_samples_arrive(batch):
    times = np.concatenate((np.arange(0, 300), np.arange(5000, 5200))) * 1000
    found = Latest()
    for start in range(0, len(times), batch):
        found.extend(times[start : start + batch, np.newaxis])
    assert found.windows() == [(0, 299_000), (5_000_000, 5_199_000)]


def test_a_long_window_is_shown_from_where_it_is_readable():
    found = Latest()
    found.extend(np.arange(10_000)[:, np.newaxis])
    assert found.windows() == [(10_000 - 2048, 9_999)]


def response() -> Portrait:
    listed = [channels.modes(("A",)), channels.forcing(("A",))]
    (found,) = (each for each in portraits(listed) if each.entity.startswith("/response"))
    return found


def test_a_sweep_is_drawn_from_its_least_frequency_and_from_zero():
    path = np.array([[0.94, 0.5], [0.98, 3.0], [1.02, 1.5]])
    points, marks = response().placed(path)
    np.testing.assert_allclose(points, [[-1, -2 / 3], [0, 1], [1, 0]], atol=1e-12)
    assert list(marks.values()) == ["0.94", "1.02 rad/s", "|A|: 0 to 3 kg^0.5 m"]
    assert response().has_picture(path)
    assert not response().has_picture(path * (0, 1) + (0.98, 0))  # no sweep


def test_the_words_are_of_the_views_that_are_there():
    words = reading(["Modal amplitude |A|", "Contact 0 over the phases of both carriers"])
    assert "The white point" in words and "Hysteresis" not in words


TWO_WINDOWS = "[[contact]]\nwindow = [20.0, 30.0]\nsamples_per_period = 32\n" * 2


def test_windows_apart_have_views_of_their_own(tmp_path, viewer):
    scene = load_scene("one-mode")
    text = scene.text[: scene.text.index("[[contact]]")]
    text += TWO_WINDOWS.replace("[20.0, 30.0]", "[200.0, 230.0]", 1)
    recording = run(parse_scene(text, tmp_path), tmp_path)
    viewer.open(str(recording.rrd))
    found = [view.name for view in viewer.get_state().views]
    assert found.count("Friction force [N]") == 2


def test_drawings_stand_two_in_a_row_as_long_as_these_are_few():
    few = [["A"], ["Contacts"], ["0", "1", "2"]]
    assert _in_rows(few) == [["A"], ["Contacts"], ["0", "1"], ["2"]]
    many = [["A", "B", "Contacts"], [], ["0", "1", "2"], ["full 0", "full 1", "full 2"]]
    assert _in_rows(many) == [group for group in many if group]


@pytest.mark.parametrize(
    ("low", "high", "scale"),
    [
        (0.0, 3.0, (0.0, 3.15)),  # labels 0, 1, 2, 3
        (0.0, 6.0, (0.0, 10.5)),  # labels 0 and 10
        (-0.25, 0.25, (-0.2625, 0.2625)),
        (-6.5, 6.5, (-10.5, 10.5)),
        (63.0, 63.5, None),  # a narrow sweep is fitted by the viewer
        (0.15, 0.25, (0.0, 0.2625)),  # forces of two modes
        (0.0, 0.0, None),
    ],
)
def test_a_scale_has_more_labels_than_zero(low, high, scale):
    assert readable_scale(low, high) == (scale and pytest.approx(scale))


def test_a_plot_has_its_unit_in_the_title_and_its_swing_in_the_legend():
    contacts = [channels.contact(0), channels.contact(1)]
    units = Units(displacement="mm")
    shown = [in_units(channel, units)[0] for channel in contacts]
    (title,) = (name for name in find_plots(shown, MOTION_PLOTS) if "displacement" in name)
    assert titled(title, find_plots(shown, MOTION_PLOTS)[title]) == "Contact displacement [mm]"
    extents = Extents()
    extents.extend("/contact/0", np.arange(2), np.array([[-3.0, 0.0, 0.0], [2.5, 1.0, 2.0]]))
    assert _name(shown[0], 0, extents) == "x contact 0: ±3"
    assert _name(shown[0], 2, extents) == "f contact 0"
    assert extents.times == (0, 1)


def test_the_legend_of_the_power_balance_names_every_term():
    names = [label(channels.energy(), k) for k in range(5)]
    assert {"input", "contacts", "structural damping", "change of energy"} == set(names)
