"""Static state and reduction of large structures, found again on disk."""

from dataclasses import fields

import numpy as np
import pytest
import scipy.sparse
from elastic.frictional_beam import ROWS, TIP, structure

from slipmode import rom
from slipmode.rom.table import disk_cache
from slipmode.runner import load_scene, make_plan
from slipmode.runner.scene import kept

LAW = rom.FrictionalContact(mu=0.4, preload=1.0, tangential_stiffness=20.0, normal_stiffness=30.0)


@pytest.fixture(name="cache", autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SLIPMODE_CACHE", str(tmp_path))
    monkeypatch.setattr(kept, "LARGE", 1)


@pytest.fixture(name="counted")
def counted_work(monkeypatch):
    """Names of what was computed."""
    done = []

    def counting(name, own):
        def work(*args, **options):
            done.append(name)
            return own(*args, **options)

        monkeypatch.setattr(kept, name, work)

    counting("reduce", rom.reduce)
    counting("preload", rom.preload)
    return done


def beam(sparse=False, factor=1.0):
    dense = structure(ROWS[0].law, ROWS[0].node)
    matrices = [dense.mass, dense.stiffness * factor, dense.damping, dense.directions]
    if sparse:
        matrices = [scipy.sparse.csc_array(np.asarray(each)) for each in matrices]
    return rom.Structure(*matrices[:3], contact=matrices[3])


def same(a, b):
    """Whether two results are equal to the last bit, in layout too."""
    for field in fields(a):
        one, other = getattr(a, field.name), getattr(b, field.name)
        if isinstance(one, np.ndarray):
            assert one.dtype == other.dtype
            assert one.flags.c_contiguous == other.flags.c_contiguous
            np.testing.assert_array_equal(one, other)
        elif field.name == "contacts" and one is not None:
            np.testing.assert_array_equal(one.reference, other.reference)
            np.testing.assert_array_equal(one.element, other.element)
        elif isinstance(one, rom.Structure):
            same(one, other)
        elif scipy.sparse.issparse(one):
            assert (one != other).nnz == 0
        else:
            assert one == other


@pytest.mark.parametrize("sparse", [False, True])
def test_what_was_kept_is_what_was_computed(counted, sparse):
    force = np.zeros(beam().n_dofs)
    force[TIP] = 0.05
    rests = [kept.kept_preload(beam(sparse), LAW, force) for _ in range(2)]
    same(*rests)
    law = rests[0].law
    reductions = [
        kept.kept_reduction(beam(sparse), (0, 1), "consistent", law, [0.1 + 0.2j, 0j])
        for _ in range(2)
    ]
    same(*reductions)
    assert counted == ["preload", "reduce"]
    plain = rom.reduce(beam(sparse), (0, 1), law=law, aerodynamics=[0.1 + 0.2j, 0j], warned=False)
    np.testing.assert_array_equal(plain.contact_shapes, reductions[1].contact_shapes)
    np.testing.assert_array_equal(plain.aerodynamics, reductions[1].aerodynamics)


def test_other_questions_have_other_answers(counted):
    asked = [
        (beam(), (0,), "consistent", LAW, None),
        (beam(), (1,), "consistent", LAW, None),
        (beam(factor=1.0 + 1e-15 * 4), (0,), "consistent", LAW, None),
        (beam(), (0,), "consistent", rom.Jenkins(1.0, 2.0), None),
        (beam(), (0,), "consistent", LAW, [0.1j]),
        (beam(sparse=True), (0,), "consistent", LAW, None),
    ]
    for question in asked:
        kept.kept_reduction(*question)
    assert counted == ["reduce"] * len(asked)
    assert len(disk_cache.entries()) == len(asked)


def test_small_structures_and_damaged_files_are_computed(counted, monkeypatch, tmp_path):
    question = (beam(), (0,), "consistent", LAW, None)
    first = kept.kept_reduction(*question)
    (file,) = disk_cache.entries()
    file.write_bytes(file.read_bytes()[:1000])
    same(first, kept.kept_reduction(*question))
    assert counted == ["reduce"] * 2
    same(first, kept.kept_reduction(*question))  # replaced
    assert counted == ["reduce"] * 2
    monkeypatch.setattr(kept, "LARGE", 1000)
    kept.kept_reduction(*question)
    assert counted == ["reduce"] * 3


def test_a_plan_finds_them_again(counted):
    plans = [make_plan(load_scene("one-mode")) for _ in range(2)]
    assert counted == ["reduce"]
    assert plans[0].amplitude == plans[1].amplitude
    same(plans[0].excited.reduced, plans[1].excited.reduced)
