"""Shared fixtures: models of the two-mass structure that take about a second to tabulate."""

import os
import signal
from contextlib import ExitStack
from functools import cache

import pytest
from hypothesis import settings

from slipmode import rom, runner
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER

pytest_plugins = ["fmu_fixtures", "native", "faces.browser_core"]

# Drawn cases of a test that does not say how many; `make test-all` takes many.
settings.register_profile("few", max_examples=60, deadline=None)
settings.register_profile("many", max_examples=400, deadline=None)
settings.load_profile("few")

LAW = rom.Tanh(limit=2.0, alpha=0.02)


def pytest_collection_modifyitems(items):
    """Quick ones first."""
    items.sort(key=lambda item: item.get_closest_marker("quick") is None)


@pytest.fixture(scope="session", autouse=True)
def cache_of_the_tests(tmp_path_factory):
    """An empty model cache, so that no test reads or writes the user's; workers share it."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SLIPMODE_CACHE", str(folder / "cache"))
        yield


@pytest.fixture(scope="session", autouse=True)
def interrupts_arrive():
    """Ctrl-C reaches the tests also where the shell that started them ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def viewer():
    """A viewer without a window, where the machine has a graphics driver for it."""
    from slipmode.runner.view.viewer import windowless_viewer

    with ExitStack() as stack:
        try:
            started = stack.enter_context(windowless_viewer())
            started.take_screenshot(max_size=64)
        except (RuntimeError, ConnectionError) as error:
            pytest.skip(f"no software renderer on this machine: {str(error).splitlines()[0]}")
        yield started


@pytest.fixture(scope="session")
def shipped_scene(tmp_path_factory):
    """A shipped scene's recording by its name; each is run once."""
    folder = tmp_path_factory.mktemp("shipped")
    return cache(lambda name: runner.run(name, folder))


@pytest.fixture(scope="session")
def two_mode_model():
    """Both modes, amplitudes up to 4, consistent formulation, with harmonics."""
    reduced = rom.reduce(rom.two_mass())
    return rom.tabulate(reduced, LAW, amplitude=(4.0, 4.0), harmonics=RESPONSE_ORDER)


@pytest.fixture(scope="session")
def paper_model():
    """Both modes, amplitudes up to 4, paper formulation."""
    return rom.tabulate(rom.reduce(rom.two_mass(), formulation="paper"), LAW, amplitude=(4.0, 4.0))


@pytest.fixture(scope="session")
def one_mode_model():
    """Mode A alone, amplitudes up to 4, consistent formulation."""
    return rom.tabulate(rom.reduce(rom.two_mass(), modes=(0,)), LAW, amplitude=(4.0,))
