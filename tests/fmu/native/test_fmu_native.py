"""The FMU's C code under the address and undefined-behaviour sanitizers, by a driver in C."""

import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from elastic import cantilever as elastic_contacts
from native import run

from slipmode import fmu, rom
from slipmode.fmu.archive.binaries import INCLUDE_FOLDERS, fmi_headers, source_files

THREADS = Path(__file__).parent / "threads" / "threads.c"
FEW, MANY = 400, 50_000  # sequences of about 25 calls


def rates(amplitudes):
    """Of two modes without contacts, about the frequencies of the two masses."""
    return 0.01 + 0.01 * amplitudes, np.array([1.0, 1.7]) - 0.01 * amplitudes


@pytest.fixture
def driver(drivers):
    return drivers["fmu"]


@pytest.fixture(scope="module", params=["contact motion", "friction limit", "elastic", "none"])
def resources(request, tmp_path_factory):
    """Of an FMU with a coarse table, which is quicker to load."""
    folder = tmp_path_factory.mktemp("coarse ünïcode %20 ")
    if request.param == "elastic":
        model = elastic_contacts.model("mixed")
    elif request.param == "none":
        model = rom.model_of_rates(rates, (3.0, 3.0), 3e-2, mode_shapes=np.eye(4, 2))
    else:
        reduced, law = rom.reduce(rom.two_mass()), rom.Coulomb(2.0)
        model = rom.tabulate(reduced, law, amplitude=(3.0, 3.0), tolerance=3e-2, harmonics=5)
    contact = request.param != "friction limit"
    elastic = (0, 3) if contact else ()
    path = fmu.export(model, folder / "coarse.fmu", contact=contact, elastic=elastic)
    shutil.unpack_archive(path, folder / "FMU", format="zip")
    return folder / "FMU" / "resources"


def random_sequences(driver, resources, count, seed, *what):
    token = (resources / "token.txt").read_text()
    done = run(driver, f"{resources}/", token, str(count), str(seed), *what)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{count} sequences")


def test_random_sequences_of_calls(driver, resources):
    """Legal and illegal: no crash, no leak, the right status, a logged reason, no trace left."""
    random_sequences(driver, resources, FEW, 1)


def test_damaged_resources(driver, resources, tmp_path):
    copy = tmp_path / "resources"
    shutil.copytree(resources, copy)
    random_sequences(driver, copy, FEW, 1, "damage")


@pytest.mark.slow
@pytest.mark.parametrize("resources", ["contact motion"], indirect=True)
def test_threads_share_a_model(resources, tmp_path):
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler (cc)")
    sources = [path for path in source_files(3).values() if path.suffix == ".c"]
    includes = [f"-I{folder}" for folder in INCLUDE_FOLDERS]
    program = tmp_path / "threads"
    built = run(
        *(compiler, "-std=c99", "-O1", "-g1", "-fsanitize=thread", *includes),
        *(f"-isystem{fmi_headers()}", THREADS, *sources, "-lm", "-lpthread", "-o", program),
    )
    if built.returncode and "tsan" in built.stderr:
        pytest.skip("the compiler has no thread sanitizer")
    assert built.returncode == 0, built.stderr
    done = run(program, f"{resources}/", (resources / "token.txt").read_text())
    assert (done.returncode, done.stdout) == (0, "equal\n"), done.stderr


@pytest.mark.slow
def test_many_random_sequences_of_calls(driver, resources):
    def part(seed):
        random_sequences(driver, resources, MANY // 20, seed)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(part, range(100, 110)))
