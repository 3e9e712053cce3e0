"""Modes that are proposed to be retained together, beside the true error without them."""

import numpy as np
import pytest
from evidence.answers import MODE_SLIDERS, forces, structure_and_law
from oracles.families import case, close_modes
from oracles.harmonic_balance import balance

from slipmode import fmu, rom
from slipmode.runner import parse_scene, plan_scene

pytestmark = pytest.mark.oracle


def error_of_one_mode(given, mode):
    """Relative error of an amplitude in a run, half a per cent off the reference of the table."""
    (tone,), (structure, law, elastic) = given.tones, structure_and_law(given)
    options = {"force_patterns": forces(given), "carrier": [1.005 * tone.Omega], "law": elastic}
    small = rom.reduce(structure, [mode], warned=False, **options)
    project = 0.5 * small.mode_shapes[:, 0] @ given.system.M
    a = project @ balance(given.system, tone.Omega, tone.F)[1]
    model = rom.tabulate(small, law, [2.0 * abs(a)], 1e-3, warned=False)
    component = fmu.Component(model, forces(given), warned=False)
    component.set_inputs(force_A=1.0, frequency_A=tone.Omega)
    component.do_step(0.0, 3000 * 2.0 * np.pi / tone.Omega)
    found = component.outputs()
    return abs(complex(found["A_re"], found["A_im"]) / a - 1.0)


def proposals(given, mode):
    structure, law, elastic = structure_and_law(given)
    table = rom.modes(structure, elastic, 12)
    found = [each for each in table.together if each.mode == mode]
    assert all(f"{each.reason}; {each.advice}" in str(table) for each in found)
    for each in found:
        if each.order == 1:
            call = each.advice.partition("as well, ")[2].partition(", in a scene")[0]
            reduced = eval(call, {"rom": rom, "structure": structure, "law": law})
            assert reduced.modes == tuple(sorted((mode, *each.others)))
    return found


@pytest.mark.parametrize(
    "distance", [0.0, *(pytest.param(d, marks=pytest.mark.slow) for d in (0.003, 0.01, 0.12))]
)
def test_a_mode_that_a_harmonic_meets_is_proposed_where_it_matters(distance):
    """True errors are up to 7 %, and at most 1.4 times the stated effect."""
    errors, met = [], []
    for seed in range(12):
        given = case(seed, 1, MODE_SLIDERS, 3.0, distance, (0.03, 0.1))
        (mode,) = given.modes
        third = [each for each in proposals(given, mode) if each.order == 3]
        met.append(max((each.effect for each in third), default=0.0))
        errors.append(error_of_one_mode(given, mode))
        assert all("three times" in each.reason and "ratio=3" in each.advice for each in third)
    errors, met = np.array(errors), np.array(met)
    if distance > 0.1:
        assert not met.any() and np.median(errors) < 3e-3
    else:
        wrong = errors > 0.01
        assert wrong.sum() >= 4 and (errors[wrong] < 2.0 * met[wrong]).all()


@pytest.mark.parametrize(
    ("seed", "distance", "mode"),
    [(26, 0.03, 0), (13, 0.06, 0), (2, 0.003, 1), (9, 0.01, 1), (25, 0.1, 1), (37, 0.14, 0),
     (8, 0.3, 0), (11, 0.3, 0), (18, 0.3, 0), (17, 0.2, 1)],
)  # fmt: skip
def test_neighbours_are_proposed_where_they_matter(seed, distance, mode):
    """Errors of one mode are 6 to 19 % with a neighbour within 15 %, and below 0.4 % without."""
    given = close_modes(seed, distance)
    error = error_of_one_mode(given, mode)
    near = [each.others for each in proposals(given, mode) if each.order == 1]
    other = sum(given.modes) - mode
    assert (near, error > 0.01) == (([(other,)], True) if distance < 0.15 else ([], False))


SCENE = """
title = "two neighbours, and a mode at a harmonic"
structure = {matrices = "three.npz"}
contacts = [{law = "jenkins", limit = 0.05, stiffness = 0.1}]
modes = {A = 0}
forcing = {A = {dof = 0, amplitude = 0.05, frequency = 1.01}}
run = {duration = 300.0, step = 1.0}
"""


def test_a_plan_names_how_to_retain_modes(tmp_path):
    stiffness, W = np.diag([1.0, 1.08, 9.3]), np.array([[1.0], [0.8], [0.8]])
    rom.Structure(np.eye(3), stiffness, 0.005 * np.eye(3), contact=W).save(tmp_path / "three.npz")
    close, third = plan_scene(parse_scene(SCENE, tmp_path)).warnings
    assert close.startswith("mode A is close to another mode: mode 1 is ")
    call = "rom.reduce(structure, (0, 1), tones=(0, 0), law=law), in a scene [modes] A = [0, 1]"
    assert close.endswith(
        f" above mode 0, and both move the contacts; retain mode 1 as well, {call}"
    )
    assert third.startswith("mode A excites another mode: three times the frequency of mode 0 ")
    call = "rom.reduce(structure, (0, 2), ratio=3, law=law), in a scene [modes] B = 2, ratio = 3"
    assert third.endswith(f"retain mode 2 as well, {call}")
