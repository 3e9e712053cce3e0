"""Contact and elastic outputs of the component, against the reconstructed motion."""

from functools import cache

import numpy as np
import pytest
from slow_time import slow_trajectory
from stepping import FORCE_PATTERNS, HELD, component, march, model

from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.slow.motion import reconstruct
from slipmode.rom.slow.response_surface import response_surface
from slipmode.runner.report.cases.structures import six_dofs


@cache
def model_at_the_forcing(structure, modes=(0, 1)):
    """With its contact problem at the forcing frequencies, where it is exact."""
    reduced = rom.reduce(structure(), modes).at_carrier((0.98, 1.65)[: len(modes)])
    amplitude = (4.0, 2.0)[: len(modes)]
    return rom.tabulate(reduced, rom.Tanh(2.0, 0.02), amplitude, 1e-3, harmonics=RESPONSE_ORDER)


def errors_of_motion(of, dofs, durations, measure, steps_per_period):
    """{quantity: error of its worst signal} against the reconstruction in so many steps."""
    held = {name: value for name, value in HELD.items() if "AB".index(name[-1]) < of.modes}
    stepped = component(of=of, contact=True, elastic=dofs)
    columns = dict(zip(stepped.output_names, march(stepped, durations).T, strict=True))
    time = np.append(0.0, np.cumsum(durations))
    trajectory = slow_trajectory(of, FORCE_PATTERNS[: of.modes], time, **held)
    motion = reconstruct(of, trajectory, trajectory.time[1:], steps_per_period=steps_per_period)
    contacts = range(of.reduced.n_contacts)
    expected = {
        **dict(zip("xvf", (motion.displacement, motion.velocity, motion.force), strict=True)),
        "elastic": motion.elastic(of, dofs),
    }
    names = {quantity: [f"contact_{i}_{quantity}" for i in contacts] for quantity in "xvf"}
    names["elastic"] = [f"x_{dof}" for dof in dofs]
    return {
        quantity: max(
            measure(columns[name], values)
            for name, values in zip(names[quantity], signals.T, strict=True)
        )
        for quantity, signals in expected.items()
    }


def largest_error(values, expected):
    return np.abs(values - expected).max() / np.abs(expected).max()


def rms_error(values, expected):
    return np.sqrt(np.mean((values - expected) ** 2) / np.mean(expected**2))


@pytest.mark.parametrize("step", [0.7, 10.0, 100.0])
@pytest.mark.parametrize("modes", [(0,), (0, 1)], ids=["one mode", "two modes"])
def test_contact_outputs_are_the_reconstructed_motion(modes, step, monkeypatch):
    monkeypatch.setattr("slipmode.fmu.component.STEPS_PER_PERIOD", 256)
    of = model_at_the_forcing(rom.two_mass, modes)
    errors = errors_of_motion(of, (0, 1), np.full(round(700.0 / step), step), largest_error, 256)
    # measured 2.1e-4, 3.0e-3, 9.0e-4, 1.8e-4: the harmonics that are left out
    bounds = {"x": 2.4e-4, "v": 3.2e-3, "f": 1e-3, "elastic": 2e-4}
    assert all(errors[name] < bound for name, bound in bounds.items()), errors


@pytest.mark.parametrize(
    ("structure", "dofs", "measured"),
    [
        (rom.two_mass, (0, 1), {"x": 5.1e-3, "v": 9.9e-2, "f": 1.43e-3, "elastic": 9.3e-5}),
        (six_dofs, (0, 1, 2), {"x": 3.9e-3, "v": 9.4e-2, "f": 3.12e-3, "elastic": 3.3e-4}),
    ],
)
def test_errors_of_contact_motion_at_a_communication_step_of_1_s(structure, dofs, measured):
    """Of its steps: velocity has corners, and is sampled wherever it is at the moment."""
    of = model_at_the_forcing(structure)
    errors = errors_of_motion(of, dofs, np.full(400, 1.0), rms_error, 512)
    assert errors == pytest.approx(measured, rel=0.06)


def test_contact_motion_needs_the_harmonics_that_the_modes_respond_to():
    reduced, law = rom.reduce(rom.two_mass(), (0,)), rom.Tanh(2.0, 0.02)
    excluded = rom.tabulate(reduced, law, (1.0,), tolerance=1e-2)
    Component(excluded)
    with pytest.raises(rom.SlipmodeError, match=r"contact: .* tabulate it with harmonics=5"):
        Component(excluded, contact=True)


def test_harmonics_without_a_response_that_matters_are_left_out():
    of = model_at_the_forcing(rom.two_mass)
    kept = {tuple(order) for order in response_surface(of).orders.tolist()}
    assert {(1, 0), (0, 1), (2, -1), (3, -2)} < kept < set(of.harmonics.orders)
    assert response_surface(model(formulation="paper")).orders.shape == (0, 2)
