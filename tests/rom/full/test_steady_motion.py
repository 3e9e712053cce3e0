"""What of a motion is on the lattice of harmonics, and the structure that a reduced model has."""

import numpy as np
import pytest
from elastic.family import member

from slipmode import rom
from slipmode.rom import full
from slipmode.rom.full.structures import ReducedStructure
from slipmode.rom.full.window import Window

FREQUENCY = (1.0, 2.83)


def window(frequency=FREQUENCY):
    structure = rom.two_mass()
    force = ({0: 1.0}, {1: 1.0})[: len(frequency)]
    return Window.of_lines(full.Excitation.harmonic(structure, force, frequency))


@pytest.mark.parametrize("frequency", [(1.0,), FREQUENCY])
@pytest.mark.parametrize(("line", "share"), [(0.5, 0.05), (1.37, 0.02), (None, 0.0)])
def test_lines_beside_the_harmonics_are_found(frequency, line, share):
    looked = window(frequency)
    t = looked.times(3.0)
    signal = 5.0 + np.cos(t) + 0.3 * np.sin(3.0 * frequency[0] * t + 1.0)
    signal += 0.2 * np.cos((4.0 * frequency[0] - frequency[-1]) * t)
    if line is not None:
        signal += share * (np.std(signal) * np.sqrt(2.0)) * np.cos(line * t)
    found = looked.nonharmonic(np.column_stack((signal, 2.0 * signal)))
    assert found.share == pytest.approx(share, rel=0.02, abs=1e-4)
    if line is not None:
        assert found.frequency == pytest.approx(line, abs=0.01)


def test_lines_are_projected_out():
    looked = window()
    t = looked.times(1.0)
    signal = 3.0 + 2.0 * np.real((0.2 - 0.4j) * np.exp(1j * 2.83 * t)) + np.cos(0.4 * t)
    found = looked.project(t, signal[:, np.newaxis], np.array([0.0, 2.83, 4.83]))
    assert found[:, 0] == pytest.approx([1.5, 0.2 - 0.4j, 0.0], abs=1e-9)


@pytest.mark.parametrize("seed", [34, 56])
def test_a_reduced_model_has_its_structure(seed):
    case = member(seed)
    reduced = rom.reduce(case.structure, case.modes, law=case.law)
    small, of = ReducedStructure.of(reduced), case.structure
    shapes = small.shapes
    assert shapes[:, : len(case.modes)] == pytest.approx(reduced.mode_shapes)
    size = np.abs(np.diag(small.structure.stiffness)).max()
    for name, scale in (("mass", 1.0), ("stiffness", size), ("damping", 1.0)):
        expected = shapes.T @ getattr(of, name) @ shapes
        assert getattr(small.structure, name) == pytest.approx(expected, abs=1e-5 * scale), name
    assert small.structure.directions == pytest.approx(shapes.T @ of.directions, abs=1e-6)


def test_a_motion_that_does_not_settle_says_what_else_is_in_it():
    """A beam that rings on a frictional contact at frequencies of its own."""
    case = member(30)
    excitation = full.Excitation.harmonic(case.structure, case.force, np.array(case.frequency))
    with pytest.raises(rom.SlipmodeError, match=r"\d+ % of the contact motion is not at"):
        full.steady_amplitude(case.structure, case.law, excitation, most_windows=4)


@pytest.mark.parametrize("beta", [0.01, None])
def test_a_model_of_bonded_contacts_has_its_structure(beta):
    """Of all modes, so that nothing is left out: the mean and the response to a force."""
    structure = rom.two_mass() if beta is None else rom.two_mass(beta=beta)
    reduced = rom.reduce(structure, smallest_response=0.0)
    small = ReducedStructure.of(reduced)
    for name in ("mass", "stiffness", "damping"):
        expected = small.shapes.T @ getattr(structure, name) @ small.shapes
        assert getattr(small.structure, name) == pytest.approx(expected, abs=1e-12), name
    W = structure.directions
    assert small.structure.directions == pytest.approx(small.shapes.T @ W, abs=1e-12)


@pytest.mark.parametrize("detuning", [0.0, 1e-3])
def test_the_rest_of_a_slow_transient_is_in_the_error(detuning):
    """A mass with a damping ratio of 1e-4 changes by 1.2 % of its transient in 20 periods."""
    structure = rom.Structure([[1.0]], [[1.0]], damping=[[2e-4]], contact=[0])
    frequency, tolerance = 1.0 + detuning, 0.01
    result = full.steady_amplitude(
        structure,
        rom.Coulomb(0.0),
        full.Excitation.harmonic(structure, [{0: 1.0}], [frequency]),
        periods=20,
        tolerance=tolerance,
        steps_per_period=32,
        most_windows=1000,
    )
    exact = 0.5 / (1.0 - frequency**2 + 2e-4j * frequency)
    off = abs(result.amplitude[0, 0] - exact)
    assert off <= result.error[0, 0]
    assert off <= 1.5 * tolerance * abs(exact)
    assert result.error[0, 0] <= 3.0 * tolerance * abs(exact)
