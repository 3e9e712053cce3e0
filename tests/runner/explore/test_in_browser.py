"""Pages in a real browser, without a window and without a network."""

import csv
import io
import shutil
import time
from contextlib import contextmanager
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from slipmode import runner

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
OPTIONS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")
SIZES = {"desk": (1280, 800), "phone": (390, 844)}

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


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """The two-mode scene and the blade."""
    pytest.importorskip("ziglang", reason="needs slipmode[browser]")
    folder = tmp_path_factory.mktemp("pages")
    return {name: runner.explore(name, folder / f"{name}.html") for name in ("two-mode", "blade")}


@pytest.fixture
def opened(chromium, pages):
    """Opens a page; it must not say anything to the console, nor ask for anything."""

    @contextmanager
    def open_page(name, settings="play=0", size="desk", scheme="light", before="", **options):
        said = []
        width, height = SIZES[size]
        view = {"width": width, "height": height}
        page = chromium.new_page(viewport=view, color_scheme=scheme, **options)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: said.append(request.url))
        page.add_init_script(before)
        page.goto(f"{pages[name].as_uri()}#{settings}")
        yield page
        page.close()
        own = pages[name].as_uri()
        assert [each for each in said if not each.startswith((own, "data:", "blob:"))] == []

    return open_page


def ready(page):
    page.wait_for_selector("#readings dd")
    return page


def test_it_plays_pauses_and_starts_again(opened):
    with opened("two-mode", "speed=1000") as page:
        ready(page)
        deadline = time.monotonic() + 30.0
        while page.evaluate("slipmode.history.count") < 40 and time.monotonic() < deadline:
            time.sleep(0.05)
        page.click("#play")
        assert page.inner_text("#play") == "Play"
        before = page.evaluate("slipmode.history.count")
        assert before >= 40
        page.keyboard.press("Escape")
        page.click("#perturb")
        assert page.evaluate("slipmode.history.count") == before + 1
        page.click("#restart")
        assert page.evaluate("slipmode.history.latest(['time'], 9)[0].length") == 1
        page.wait_for_selector("#readings dd:text('0.000 s')", timeout=5000)  # a frame later


def test_a_refused_value_is_said_at_its_field_and_the_last_one_stays(opened):
    with opened("two-mode") as page:
        ready(page)
        page.fill("#frequency_A", "50")
        page.keyboard.press("Enter")
        assert "frequency_A: must be" in page.inner_text("#frequency_A-refusal")
        assert page.get_attribute("#frequency_A", "aria-invalid") == "true"
        assert float(page.input_value("#frequency_A")) == 0.98
        page.fill("#frequency_A", "0.97")
        page.keyboard.press("Enter")
        assert page.is_hidden("#frequency_A-refusal")
        assert page.evaluate("slipmode.settings.frequency_A") == 0.97
        page.fill("#speed input >> nth=0", "0")
        page.keyboard.press("Enter")
        assert "from 1 to 10000" in page.inner_text("#speed-refusal")


def test_a_run_that_leaves_the_friction_table_stops_and_says_so(opened):
    with opened("blade", "force_A=29&frequency_A=1978&limit_scale=1&speed=500&play=1") as page:
        ready(page)
        page.wait_for_selector("#message:not([hidden])")
        assert "an amplitude is outside the friction table" in page.inner_text("#message")
        assert page.inner_text("#play") == "Play"
        page.fill("#force_A", "5")
        page.keyboard.press("Enter")
        page.click("#play")
        assert page.is_hidden("#message")
        time.sleep(0.3)
        assert page.inner_text("#play") == "Pause"


def test_a_link_reproduces_the_settings(opened):
    settings = (
        "force_A=0.1&frequency_A=0.97&force_B=0&frequency_B=1.66&speed=200&swept=1&contact=1"
    )
    with opened("two-mode", f"{settings}&play=0") as page:
        ready(page)
        values = page.evaluate("slipmode.settings")
        assert values == {
            **{"force_A": 0.1, "frequency_A": 0.97, "force_B": 0, "frequency_B": 1.66},
            **{"speed": 200, "swept": 1, "contact": 1, "play": 0},
        }
        page.fill("#force_A", "0.12")
        page.keyboard.press("Enter")
        time.sleep(0.5)
        assert "force_A=0.12&" in page.evaluate("location.hash")
        page.evaluate("location.hash = '#force_A=0.05&play=0'")
        time.sleep(0.2)
        assert float(page.input_value("#force_A")) == 0.05


def test_the_run_is_saved_as_csv(opened):
    with opened("two-mode") as page:
        ready(page).evaluate("slipmode.advance(10)")
        with page.expect_download() as saved:
            page.click("#export")
        assert saved.value.suggested_filename == "two-mode.csv"
        rows = list(csv.reader(Path(saved.value.path()).read_text().splitlines()))
    assert rows[0][:4] == ["time [s]", "A_re [kg^0.5.m]", "A_im [kg^0.5.m]", "A_abs [kg^0.5.m]"]
    numbers = np.array(rows[1:], dtype=float)
    assert numbers.shape == (9, len(rows[0])) and np.isfinite(numbers).all()
    assert numbers[-1, 0] == pytest.approx(10 * 2.0 * np.pi)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_plots_are_drawn_and_fit_the_window(opened, size, scheme):
    with opened("blade", "speed=500", size, scheme) as page:
        ready(page)
        time.sleep(1.0)
        assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size][0]
        for figure in ("amplitudes", "curve", "loop", "force", "displacement"):
            shot = page.locator(f"#{figure} .plot").screenshot()
            picture = matplotlib.image.imread(io.BytesIO(shot))[..., :3]
            coloured = np.count_nonzero(np.ptp(picture, axis=2) > 0.2)
            assert coloured > 300, figure
        light = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (light == "rgb(246, 247, 249)") == (scheme == "light")
