"""Aerodynamic coefficients of modes: the same forces in the reduction and at full order."""

import numpy as np
import pytest
import scipy.sparse
from elastic.cantilever import LAWS, cantilever

from slipmode import fmu, rom
from slipmode.fmu.imported import Imported
from slipmode.rom import full
from slipmode.rom.reduction.force_response import AppliedForces

COEFFICIENTS = (0.03 - 0.05j, -0.1 + 0.02j)
LAW = LAWS["Jenkins"]
BEAM = cantilever(LAW)


def reductions(elastic):
    """A structure, its reduction with aerodynamics, and that of the structure that has them."""
    structure, law = (BEAM, LAW) if elastic else (rom.two_mass(beta=0.01), None)
    given = rom.reduce(structure, law=law, aerodynamics=COEFFICIENTS)
    return structure, given, rom.reduce(full.aeroelastic(structure, given), law=law)


@pytest.mark.parametrize("elastic", [False, True], ids=["bonded", "stuck"])
def test_to_reduce_the_structure_under_these_forces_is_the_same(elastic):
    structure, given, expected = reductions(elastic)
    alone = rom.reduce(structure, law=LAW if elastic else None)
    c, omega = np.array(COEFFICIENTS), alone.frequency
    np.testing.assert_allclose(given.frequency, np.sqrt(omega**2 + c.real), rtol=1e-14)
    np.testing.assert_allclose(given.structural_frequency, omega, rtol=1e-14)
    np.testing.assert_allclose(given.modal_damping, alone.modal_damping + c.imag / omega)
    matrices = ("mass", "damping", "stiffness", "spring", "damper", "carried_mass")
    others = ("nonresonant_frequency", "nonresonant_damping", "damping_coupling")
    shapes = ("mode_shapes", "contact_shapes")
    for name in ("frequency", "modal_damping", *matrices, *others, *shapes):
        values = getattr(expected, name)
        atol = 1e-8 * np.abs(values).max(initial=0.0) + 1e-12
        np.testing.assert_allclose(getattr(given, name), values, rtol=1e-8, atol=atol)


@pytest.mark.parametrize("elastic", [False, True], ids=["bonded", "stuck"])
def test_what_forces_do_statically_is_as_without(elastic):
    structure, given, _ = reductions(elastic)
    alone = rom.reduce(structure, law=LAW if elastic else None)
    patterns = [np.arange(1.0, structure.n_dofs + 1.0), np.ones(structure.n_dofs)]
    static = [AppliedForces.of(each, patterns, structure).static for each in (given, alone)]
    np.testing.assert_allclose(*static, rtol=1e-9, atol=1e-12)


def test_sparse_structures_are_reduced_sparse():
    dense = rom.two_mass(beta=0.01)
    store = scipy.sparse.csc_array
    structure = rom.Structure(store(dense.mass), store(dense.stiffness), 0.01, contact=(2, 3))
    given = rom.reduce(structure, aerodynamics=COEFFICIENTS)
    of_dense = rom.reduce(dense, aerodynamics=COEFFICIENTS)
    np.testing.assert_allclose(given.modal_damping, of_dense.modal_damping)
    both = [full.aeroelastic(*each).damping for each in ((structure, given), (dense, of_dense))]
    np.testing.assert_allclose(*both, atol=1e-15)


def test_the_structure_without_aerodynamics_stays_as_it_is():
    assert full.aeroelastic(BEAM, rom.reduce(BEAM, law=LAW)) is BEAM


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ((1j,), "must be 2 finite complex numbers"),
        ((1j, 1j, 1j), "must be 2 finite complex numbers"),
        (1j, "must be 2 finite complex numbers"),
        ((np.nan, 1j), "must be 2 finite complex numbers"),
        ((1j, complex(0.0, np.inf)), "must be 2 finite complex numbers"),
        (("A", "B"), "must be 2 finite complex numbers"),
        ((1e40, 0.0), "must be 2 finite complex numbers"),
        ((-1.0 + 1j, 0.0), "the real part for mode A must be above -omega^2 = -1"),
        ((0.0, -3.0), "the real part for mode B must be above -omega^2 = -2.89"),
    ],
)
def test_coefficients_that_are_none_are_refused(wrong, message):
    with pytest.raises(rom.SlipmodeError) as refused:
        rom.reduce(rom.two_mass(), aerodynamics=wrong)
    assert str(refused.value).startswith(f"aerodynamics: {message}")
    assert "\n" not in str(refused.value)


def test_the_papers_formulation_has_none():
    with pytest.raises(rom.SlipmodeError, match=r"^aerodynamics: formulation must be"):
        rom.reduce(rom.two_mass(), formulation="paper", aerodynamics=COEFFICIENTS)


@pytest.fixture(scope="module")
def fluttering():
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,), aerodynamics=(0.05 - 0.024j,))
    return rom.tabulate(reduced, rom.Coulomb(2.0), (3.0,))


def test_models_keep_their_aerodynamics(fluttering, tmp_path):
    fluttering.save(tmp_path / "model.rom")
    loaded = rom.Model.load(tmp_path / "model.rom")
    np.testing.assert_array_equal(loaded.reduced.aerodynamics, fluttering.reduced.aerodynamics)
    assert loaded.hash == fluttering.hash


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_settles_to_the_limit_cycle(fluttering, tmp_path, fmi):
    path = fmu.export(fluttering, tmp_path / "flutter.fmu", fmi=fmi)
    cycle = rom.limit_cycles(fluttering)[0]
    component = fmu.Component(fluttering, warned=False)
    component.reset(amplitude=1.2)
    with Imported(path, start={"A_re": 1.2}) as imported:
        for stepped in (component, imported):
            stepped.do_step(0.0, 3000.0)
        outputs = imported.outputs()
    assert outputs["A_re"] == component.outputs()["A_re"]
    assert np.hypot(outputs["A_re"], outputs["A_im"]) == pytest.approx(
        float(np.abs(cycle.amplitude[0])), rel=1e-3
    )
