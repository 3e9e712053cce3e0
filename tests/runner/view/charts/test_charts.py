"""Charts without time: where things are drawn, and the recordings of studies and curves."""

import numpy as np
import pytest

from slipmode.rom import SlipmodeError
from slipmode.runner import run_study
from slipmode.runner.study.summary.summary import summarise
from slipmode.runner.view.charts import Axis, Chart, Layer, write_charts
from slipmode.runner.view.labels import BLUE


class Stream:
    """What is logged, by its entity."""

    def __init__(self):
        self.logged = {}

    def log(self, entity, drawn, static):
        assert static
        self.logged[entity] = drawn


def drawn(chart):
    stream = Stream()
    chart.draw(stream)
    return stream.logged


def labels(logged):
    return [str(text) for text in logged["/c/labels"].labels.as_arrow_array().to_pylist()]


def places(batch):
    return np.array(batch.as_arrow_array().to_pylist())


def test_points_and_ticks_are_where_their_values_are():
    x, y = np.array([1.0, 2.0, 3.0]), np.array([0.0, np.nan, 4.0])
    layer = Layer(x, y, BLUE, "some", curve=False)
    found = drawn(Chart("/c", "c", Axis("f [Hz]"), Axis("a [um]"), [layer]))
    np.testing.assert_allclose(places(found["/c/layers/0"].positions), [[0, 0], [1.6, -1]])
    texts, at = labels(found), places(found["/c/labels"].positions)
    assert {"f [Hz]", "a [um]", "some", "1", "2", "3", "0", "4"} <= set(texts)
    assert at[texts.index("2")][0] == pytest.approx(0.8)


def test_a_curve_breaks_where_values_are_missing_and_scales_may_be_logarithmic():
    x = np.array([1.0, 10.0, 20.0, 50.0, 100.0])
    layer = Layer(x, np.array([1.0, 1.0, np.nan, 2.0, 2.0]))
    found = drawn(Chart("/c", "c", Axis("x", log=True), Axis("y"), [layer]))
    strips = found["/c/layers/0"].strips.as_arrow_array().to_pylist()
    assert [len(strip) for strip in strips] == [2, 2]
    np.testing.assert_allclose(strips[0], [[0.0, -0.5], [0.8, -0.5]])
    assert {"1", "10", "100"} <= set(labels(found))


def test_values_without_numbers_have_their_names():
    layer = Layer(np.array([0.0, 1.0]), np.array([3.0, 3.0]), curve=False)
    found = drawn(Chart("/c", "c", Axis("law", ("tanh", "coulomb")), Axis("y"), [layer]))
    assert {"tanh", "coulomb"} <= set(labels(found))
    np.testing.assert_allclose(places(found["/c/layers/0"].positions), [[0.4, -1], [1.2, -1]])


def test_a_file_that_cannot_be_written_is_one_line(tmp_path):
    with pytest.raises(SlipmodeError, match=r"there\.rrd: cannot be written: No such file"):
        write_charts(tmp_path / "not" / "there.rrd", "t", [], {})


STUDY = """
[[vary]]
key = "forcing.A.frequency"
values = [0.9, 0.95, 0.98, 1.0, 20.0]
[[vary]]
key = "forcing.A.amplitude"
distribution = "uniform"
low = 0.1
high = 0.15
[sampling]
samples = 8
[outputs]
steady = true
"""


def views_of(viewer, rrd):
    """Names of the views, none of which complains of what it shows."""
    viewer.open(str(rrd))
    viewer.take_screenshot(max_size=64)
    views = viewer.get_state().views
    assert all(view.reports == [] for view in views)
    names = {view.name for view in views}
    viewer.close("all")
    return names


def test_a_study_leaves_a_recording(tmp_path, viewer):
    pytest.importorskip("xarray")
    distributed = pytest.importorskip("distributed")
    path = tmp_path / "study.toml"
    path.write_text(f'scene = "one-mode"\n{STUDY}', encoding="utf-8")
    with distributed.LocalCluster(
        n_workers=1, processes=False, dashboard_address=":0", silence_logs=40
    ) as cluster:
        done = run_study(path, tmp_path, scheduler=cluster.scheduler_address)
    assert summarise(done)[-1] == str(tmp_path / "study.rrd")
    assert views_of(viewer, tmp_path / "study.rrd") == {
        "steady A against forcing.A.frequency",
        "steady A against forcing.A.amplitude",
        "Distribution of steady A",
        "What was found",
        "Failures",
        "Study",
        "Scene",
    }
