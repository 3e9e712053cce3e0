"""Wheels for every platform, made on this machine: what they hold, show and need."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path
from platform import machine

import pytest

ROOT = Path(__file__).parents[2]
PLATFORMS = ["aarch64-darwin", "aarch64-linux", "x86_64-darwin", "x86_64-linux", "x86_64-windows"]
MACHINE = {"arm64": "aarch64", "AMD64": "x86_64"}.get(machine(), machine())
HOST = f"{MACHINE}-{'windows' if sys.platform == 'win32' else sys.platform}"
FUNCTIONS = {
    name
    for path in (ROOT / "rom" / "kernel").glob("*.h")
    for name in re.findall(r"SM_API [\w ]+\*?\b(sm_\w+)\(", path.read_text(encoding="utf-8"))
}
NEEDED = ("build", "ziglang", "lief", "scikit_build_core")
SYSTEM_LIBRARIES = re.compile(
    r"lib[cm]\.so\.6|ld-linux-[\w-]+\.so\.\d|/usr/lib/libSystem\.B\.dylib"
    r"|KERNEL32\.dll|api-ms-win-crt-[\w-]+\.dll",
    re.IGNORECASE,
)


def script():
    """release/wheels.py as a module."""
    spec = importlib.util.spec_from_file_location("wheels", ROOT / "release" / "wheels.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def wheels(tmp_path_factory):
    """Every platform's wheel, opened."""
    for package in NEEDED:
        pytest.importorskip(package, reason="needs slipmode[wheels]")
    folder = tmp_path_factory.mktemp("dist")
    command = (sys.executable, ROOT / "release" / "wheels.py", "-o", folder)
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    assert len(list(folder.glob("slipmode-*.tar.gz"))) == 1
    tags = {tag: platform for platform, tag in script().TAGS.items()}
    return {
        tags[path.stem.partition("-py3-none-")[2]]: zipfile.ZipFile(path)
        for path in folder.glob("*.whl")
    }


@pytest.mark.slow
def test_there_is_one_for_every_platform_with_the_same_files(wheels):
    assert wheels.keys() == set(PLATFORMS)
    files = {
        platform: {name.replace(".pyd", ".so") for name in wheel.namelist()}
        for platform, wheel in wheels.items()
    }
    assert all(names == files[HOST] for names in files.values())
    for platform, wheel in wheels.items():
        (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/WHEEL"))
        text = wheel.read(name).decode()
        assert f"Tag: py3-none-{script().TAGS[platform]}\n" in text
        assert "Root-Is-Purelib: false" in text


@pytest.mark.slow
@pytest.mark.parametrize("platform", PLATFORMS)
def test_its_libraries_show_what_python_calls_and_need_the_system_alone(wheels, platform):
    from release.wheel_binaries import inspect

    wheel = wheels[platform]
    names = [name for name in wheel.namelist() if name.endswith((".so", ".pyd"))]
    contents = {Path(name).stem: wheel.read(name) for name in names}
    assert contents.keys() == {"_core", "_native"}
    found = {name: inspect(content) for name, content in contents.items()}
    assert found["_core"].exported >= FUNCTIONS | {"sm_compiled_headers"}
    assert {"fmi2DoStep", "fmi3DoStep"} <= found["_native"].exported
    assert not [name for name in found["_native"].exported if name.startswith("sm_")]
    for name, library in found.items():
        assert library.platform == platform
        assert library.paths == ()
        own = {Path(each).name for each in names}  # how a library of macOS calls itself
        assert not [n for n in library.needed - own if not SYSTEM_LIBRARIES.fullmatch(n)]
        if platform.endswith("linux"):
            assert (2,) < library.newest <= (2, 17)
        if platform.endswith("darwin"):
            assert library.newest[:2] == (11, 0)
        folders = {str(ROOT), str(Path(sys.prefix)), str(Path.home()), "/build"}
        assert not [each for each in folders if each.encode() in contents[name]]
        assert b"ubsan" not in contents[name]


@pytest.mark.slow
def test_the_wheel_of_this_machine_runs_without_a_compiler(wheels, tmp_path):
    """In a clean environment, where nothing but its Python is to be found."""
    venv.create(tmp_path / "env", with_pip=True)
    bin_folder = tmp_path / "env" / "bin"
    kept = {"HOME", "LANG", "SSL_CERT_FILE"} | {k for k in os.environ if k.startswith("PIP_")}
    environment = {k: v for k, v in os.environ.items() if k in kept} | {
        "PATH": str(bin_folder),
        "SLIPMODE_CACHE": str(tmp_path / "cache"),
    }

    def run(*words):
        done = subprocess.run(
            (str(bin_folder / words[0]), *words[1:]),
            **{"cwd": tmp_path, "env": environment, "capture_output": True, "text": True},
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    assert shutil.which("cc", path=environment["PATH"]) is None
    wheel = wheels[HOST].filename
    run("pip", "install", "--quiet", "--only-binary", ":all:", wheel)
    assert "computed" in run("slipmode", "run", "one-mode")
    assert {"one-mode.mcap", "one-mode.rrd"} < {path.name for path in tmp_path.glob("logs/*")}
    run("slipmode", "fmu", "one-mode", "-o", "one-mode.fmu")
    version = run("python", "-c", "import slipmode; print(slipmode.__version__)").strip()
    assert f"-{version}-py3" in wheel
