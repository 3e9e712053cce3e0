"""Elastic contacts in the component and in FMUs: scaled loads, outputs, state, resources."""

import re
import shutil
import zlib

import fmpy
import numpy as np
import pytest
from elastic import cantilever as joints
from fmu_fixtures import VERSIONS, Instance, instance
from stepping import march

from slipmode import fmu, rom

FMI_ERRORS = fmpy.fmi1.FMICallException
# The table with a gap takes half a minute.
LAWS = [
    pytest.param(name, marks=[pytest.mark.slow] if name == "with a gap" else [])
    for name in joints.LAWS
]
DURATIONS = np.tile([0.3, 2.0, 31.0, 1e-2, 7.0], 3)  # shorter and longer than the contacts' memory


def component(name="mixed", modes=(0, 1), scale=1.0, **inputs):
    made = fmu.Component(
        joints.model(name, modes),
        joints.FORCE_PATTERNS[: len(modes)],
        contact=True,
        elastic=joints.DOFS,
    )
    forces = {name: scale * force for name, force in joints.FORCES.items()}
    made.set_inputs(
        **{name: forces[name] for name in forces if name in made.input_names}, **inputs
    )
    return made


def exported(folder, name="mixed", fmi=3):
    path = fmu.export(
        joints.model(name),
        folder / f"{name} {fmi}.fmu",
        joints.FORCE_PATTERNS,
        fmi=fmi,
        contact=True,
        elastic=joints.DOFS,
        start=joints.FORCES,
    )
    shutil.unpack_archive(path, folder / f"{name} {fmi}", format="zip")
    return path, folder / f"{name} {fmi}"


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """{fmi: (file, folder)} of the model with several laws."""
    folder = tmp_path_factory.mktemp("elastic")
    return {fmi: exported(folder, fmi=fmi) for fmi in VERSIONS}


# The component


@pytest.mark.parametrize("name", ["Jenkins", "mixed"])
@pytest.mark.parametrize("modes", [(0,), (0, 1)], ids=["one mode", "two modes"])
@pytest.mark.parametrize("scale", [pytest.param(0.25, marks=pytest.mark.slow), 4.0])
def test_loads_and_forces_scale_all_that_moves(name, modes, scale):
    """Amplitudes, contact motion and displacements times s, powers and energy times s^2.

    Exactly so for powers of two.
    """
    one = component(name, modes)
    scaled = component(name, modes, scale, limit_scale=scale)
    expected, rows = march(one, DURATIONS), march(scaled, DURATIONS)
    quadratic = ("input_power", "dissipated_power", "dissipated_energy")
    for k, output in enumerate(one.output_names):
        fixed = output == "time" or output.startswith("theta")
        factor = 1.0 if fixed else scale**2 if output in quadratic else scale
        np.testing.assert_array_equal(rows[:, k] / factor, expected[:, k], err_msg=output)


@pytest.mark.parametrize("name", ["Jenkins", "mixed"])
def test_forces_alone_do_not(name):
    expected, rows = (
        march(component(name), DURATIONS),
        march(component(name, scale=0.3), DURATIONS),
    )
    assert np.abs(rows[:, 1] / 0.3 - expected[:, 1]).max() > 0.1 * np.abs(expected[:, 1]).max()


@pytest.mark.slow
def test_a_gap_does_not_scale():
    of = component("with a gap")
    assert "limit_scale" not in of.input_names
    with pytest.raises(rom.SlipmodeError, match="limit_scale: the contact law has a gap"):
        of.set_inputs(limit_scale=1.0)


def test_contacts_that_are_all_open_at_rest_are_refused():
    """One group may be, as it is in "with a gap"."""
    law = rom.FrictionalContact(0.3, 0.0, 20.0, 30.0, gap=0.1)
    with pytest.raises(rom.SlipmodeError, match="gap: all contacts are open at rest"):
        rom.reduce(joints.cantilever(law), (0,), law=law)


@pytest.mark.parametrize("name", LAWS)
def test_many_steps_in_one_call_have_the_bits_of_single_ones(name):
    single, at_once = component(name), component(name)
    inputs = dict.fromkeys(at_once.input_names, 0.0) | joints.FORCES
    natural = at_once.model.reduced.frequency
    inputs |= {"frequency_A": natural[0], "frequency_B": natural[1]}
    inputs |= {"limit_scale": 1.0} if "limit_scale" in inputs else {}
    rows = at_once.run(DURATIONS, np.tile(list(inputs.values()), (DURATIONS.size, 1)))
    np.testing.assert_array_equal(rows, march(single, DURATIONS))
    f = [k for k, output in enumerate(single.output_names) if output.endswith("_f")]
    assert np.abs(rows[:, f]).max(axis=0).min() > 1e-3


@pytest.mark.parametrize("name", LAWS)
def test_the_state_has_where_the_sliders_are(name):
    one, other = component(name), component(name)
    march(one, DURATIONS)
    other.set_state(one.get_state())
    np.testing.assert_array_equal(march(other, [0.01, 0.2]), march(one, [0.01, 0.2]))


# FMUs


@pytest.mark.parametrize("fmi", VERSIONS)
def test_co_simulation_has_the_components_bits(fmus, fmi):
    stepped = component()
    expected = march(stepped, np.full(60, 1.0))
    names = stepped.output_names[1:]
    result = fmpy.simulate_fmu(
        fmus[fmi][0], stop_time=60.0, output_interval=1.0, fmi_type="CoSimulation", output=names
    )
    assert result.size == 61
    for k, name in enumerate(names):
        np.testing.assert_array_equal(result[name][1:], expected[:, k + 1], err_msg=name)
    assert np.abs(result["contact_2_f"]).max() > 0.1


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_saved_state_continues_to_the_same_bits(fmus, fmi):
    names = component().output_names
    with instance(fmus[fmi][1], fmi) as made, instance(fmus[fmi][1], fmi) as twin:
        made.start(limit_scale=1.2).step(0.0, 33.3)
        saved = made.serialize()
        twin.start(A_re=0.01).step(0.0, 5.0)  # a past to be forgotten
        twin.restore(saved)
        assert twin.serialize() == saved
        for time, duration in ((33.3, 0.01), (33.31, 0.3), (33.61, 20.0)):
            made.step(time, duration)
            twin.step(time, duration)
            np.testing.assert_array_equal(made.get(*names), twin.get(*names))


