"""Whatever is in a file, it is read or refused in one line: no traceback, no endless work."""

import shutil
import signal
import warnings
from contextlib import contextmanager

import numpy as np
import pytest
from elastic import cantilever as elastic_contacts
from fuzz import mutated_model, mutated_scene

from slipmode import rom, runner
from slipmode.fmu import Component

PATIENCE = 30.0  # [s] of the processor: no input takes a tenth of it
SHIPPED = runner.shipped_scenes()
SCENES = [path.read_text() for path in SHIPPED.values()]
SCENES.append("""
[structure]
matrices = "structure.npz"
damping = 0.01
[[contacts]]
law = "iwan"
force = 1.0
stiffness = 20.0
chi = -0.5
beta = 0.1
[limits]
scale = [[0, 1.0], [50, 2.0]]
[modes]
A = 1
[forcing.A]
vector = [0.1, 1.0, 0.0, 0.0]
amplitude = 0.15
frequency = [[0, 1.60], [100, 1.65]]
[initial]
A = [0.5, -0.5]
[run]
duration = 100.0
step = 1.0
""")


@contextmanager
def at_most(seconds):
    """Ends work that takes more of this process's own time, as endless work would."""

    def give_up(number, frame):
        raise AssertionError(f"no end after {seconds:g} s of the processor")

    before = signal.signal(signal.SIGVTALRM, give_up)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def refusals(path, contents, use):
    """How many of the contents, each written to the path, `use` refuses; at worst in one line."""
    refused = 0
    for number, content in enumerate(contents):
        path.write_bytes(content)
        try:
            with warnings.catch_warnings(), at_most(PATIENCE):
                warnings.simplefilter("error")
                use(path)
        except rom.SlipmodeError as refusal:
            assert "\n" not in str(refusal), f"input {number}: {refusal}"
            refused += 1
        except Exception as error:
            pytest.fail(f"input {number}: {error!r}\n{content[:600]!r}")
    return refused


@pytest.mark.parametrize("count", [1000, pytest.param(80_000, marks=pytest.mark.slow)])
def test_no_scene_raises_anything_but_a_refusal(count, tmp_path):
    rom.two_mass().save(tmp_path / "structure.npz")
    for matrices in SHIPPED["blade"].parent.glob("*.npz"):
        shutil.copy(matrices, tmp_path)
    random = np.random.default_rng(1)
    scenes = (mutated_scene(SCENES[k % len(SCENES)], random) for k in range(count))
    refused = refusals(tmp_path / "scene.toml", scenes, runner.load_scene)
    assert 0.5 * count < refused < 0.95 * count  # neither all harmless nor all hopeless


def load_and_use(path):
    """Everything that is read from a model."""
    model = rom.Model.load(path)
    rom.decay_rates(model, 0.5 * model.table.amplitude_range)
    component = Component(model, contact=model.harmonics is not None, warned=False)
    carriers = zip("AB", model.reduced.carrier, strict=False)
    component.set_inputs(**{f"frequency_{mode}": carrier for mode, carrier in carriers})
    component.do_step(0.0, 1e-3)


@pytest.mark.parametrize("count", [150, pytest.param(20_000, marks=pytest.mark.slow)])
def test_no_model_file_raises_anything_but_a_refusal(count, tmp_path):
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    models = [
        rom.tabulate(reduced, rom.Tanh(2.0, 0.1), (4.0,), 1e-1, harmonics=5),
        rom.tabulate(rom.reduce(rom.two_mass()), rom.Coulomb((2.0, 1.0)), (2.0, 1.0), 1e-1),
        elastic_contacts.model("mixed", (0,)),
    ]
    whole = []
    for model in models:
        model.save(tmp_path / "whole.rom")
        whole.append((tmp_path / "whole.rom").read_bytes())
    random = np.random.default_rng(2)
    files = (mutated_model(whole[k % len(whole)], random) for k in range(count))
    refused = refusals(tmp_path / "model.rom", files, load_and_use)
    assert 0.8 * count < refused < count
