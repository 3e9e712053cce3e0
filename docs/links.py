"""Whether the addresses that the pages name can be reached: `make docs-links`."""

import json
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).parent
NO_CONNECTION = (
    "NameResolution",
    "Max retries",
    "ProxyError",
    "Network is unreachable",
    "timed out",
)


def verdict(lines: list[dict[str, str]]) -> tuple[int, str]:
    """Exit status and words for what Sphinx found: 0 all reached, 1 broken, 2 no network."""
    checked = [line for line in lines if line["status"] in ("working", "redirected", "broken")]
    broken = [line for line in checked if line["status"] == "broken"]
    reached = len(checked) - len(broken)
    if broken and not reached and all(_unreached(line["info"]) for line in broken):
        return 2, f"no network here: none of {len(broken)} external links was checked"
    words = [
        f"{each['filename']}:{each['lineno']}: {each['uri']}: {each['info']}" for each in broken
    ]
    return int(bool(broken)), "\n".join([*words, f"{reached} external links reached"])


def _unreached(info: str) -> bool:
    return any(words in info for words in NO_CONNECTION)


def main() -> int:
    """Check the links and print the verdict."""
    output = DOCS.parent / "build" / "links"
    # the examples need not run for their links
    options = ("-q", "-b", "linkcheck", "-D", "plot_gallery=False")
    subprocess.run((sys.executable, "-m", "sphinx", *options, DOCS, output), capture_output=True)
    lines = (output / "output.json").read_text(encoding="utf-8").splitlines()
    status, words = verdict([json.loads(line) for line in lines])
    print(f"docs-links: {words}")
    return status


if __name__ == "__main__":
    sys.exit(main())
