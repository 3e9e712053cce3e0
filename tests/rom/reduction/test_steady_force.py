"""The force that holds a mode steady, on contacts that it also moves past the mode."""

import numpy as np
import pytest
from elastic.cantilever import cantilever

from slipmode import rom
from slipmode.rom import ContactProblem, Discretisation, full
from slipmode.rom.reduction.force_response import steady_force

LAW = rom.Jenkins(limit=(0.2, 0.2, 0.02, 0.05), stiffness=(60.0, 40.0, 10.0, 30.0))
BODY = cantilever(LAW)
NODE_OF_MODE = 13  # where a force hardly moves the third mode
# mode, DOF of the force, detuning, force: most of it moves the contacts through other modes
CASES = [(0, 1, -0.003, 0.44), (0, 7, -0.0131, 0.107), (1, 19, -0.0287, 0.537)]


def reduced_at(mode, dof, detuning, known):
    omega = rom.reduce(BODY, (mode,), law=LAW).frequency
    patterns = ({dof: 1.0},) if known else None
    carrier = omega * (1.0 + detuning)
    return rom.reduce(BODY, (mode,), law=LAW, carrier=carrier, force_patterns=patterns)


def steady_error(case, known, reference):
    """Relative error of the steady complex amplitude."""
    mode, dof, detuning, size = case
    reduced = reduced_at(mode, dof, detuning, known)
    model = rom.tabulate(reduced, LAW, (1.4 * abs(reference),), tolerance=1e-3)
    found = rom.steady(model, reduced.carrier, ({dof: size},))[0]
    return abs(found - reference) / abs(reference)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_steady_states_have_what_a_force_does_past_its_mode(case):
    mode, dof, detuning, size = case
    reduced = reduced_at(mode, dof, detuning, known=True)
    excitation = full.Excitation.harmonic(BODY, ({dof: size},), reduced.carrier)
    reference = full.steady_amplitude(
        BODY,
        LAW,
        excitation,
        outputs=reduced.mode_shapes.T @ BODY.mass,
        tolerance=1e-4,
        steps_per_period=256,
    ).amplitude[0, 0]
    with pytest.raises(rom.SlipmodeError, match=r"^force_patterns: the forces also act on"):
        steady_error(case, known=False, reference=reference)  # 1.2 to 11 % off
    assert steady_error(case, known=True, reference=reference) < 0.003


def test_a_force_that_moves_the_contacts_past_its_mode_most_is_left_out():
    force, _ = steady_force(reduced_at(2, NODE_OF_MODE, -0.02, known=True))
    assert not force.any()


def test_one_contact_knows_all_of_the_force_by_the_shift():
    law = rom.Jenkins(0.2, 40.0)
    body = cantilever(LAW)
    alone = rom.Structure(body.mass, body.stiffness, body.damping, contact=body.directions[:, [0]])
    carrier = rom.reduce(alone, (0,), law=law).frequency
    reduced = rom.reduce(alone, (0,), law=law, carrier=carrier, force_patterns=({7: 1.0},))
    force, D = steady_force(reduced)
    assert abs(D[0] * force[0, 0]) <= 1e-9 * abs(reduced.coupling[0, 0])


def test_the_scale_of_a_pattern_does_not_matter():
    terms = [
        ContactProblem.of(rom.reduce(BODY, (0,), law=LAW, force_patterns=({7: scale},)), LAW)
        .on(Discretisation(64, 1))
        .solve([[0.005]])
        for scale in (1.0, -300.0)
    ]
    np.testing.assert_allclose(terms[0].S, terms[1].S, rtol=1e-7)  # marched to 1e-5


def test_a_model_keeps_the_patterns_it_was_tabulated_for(tmp_path):
    model = rom.tabulate(reduced_at(0, 7, -0.01, known=True), LAW, (0.005,), tolerance=1e-2)
    model.save(tmp_path / "model.rom")
    loaded = rom.Model.load(tmp_path / "model.rom")
    np.testing.assert_array_equal(loaded.reduced.force_patterns, model.reduced.force_patterns)
    assert loaded.hash == model.hash
    unknown = rom.tabulate(reduced_at(0, 7, -0.01, known=False), LAW, (0.005,), tolerance=1e-2)
    assert unknown.hash != model.hash


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"force_patterns": ({7: 1.0}, {7: 1.0})},
            "force_patterns: needs one entry per mode",
        ),
        ({"force_patterns": ({99: 1.0},)}, "force_patterns: DOF 99 is out of range"),
        ({"force_patterns": ([1.0, 2.0],)}, "force_patterns: must be 24 finite numbers"),
    ],
)
def test_patterns_that_do_not_fit_are_refused(given, said):
    with pytest.raises(rom.SlipmodeError, match=said):
        rom.reduce(BODY, (0,), law=LAW, **given)


def test_the_paper_knows_no_force_past_its_mode():
    with pytest.raises(rom.SlipmodeError, match="force_patterns: formulation must be"):
        rom.reduce(rom.two_mass(), formulation="paper", force_patterns=({0: 1.0}, {1: 1.0}))
