"""A picture of a scene's page: limits and preloads, or a static force, are dragged down.

python docs/explore_picture.py blade 15 0.4 docs/explore-blade.png

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
# From rest at the larger factor; then it falls along the logarithmic slider.
DRAG = """([most, least]) => {
    const control = slipmode.inputs.find(({ input }) => input.name === "limit_scale");
    const moves = 1000;
    slipmode.core.restart();
    slipmode.history.clear();
    for (let k = 0; k < 120; k++) slipmode.advance(1);
    for (let k = 0; k <= moves; k += 4) {
        control.set(most * (least / most) ** (k / moves));
        slipmode.advance(4);
    }
    control.show();
}"""


def picture(scene: str, most: float, least: float, path: Path) -> None:
    """Write the picture; `most` and `least` are factors on limits and preloads."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        page_file = runner.explore(scene, Path(folder) / "page.html")
        browser = started.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu"]
        )
        view = {"width": 1280, "height": 800}
        page = browser.new_page(viewport=view, device_scale_factor=1.5)
        page.goto(f"{page_file.as_uri()}#limit_scale={most:g}&play=0")
        page.wait_for_selector("#readings dd")
        page.evaluate(DRAG, [most, least])
        page.wait_for_timeout(500)
        shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        browser.close()
    shot.quantize(96, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    scene, most, least, path = sys.argv[1:]
    picture(scene, float(most), float(least), Path(path))
