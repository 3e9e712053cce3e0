"""Pages in a real browser, without a window and without a network."""

import io
import shutil
import time

import matplotlib.image
import numpy as np
import pytest

from slipmode import runner

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
OPTIONS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def chromium():
    playwright = pytest.importorskip("playwright.sync_api", reason="needs slipmode[browser]")
    if BROWSER is None:
        pytest.skip("needs the browser chromium")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=BROWSER, args=OPTIONS)
        yield browser
        browser.close()


@pytest.fixture
def page(chromium, tmp_path):
    """The two-mode scene; it must not say anything to the console, nor ask for anything."""
    pytest.importorskip("ziglang", reason="needs slipmode[browser]")
    own, said = runner.explore("two-mode", tmp_path / "two-mode.html").as_uri(), []
    page = chromium.new_page()
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: said.append(request.url))
    page.goto(f"{own}#speed=1000&play=0")
    page.wait_for_selector("#readings dd")
    yield page
    page.close()
    assert [each for each in said if not each.startswith((own, "data:", "blob:"))] == []


def test_it_plays_pauses_and_draws_all_plots(page):
    page.click("#play")
    deadline = time.monotonic() + 30.0
    while page.evaluate("slipmode.history.count") < 40 and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(1.0)  # until the curve is drawn
    page.click("#play")
    assert page.inner_text("#play") == "Play"
    assert page.evaluate("slipmode.history.count") >= 40
    for figure in ("amplitudes", "curve", "loop", "force", "displacement"):
        shot = page.locator(f"#{figure} .plot").screenshot()
        picture = matplotlib.image.imread(io.BytesIO(shot))[..., :3]
        assert np.count_nonzero(np.ptp(picture, axis=2) > 0.2) > 300, figure


def test_a_refused_value_is_said_at_its_field_and_the_last_one_stays(page):
    page.fill("#frequency_A", "50")
    page.keyboard.press("Enter")
    assert "frequency_A: must be" in page.inner_text("#frequency_A-refusal")
    assert float(page.input_value("#frequency_A")) == 0.155972  # [Hz]
    page.fill("#frequency_A", "0.1545")
    page.keyboard.press("Enter")
    assert page.is_hidden("#frequency_A-refusal")
    assert page.evaluate("slipmode.settings.frequency_A") == pytest.approx(0.1545 * 2 * np.pi)
