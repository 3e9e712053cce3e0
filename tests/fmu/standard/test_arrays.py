"""FMI 3.0: the motion of all contacts as arrays beside the scalars."""

import ctypes

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_fixtures import instance

from slipmode.fmu.imported import Imported

ARRAYS = {letter: tuple(f"contact_{i}_{letter}" for i in (0, 1)) for letter in "xvf"}


@pytest.fixture
def stepped(unzipped):
    with instance(unzipped[3], 3) as made:
        made.start().step(0.0, 30.0)
        yield made


def test_arrays_are_their_elements(stepped):
    for letter, scalars in ARRAYS.items():
        reference = [stepped.reference[f"contact_{letter}"]]
        values = stepped.fmu.getFloat64(reference, nValues=2)
        assert np.abs(values).min() > 0.0
        np.testing.assert_array_equal(values, stepped.get(*scalars))
    mixed = [stepped.reference[name] for name in ("A_re", "contact_v", "contact_1_x")]
    names = ("A_re", *ARRAYS["v"], "contact_1_x")
    np.testing.assert_array_equal(stepped.fmu.getFloat64(mixed, nValues=4), stepped.get(*names))


@pytest.mark.parametrize("values", [1, 3])
def test_as_many_values_are_needed_as_they_have(stepped, values):
    with pytest.raises(fmpy.fmi1.FMICallException):
        stepped.fmu.getFloat64([stepped.reference["contact_x"]], nValues=values)
    assert f"must be 2 for these variables, got {values}" in stepped.messages[-1][1]


def test_they_are_not_set(stepped):
    with pytest.raises(fmpy.fmi1.FMICallException):
        stepped.fmu.setFloat64([stepped.reference["contact_x"]], [0.0])
    assert "contact_x: is an array" in stepped.messages[-1][1]


def test_fmi_2_does_not_know_them(unzipped):
    """They are in the resources, which both versions share."""
    with instance(unzipped[2], 2) as made:
        made.start()
        with pytest.raises(fmpy.fmi1.FMICallException):
            made.fmu.getReal([len(made.reference)])
        assert "contact_x: is an array, not a real" in made.messages[-1][1]


def test_their_derivatives_are_those_of_their_elements(stepped):
    known = [stepped.reference[name] for name in ("A_re", "B_im")]
    unknown = [stepped.reference[name] for name in ("contact_x", "A_abs")]
    scalars = [stepped.reference[name] for name in (*ARRAYS["x"], "A_abs")]
    directional, adjoint = "fmi3GetDirectionalDerivative", "fmi3GetAdjointDerivative"
    along = {}
    for references in (unknown, scalars):
        given = [*_plain(references), *_plain(known)]
        along[len(references)] = (
            _derivative(stepped, directional, *given, [1.0, -0.5], 3),
            _derivative(stepped, adjoint, *given, [0.3, 0.2, -1.0], 2),
        )
    np.testing.assert_array_equal(along[2][0], along[3][0])
    np.testing.assert_array_equal(along[2][1], along[3][1])
    assert np.abs(along[2][0]).min() > 0.0


def _plain(references):
    return (ctypes.c_uint32 * len(references))(*references), ctypes.c_size_t(len(references))


def _derivative(made, name, unknown, unknowns, known, knowns, seed, size):
    values = (ctypes.c_double * size)()
    seeds = (ctypes.c_double * len(seed))(*seed)
    getattr(made.fmu, name)(
        made.fmu.component, unknown, unknowns, known, knowns, seeds, len(seed), values, size
    )
    return list(values)


def test_the_model_description_has_them(fmus):
    assert validate_fmu(str(fmus[3])) == []
    for fmi, path in fmus.items():
        description = fmpy.read_model_description(path)
        sizes = {
            v.name: [int(d.start) for d in v.dimensions]
            for v in description.modelVariables
            if v.dimensions
        }
        assert sizes == ({f"contact_{letter}": [2] for letter in "xvf"} if fmi == 3 else {})
        unknowns = {unknown.variable.name for unknown in description.outputs}
        assert set(sizes) <= unknowns


def test_importers_read_them(fmus):
    """FMPy as columns of arrays; `Imported` goes on with the scalars."""
    names = ["contact_x", *ARRAYS["x"]]
    result = fmpy.simulate_fmu(fmus[3], stop_time=5.0, output_interval=0.5, output=names)
    scalars = np.column_stack([result[name] for name in ARRAYS["x"]])
    np.testing.assert_array_equal(result["contact_x"], scalars)
    with Imported(fmus[3]) as imported:
        assert "contact_x" not in imported.output_names
        assert set(ARRAYS["x"]) <= set(imported.output_names)
