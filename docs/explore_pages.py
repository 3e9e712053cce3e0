"""Pages of scenes (slipmode explore) inside the documentation, where zig can compile them."""

import importlib.util
import re
from pathlib import Path

from slipmode import runner

_MARK = re.compile(r"<!-- explore ([\w-]+) -->")
FOLDER = "explore"


def can_be_written() -> bool:
    """Whether the compiler is installed."""
    return importlib.util.find_spec("ziglang") is not None


def with_pages(page: str, text: str, output: Path) -> str:
    """Replace `<!-- explore SCENE -->` by the page of the scene, written into `output`."""

    def frame(mark: re.Match[str]) -> str:
        name = mark[1]
        if not can_be_written():
            return f"The page of `{name}` is not here: it needs `slipmode[explore]`."
        target = output / FOLDER / f"{name}.html"
        if not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            runner.explore(name, target)
        address = f"{'../' * page.count('/')}{FOLDER}/{name}.html"
        return (
            f'<iframe class="explore" src="{address}#play=0" title="{name}" loading="lazy">'
            f'</iframe>\n\n<a class="explore" href="{address}">Open it in a window of its own</a>'
        )

    return _MARK.sub(frame, text)