@pytest.mark.parametrize("fmi", VERSIONS)
def test_model_exchange_marches_the_same_contacts(fmus, fmi):
    """Steady motion: nothing but the march is between the two."""
    names = [f"contact_{i}_{quantity}" for i in range(4) for quantity in "xf"]
    common = {"stop_time": 400.0, "output_interval": 40.0, "output": names}
    stepped, solved = (
        fmpy.simulate_fmu(fmus[fmi][0], fmi_type=kind, relative_tolerance=1e-8, **common)[-1]
        for kind in ("CoSimulation", "ModelExchange")
    )
    for name in names:  # of the orders of their limits and displacements
        assert solved[name] == pytest.approx(stepped[name], abs=2e-3 if name[-1] == "x" else 2e-2)


@pytest.mark.parametrize("name", LAWS)
def test_outputs_are_described_by_what_they_are(name, tmp_path):
    path, folder = exported(tmp_path, name)
    described = {v.name: v.description for v in fmpy.read_model_description(path).modelVariables}
    of_contacts = [described[f"contact_{i}_{quantity}"] for i in range(4) for quantity in "xvf"]
    page = (folder / "documentation" / "index.html").read_text()
    assert all(words in page for words in of_contacts)
    assert ("limit_scale" in described) == (name != "with a gap")
    if name == "mixed":
        assert described["contact_0_x"] == (
            "First tangential displacement at contact DOF 0 (frictional contact)"
        )
        assert described["contact_2_v"].startswith("Second tangential velocity at contact DOF 2")
        assert described["contact_1_x"] == (
            "Normal displacement at contact DOF 1, positive where it closes (frictional contact)"
        )
        assert described["contact_1_f"].startswith("Normal force beyond the preload")
        assert described["contact_3_f"] == "Tangential force at contact DOF 3 (Iwan)"
        assert "frictional contact (mu 0.4, preload 1 N, tangential stiffness 20 N/m" in page
        assert "Iwan (force 0.05 N, stiffness 8 N/m, chi -0.5" in page
        assert "the contacts do not separate" not in page


# Resources that a careful forger made: their checksums fit.


def forged(folder, changed):
    """Files as they are, with their checksums; changed by name."""
    resources = folder / "resources"
    order = _file_order(folder)
    for name, change in changed.items():
        array = np.load(resources / f"{name}.npy")
        array = change(array) or array
        np.lib.format.write_array((resources / f"{name}.npy").open("wb"), array, version=(1, 0))
    sums = [zlib.crc32((resources / name).read_bytes()) for name in order]
    checksums = np.array(sums, dtype="<u4").view("<i4")
    np.lib.format.write_array((resources / "checksums.npy").open("wb"), checksums, version=(1, 0))
    return folder


def _file_order(folder):
    """Names of files in the order of checksums.npy, as the C source lists them."""
    text = (folder / "sources" / "resources" / "model.c").read_text()
    listed = text.split("FILES[] = {")[1].split("};")[0]
    return [*re.findall(r'"([\w.]+)"', listed), "names.txt"]


def put(row, column, value):
    def change(array):
        array[row, column] = value

    return change


@pytest.mark.parametrize(
    ("name", "change", "reason"),
    [
        ("contact_elements", put(0, 0, 2.0), "contact_*.npy: "),
        ("contact_elements", put(0, 1, 4.0), "contact_*.npy: "),
        ("contact_elements", put(1, 1, 0.0), "contact_*.npy: "),
        ("contact_elements", put(0, 1, 0.5), "contact_elements.npy: element 0 is damaged"),
        ("contact_elements", put(1, 5, 1e12), "contact_elements.npy: element 1 is damaged"),
        ("contact_elements", put(1, 4, -1.0), "contact_elements.npy: element 1 is damaged"),
        ("contact_elements", put(1, 5, 1000.0), "contact_*.npy: "),
        ("contact_elements", put(0, 6, np.nan), "contact_elements.npy: element 0 is damaged"),
        ("contact_elements", put(0, 6, 3.0), "contact_*.npy: "),
        ("contact_elements", put(0, 7, -0.1), "contact_*.npy: "),
        ("contact_elements", put(0, 9, np.inf), "contact_*.npy: "),
        ("contact_sliders", put(0, 1, 0.0), "contact_*.npy: "),
        ("contact_sliders", put(2, 0, np.nan), "contact_*.npy: "),
        ("contact_reference", lambda array: array.fill(-1.0), "contact_*.npy: "),
    ],
)
def test_elements_that_are_none_are_refused_with_a_reason(fmus, name, change, reason, tmp_path):
    folder = tmp_path / "forged"
    shutil.copytree(fmus[3][1], folder)
    with instance(forged(folder, {}), 3) as made:  # the forger knows what he does
        made.start().step(0.0, 1.0)
    messages = refusal(forged(folder, {name: change}))
    assert any(reason in message for message in messages), messages


def refusal(folder):
    """What is logged where no instance is made."""
    messages = []

    class Watched(Instance):
        def _instantiate(self):
            self.messages = messages
            super()._instantiate()

    with pytest.raises(Exception, match="instantiate"):
        Watched(folder, 3)
    return [message for _, message in messages]
