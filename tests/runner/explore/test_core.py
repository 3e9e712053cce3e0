"""The core of a page, compiled for this machine, beside `Component` and `rom.response_curve`."""

from dataclasses import dataclass

import numpy as np
import pytest
from faces.browser_core import BrowserCore

from slipmode import fmu, rom
from slipmode.fmu.archive.browser import browser_files
from slipmode.fmu.variables.listing import list_variables
from slipmode.rom import Model
from slipmode.runner import Plan, load_scene, make_plan, shipped_scenes
from slipmode.runner.explore.explore import page_options

AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")


@dataclass(frozen=True)
class Page:
    """What a page is made of."""

    plan: Plan
    model: Model
    options: object
    variables: list
    files: bytes

    @classmethod
    def of(cls, scene):
        plan = make_plan(scene.in_slow_time())
        model, _ = plan.model(contact=True, detuning=True)
        options = page_options(plan)
        variables = list_variables(model, True, options)
        files = browser_files(model, plan.excited.force_patterns, options, variables)
        return cls(plan, model, options, variables, files)

    @property
    def inputs(self):
        """Values at the start, by name."""
        return {k: v for k, v in self.options.start.items() if k.startswith(("force", "freq"))}

    def component(self):
        made = fmu.Component(
            self.model,
            self.plan.excited.force_patterns,
            contact=True,
            elastic=self.options.elastic,
            tolerance=self.options.tolerance,
            warned=False,
        )
        made.set_inputs(**self.inputs)
        made.reset(amplitude=self.plan.excited.amplitude)
        return made


@pytest.fixture(scope="module")
def two_mode(tmp_path_factory):
    """The shipped scene with a coarse table, which is quicker to make."""
    scene = tmp_path_factory.mktemp("scene") / "two-mode.toml"
    text = shipped_scenes()["two-mode"].read_text(encoding="utf-8")
    scene.write_text(text.replace("tolerance = 1e-3", "tolerance = 1e-2"), encoding="utf-8")
    return Page.of(load_scene(scene))


@pytest.fixture
def core(two_mode, browser_library):
    opened = BrowserCore(browser_library, two_mode.files, two_mode.variables)
    assert opened.is_open, opened.message()
    return opened


def test_a_run_with_ten_changes_of_inputs_is_that_of_the_component(two_mode, core):
    component, drawn = two_mode.component(), np.random.default_rng(7)
    contacts = two_mode.model.reduced.n_contacts
    forces = slice(10 + 2 * contacts, 10 + 3 * contacts)
    for k in range(11):
        component.do_step(component.time, 1000.0 / 11)
        (found,) = core.play(1000.0 / 11, 1, *AMPLITUDES)
        outputs = component.outputs()
        expected = np.array([outputs[name] for name in AMPLITUDES]).view(complex)
        # measured: 4e-12; on the blade 4e-12, on force-step 2.5e-11
        assert found.view(complex) == pytest.approx(expected, rel=1e-10, abs=0.0)
        beat = core.beat(40)
        expected = [outputs[f"contact_{i}_f"] for i in range(contacts)]
        error = np.abs(beat[0, forces] - expected) / np.abs(beat[:, forces]).max(axis=0)
        assert error.max() < 1e-8  # measured: 1.1e-9; on the blade 3e-9, on force-step 6e-9
        spread = {"force": 0.1, "frequency": 0.003}
        changed = {
            name: value * (1.0 + spread[name[:-2]] * drawn.uniform(-1.0, 1.0))
            for name, value in two_mode.inputs.items()
        }
        component.set_inputs(**changed)
        assert core.set(**changed), (k, core.message())
    assert component.time == pytest.approx(1000.0)
    assert core.message() == ""


