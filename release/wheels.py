"""Wheels of slipmode for Linux, macOS and Windows and its source archive, all from this machine.

    python release/wheels.py [-o dist] [PLATFORM ...]

The wheel of this machine's own platform is compiled by its own compiler, those of others by zig
(package `ziglang`), all by CMakeLists.txt. They hold no code for Python's own interface, so that
one wheel serves every Python of a platform. `make wheels` calls this.
"""

import argparse
import importlib.util
import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from slipmode.fmu.archive.binaries import TARGETS, host_platform

ROOT = Path(__file__).parents[1]
TOOLCHAIN = ROOT / "release" / "zig.cmake"
# The tag of a wheel names the oldest system that its libraries load on, as TARGETS has it.
TAGS = {
    "x86_64-linux": "manylinux_2_17_x86_64",
    "aarch64-linux": "manylinux_2_17_aarch64",
    "x86_64-darwin": "macosx_11_0_x86_64",
    "aarch64-darwin": "macosx_11_0_arm64",
    "x86_64-windows": "win_amd64",
}
CMAKE_SYSTEMS = {"linux": "Linux", "darwin": "Darwin", "windows": "Windows"}


def build(kind: str, output: Path, settings: list[str], environment: dict[str, str]) -> None:
    """Run `python -m build` without isolation: its own pip would take the platform for ours."""
    options = (f"-C{each}" for each in settings)
    command = (sys.executable, "-m", "build", "--no-isolation", f"--{kind}", "-o", output)
    scripts = os.pathsep.join((sysconfig.get_path("scripts"), os.environ["PATH"]))
    own = os.environ | {"PATH": scripts} | environment
    subprocess.run((*command, *options, ROOT), check=True, env=own)


def wheel(platform: str, output: Path) -> None:
    """Build the wheel of a platform."""
    environment = {"_PYTHON_HOST_PLATFORM": TAGS[platform], "MACOSX_DEPLOYMENT_TARGET": "11.0"}
    with tempfile.TemporaryDirectory() as folder:
        settings = [f"build-dir={folder}"]
        if platform != host_platform():
            (package,) = importlib.util.find_spec("ziglang").submodule_search_locations
            processor, _, system = platform.partition("-")
            environment |= {
                "ZIG": str(Path(package) / "zig"),
                "ZIG_TARGET": TARGETS[platform],
                "ZIG_SYSTEM": CMAKE_SYSTEMS[system],
                "ZIG_PROCESSOR": processor,
            }
            # stripped by its linker already; this machine's strip knows its own files alone
            settings += ["install.strip=false", f"cmake.args=--toolchain={TOOLCHAIN}"]
        build("wheel", output, settings, environment)


def main() -> None:
    """Build what the command line asks for, by default everything."""
    parser = argparse.ArgumentParser(description="wheels of slipmode and its source archive")
    parser.add_argument("platforms", nargs="*", metavar="PLATFORM", help=", ".join(TAGS))
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "dist", metavar="DIR")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.platforms if name not in TAGS]
    if unknown:
        parser.error(f"{unknown[0]} must be one of {', '.join(TAGS)}")
    if not arguments.platforms:
        build("sdist", arguments.output, [], {})
    for platform in arguments.platforms or TAGS:
        wheel(platform, arguments.output)


if __name__ == "__main__":
    main()
