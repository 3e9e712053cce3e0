"""The picture of the blade's page in the README: its preload is dragged from stuck to free.

python docs/explore_picture.py docs/explore-blade.png

It needs slipmode[browser,pictures] and Chromium.
"""

import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from slipmode import runner

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
# From rest with stuck dampers; then the preload falls along the logarithmic slider, until the
# dampers are free.
DRAG = """() => {
    const control = slipmode.inputs.find(({ input }) => input.name === "limit_scale");
    const { most } = control.input, [free, moves] = [0.4, 1000];
    slipmode.core.restart();
    slipmode.history.clear();
    for (let k = 0; k < 120; k++) slipmode.advance(1);
    for (let k = 0; k <= moves; k += 4) {
        control.set(most * (free / most) ** (k / moves));
        slipmode.advance(4);
    }
    control.show();
}"""


def picture(path: Path) -> None:
    """Write the picture."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        page_file = runner.explore("blade", Path(folder) / "blade.html")
        browser = started.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu"]
        )
        view = {"width": 1280, "height": 800}
        page = browser.new_page(viewport=view, device_scale_factor=1.5)
        page.goto(f"{page_file.as_uri()}#limit_scale=15&play=0")
        page.wait_for_selector("#readings dd")
        page.evaluate(DRAG)
        page.wait_for_timeout(500)
        shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        browser.close()
    shot.quantize(96, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    picture(Path(sys.argv[1]))
