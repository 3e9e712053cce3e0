"""The FMU's C code under the address and undefined-behaviour sanitizers."""

import os
import shutil
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from elastic import cantilever
from fmu_fixtures import unpacked
from native import run

from slipmode import fmu, rom

FEW, MANY = 150, 50_000  # sequences of about 25 calls


@pytest.fixture(scope="module", params=["contact motion", "friction limit", "elastic", "none"])
def resources(request, tmp_path_factory):
    """Of an FMU with a coarse table, which is quicker to load."""
    folder = tmp_path_factory.mktemp("coarse ünïcode %20 ")
    if request.param == "elastic":
        model = cantilever.model("mixed")
    elif request.param == "none":
        model = rom.model_of_rates(
            lambda a: (0.01 + 0.01 * a, np.array([1.0, 1.7]) - 0.01 * a),
            *((3.0, 3.0), 3e-2),
            mode_shapes=np.eye(4, 2),
        )
    else:
        reduced, law = rom.reduce(rom.two_mass()), rom.Coulomb(2.0)
        model = rom.tabulate(reduced, law, amplitude=(3.0, 3.0), tolerance=3e-2, harmonics=5)
    contact = request.param != "friction limit"
    elastic = (0, 3) if contact else ()
    path = fmu.export(model, folder / "coarse.fmu", contact=contact, elastic=elastic)
    return unpacked(path, folder / "FMU") / "resources"


def sequences(sanitized, resources, count, seed, *what):
    token = (resources / "token.txt").read_text()
    done = run(sanitized["fmu"], f"{resources}/", token, str(count), str(seed), *what)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{count} sequences")


def test_calls_in_any_order_have_the_right_status_and_refused_ones_leave_no_trace(
    sanitized, resources
):
    """Also: no crash, no leak, no value that is NaN or infinite, a logged reason."""
    sequences(sanitized, resources, FEW, 1)


def test_resources_with_random_damage_are_refused(sanitized, resources, tmp_path):
    sequences(sanitized, shutil.copytree(resources, tmp_path / "resources"), FEW, 1, "damage")


@pytest.mark.slow
def test_many_random_sequences_of_calls(sanitized, resources):
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda k: sequences(sanitized, resources, MANY // 20, k), range(100, 110)))
