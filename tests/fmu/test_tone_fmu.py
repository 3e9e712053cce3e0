"""FMUs of modes that share a tone: three amplitudes under one force, two different contacts."""

import shutil
import struct
import zlib

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_fixtures import ERROR, VERSIONS, instance, not_made, unpacked

from slipmode import fmu, rom
from slipmode.__main__ import main

FORCE = [{0: 0.02, 1: 0.01j, 2: 0.015}]
START = {"force_A": 1.0, "frequency_A": 1.02}
READ = {"contact": True, "elastic": (0, 3)}


@pytest.fixture(scope="module")
def model():
    omega, shapes = np.array([1.0, 1.03, 1.08, 3.5]), [[0.9, 0.2], [0.4, 0.8], [0.3, 0.5], [1, 1]]
    matrices = {"mass": np.eye(4), "damping": 0.01 * np.eye(4), "stiffness": np.diag(omega**2)}
    law = rom.Jenkins((0.02, 0.03), (0.05, 0.08))
    structure = rom.Structure(**matrices, contact=np.array(shapes))
    return rom.tabulate(rom.reduce(structure, (0, 1, 2), law=law, tones=(0, 0, 0)), law)


@pytest.fixture(scope="module")
def folders(model, tmp_path_factory):
    """{2: folder, 3: folder}"""
    made = {}
    for fmi in VERSIONS:
        path = tmp_path_factory.mktemp("tone") / f"{fmi}.fmu"
        fmu.export(model, path, FORCE, fmi=fmi, start=START, warned=False, **READ)
        assert validate_fmu(str(path)) == []
        made[fmi] = unpacked(path, path.with_suffix(""))
    return made


def inputs(k):
    """A force that jumps, a frequency and a phase that move."""
    return {"force_A": 1.0 + 0.5 * np.sin(k), "frequency_rate_A": 1e-4, "phase_rate_A": -0.01}


def follow(one, steps, read):
    """Outputs after steps."""
    rows = []
    for k in steps:
        one.set(**inputs(k))
        one.step(3.0 * k, 3.0)
        rows.append(one.get(*read))
    return np.array(rows)


def test_an_fmu_has_the_bits_of_the_component_also_after_its_state_was_moved(model, folders, fmi):
    component = fmu.Component(model, FORCE, warned=False, **READ)
    component.set_inputs(**START)
    names, expected = component.output_names, [list(component.outputs().values())]
    for k in range(40):
        component.set_inputs(**inputs(k))
        component.do_step(3.0 * k, 3.0)
        expected.append(list(component.outputs().values()))
    assert "A3_im" in names and np.abs(expected[-1]).min() > 0.0
    with instance(folders[fmi], fmi) as made, instance(folders[fmi], fmi) as other:
        first = made.start().get(*names)
        begun = follow(made, range(20), names)
        other.start(force_A=0.3).step(0.0, 1.0)
        other.restore(made.serialize())
        for one in (made, other):
            found = np.vstack((first, begun, follow(one, range(20, 40), names)))
            np.testing.assert_array_equal(found, expected)


def test_what_modes_on_one_tone_do_not_have_is_refused_in_one_line(folders, fmi):
    description = fmpy.read_model_description(folders[fmi])
    assert description.coSimulation and description.modelExchange is None
    (message,) = not_made(folders[fmi], fmi, exchange=True)
    assert message == "modes that share a tone are not for Model Exchange"
    with instance(folders[fmi], fmi) as made:
        assert made.refused(made.start, frequency_A=1.3)[1].startswith("frequency_A: must be 0.95")
    with instance(folders[fmi], fmi) as made:
        made.start()
        before = made.serialize()
        references = [made.reference["A_re"]], [made.reference["force_A"]]
        status, message = made.refused(made.fmu.getDirectionalDerivative, *references, [1.0])
        assert status == ERROR and message == "derivative: modes that share a tone have none"
        assert made.serialize() == before


@pytest.mark.parametrize("is_hidden", [False, True])
def test_damaged_numbers_are_refused(folders, fmi, tmp_path, is_hidden):
    """Also under a checksum that fits them."""
    resources = shutil.copytree(folders[fmi], tmp_path / "damaged") / "resources"
    content = (resources / "tone.npy").read_bytes()
    damaged = content[:-8] + np.array(np.nan).tobytes()
    (resources / "tone.npy").write_bytes(damaged)
    if is_hidden:
        before, after = (struct.pack("<I", zlib.crc32(each)) for each in (content, damaged))
        checksums = (resources / "checksums.npy").read_bytes()
        (resources / "checksums.npy").write_bytes(checksums.replace(before, after))
    (message,) = not_made(tmp_path / "damaged", fmi)
    reasons = ("resources/tone.npy: damaged", "the resources do not make a model: ")
    assert message.startswith(reasons[is_hidden])


def test_the_command_exports_the_shipped_plate(fmi, tmp_path, capsys, shipped_scene):
    """Its sweep is that of the run, whose contacts have another reference frequency."""
    path, sweep = tmp_path / "plate.fmu", 2.0 * np.pi * 20.0 / 8.0
    assert main(["fmu", "square-plate", "-o", str(path), "--fmi", str(fmi)]) == 0
    assert capsys.readouterr().out == f"{path}\n" and validate_fmu(str(path)) == []
    modes = shipped_scene("square-plate").read().channels["/modes"]
    with instance(unpacked(path, tmp_path / "plate"), fmi) as made:
        made.start(frequency_rate_A=sweep)
        found = [made.get("A_abs", "A2_abs")]
        for time, step in zip(modes.time, np.diff(modes.time), strict=False):
            made.step(time, step)
            found.append(made.get("A_abs", "A2_abs"))
    expected = np.column_stack([modes.column(f"{name}_abs") for name in ("A", "A2")])
    assert np.abs(found - expected).max() < 1e-3 * expected.max()