def test_motion_over_a_beat_is_that_of_the_component_and_changes_nothing(two_mode, core):
    component = two_mode.component()
    component.do_step(0.0, 300.0)
    component.outputs()  # as the page: contacts are integrated from where they are read
    core.play(300.0, 1, "time")
    before = core.get("time", *AMPLITUDES, "contact_0_x", "contact_0_f")
    beat = core.beat(40)
    assert np.array_equal(core.get("time", *AMPLITUDES, "contact_0_x", "contact_0_f"), before)
    slower, faster = two_mode.inputs["frequency_A"], two_mode.inputs["frequency_B"]
    assert beat[-1, 0] - beat[0, 0] == pytest.approx(2 * 2 * np.pi / slower)  # at least a beat
    assert beat[-1, 0] - beat[0, 0] >= 2 * np.pi / (faster - slower)
    steps = np.diff(beat[:, 0])
    largest = np.abs(beat).max(axis=0)
    for row, step in zip(beat[1:40], steps[:39], strict=True):
        component.do_step(component.time, step)
        expected = np.array(list(component.outputs().values()))
        assert np.abs(row - expected)[10:] == pytest.approx(
            0.0 * row[10:], abs=1e-7 * largest.max()
        )


@pytest.mark.parametrize("mode", [0, 1])
def test_the_response_curve_is_that_of_rom(two_mode, core, mode):
    inputs, span = two_mode.inputs, [(0.95, 1.02), (1.6, 1.72)][mode]
    frequency = [inputs["frequency_A"], inputs["frequency_B"]]
    patterns = two_mode.plan.excited.force_patterns
    force = [inputs[f"force_{m}"] * f for m, f in zip("AB", patterns, strict=True)]
    expected = rom.response_curve(
        two_mode.model, frequency, force, f"frequency_{'AB'[mode]}", span, largest_step=4e-3
    )
    found = core.curve(mode, span)
    assert len(found) >= 250
    assert found[:, 0].min() == pytest.approx(span[0]) and found[:, 0].max() == pytest.approx(
        span[1]
    )
    assert np.all(found[:, 3] == 1.0) == expected.stable.all()
    order = np.argsort(expected.parameter)
    for j in range(2):
        size = np.abs(expected.amplitude[order, j])
        at = np.interp(found[:, 0], expected.parameter[order], size)
        assert found[:, 1 + j] == pytest.approx(at, rel=1e-4)  # as close as lines between points


@pytest.mark.parametrize(
    ("inputs", "reason"),
    [
        ({"frequency_A": 50.0}, "frequency_A: must be 0."),
        ({"frequency_B": -1.0}, "frequency_B: must be > 0"),
        ({"frequency_A": 1.65}, "frequency_A, frequency_B: must differ"),
        ({"force_A": 0.1, "force_B": float("nan")}, "force_B: must be finite, got nan"),
    ],
)
def test_refused_inputs_leave_everything_as_it_was(core, inputs, reason):
    names = ("time", *AMPLITUDES, "force_A", "force_B", "frequency_A", "frequency_B")
    core.play(100.0, 2, "time")
    before = core.get(*names)
    assert not core.set(**inputs)
    assert core.message().startswith(reason)
    assert np.array_equal(core.get(*names), before)
    assert len(core.play(100.0, 2, "time")) == 2 and core.message() == ""


def test_a_run_ends_inside_the_friction_table(two_mode, core):
    assert core.set(force_A=0.5)
    rows = core.play(500.0, 50, "time", "A_abs")
    assert len(rows) < 50
    message = core.message()
    assert "an amplitude is outside the friction table" in message
    assert "lower force_A, now 0.5" in message and "slipmode fmu and explore" in message
    end = two_mode.model.table.amplitude_range[0]
    time, size = core.get("time", "A_abs")
    assert 0.8 * end < size <= end and time == rows[-1, 0]
    assert not core.perturb(1.0) and "perturb: " in core.message()
    assert np.array_equal(core.get("time", "A_abs"), (time, size))
    assert core.set(force_A=0.1) and len(core.play(500.0, 50, "time")) == 50
