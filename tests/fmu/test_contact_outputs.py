"""Contact and elastic outputs of the component, against the reconstructed motion."""

from functools import cache

import numpy as np
import pytest
from slow_time import slow_trajectory
from stepping import FORCE_PATTERNS, HELD, component, march, model

from benchmarks.cases import six_dofs
from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom import full, reconstruct
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER
from slipmode.rom.slow.nonresonant.response_surface import response_surface

LAW = rom.Tanh(limit=2.0, alpha=0.02)


@cache
def model_at_the_forcing(structure, modes=(0, 1)):
    """With its contact problem at the forcing frequencies, where it is exact."""
    reduced = rom.reduce(structure(), modes).at_carrier((0.98, 1.65)[: len(modes)])
    amplitude = (4.0, 2.0)[: len(modes)]
    return rom.tabulate(reduced, LAW, amplitude, 1e-3, harmonics=RESPONSE_ORDER)


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
    monkeypatch.setattr("slipmode.fmu.handle.STEPS_PER_PERIOD", 4096)
    of = model_at_the_forcing(rom.two_mass, modes)
    errors = errors_of_motion(of, (0, 1), np.full(round(700.0 / step), step), largest_error, 4096)
    # measured 2.1e-4, 3.0e-3, 9.0e-4, 1.8e-4: the harmonics that are left out
    bounds = {"x": 2.4e-4, "v": 3.2e-3, "f": 1e-3, "elastic": 2e-4}
    assert all(errors[name] < bound for name, bound in bounds.items()), errors


@pytest.mark.parametrize(
    ("structure", "dofs", "measured"),
    [
        (rom.two_mass, (0, 1), {"x": 3.5e-4, "v": 1.02e-2, "f": 7.0e-4, "elastic": 9.2e-5}),
        (six_dofs, (0, 1, 2), {"x": 6.7e-4, "v": 8.2e-3, "f": 5.4e-4, "elastic": 4.0e-4}),
    ],
)
def test_errors_of_contact_motion_at_a_communication_step_of_1_s(structure, dofs, measured):
    """Of its steps, which follow what is left of a contact's vibration as it begins to slip."""
    of = model_at_the_forcing(structure)
    errors = errors_of_motion(of, dofs, np.full(400, 1.0), rms_error, 512)
    assert errors == pytest.approx(measured, rel=0.1)


@cache
def full_order():
    """Contact motion of one mode near resonance, from rest: (time, {quantity: (n, N_c)})."""
    structure = rom.two_mass(beta=0.01)
    excitation = full.Excitation.harmonic(structure, ({0: 0.15},), (0.9825,))
    times = np.round(np.arange(751.0, 799.01, 0.02), 2)
    motion = full.integrate(structure, LAW, excitation, times, steps_per_period=2048)
    signals = (motion.contact_displacement, motion.contact_velocity, motion.contact_force)
    return times, dict(zip("xvf", signals, strict=True))


def near_resonance():
    reduced = rom.reduce(rom.two_mass(beta=0.01), (0,)).at_carrier((0.9825,))
    of = rom.tabulate(reduced, LAW, (4.0,), 1e-3, harmonics=RESPONSE_ORDER)
    stepped = Component(of, ({0: 1.0},), contact=True)
    stepped.set_inputs(force_A=0.15, frequency_A=0.9825)
    return stepped


@pytest.mark.parametrize("step", [0.02, 0.1, 0.5, 1.0, 2.0])
def test_contact_motion_is_that_of_full_order_at_every_communication_step(step):
    """Measured: x 0.05 %, v 1.1 %, f 0.07 % at most; 0.4, 13.7, 0.5 % in equal steps."""
    times, expected = full_order()
    stepped = near_resonance()
    inputs = np.array([[0.15, 0.0, 0.9825, 0.0, 0.0, 0.0]])
    assert stepped.input_names[0::2] == ("force_A", "frequency_A", "phase_A")
    stepped.do_step(0.0, times[0])
    steps = round(48.0 / step)
    rows = stepped.run(np.full(steps, step), np.tile(inputs, (steps, 1)))
    every = round(step / 0.02)
    for quantity, bound in {"x": 1e-3, "v": 0.015, "f": 1e-3}.items():
        found = rows[:, stepped.output_names.index(f"contact_0_{quantity}")]
        assert rms_error(found, expected[quantity][every::every, 0]) < bound


@pytest.mark.parametrize("every", [5, 10], ids=["0.1 s", "0.2 s"])
def test_recorded_contact_motion_is_that_of_full_order(every):
    """Measured: x 0.03 %, v 0.8 %, f 0.02 %; v 2.7 and 3.9 % in equal steps."""
    times, expected = full_order()
    of = near_resonance().model
    slow = slow_trajectory(of, ({0: 1.0},), np.arange(801.0), force_A=0.15, frequency_A=0.9825)
    motion = reconstruct(of, slow, times[::every])
    found = {"x": motion.displacement, "v": motion.velocity, "f": motion.force}
    for quantity, bound in {"x": 1e-3, "v": 0.015, "f": 1e-3}.items():
        assert rms_error(found[quantity][:, 0], expected[quantity][::every, 0]) < bound


@pytest.mark.parametrize("pattern", [(1.0,), (0.3, 0.7), (2.0,)], ids=str)
def test_contact_motion_differs_between_choices_of_steps_by_no_more_than_is_said(pattern):
    """What documentation.py states. Measured: x and f 0.07 %, v 0.8 %."""
    rows = []
    for steps in (pattern, (0.05,) * 40):
        stepped, time, read = near_resonance(), 100.0, []
        stepped.do_step(0.0, time)
        while len(read) < 30:
            until = time + 2.0
            while time < until - 1e-9:
                for step in steps:
                    stepped.do_step(time, step)
                    time += step
                    outputs = stepped.outputs()
            read.append(list(outputs.values()))
        rows.append(dict(zip(outputs, np.array(read).T, strict=True)))
    some, others = rows
    for name, bound in (("A_re", 1e-6), ("A_im", 1e-6)):
        np.testing.assert_allclose(some[name], others[name], atol=bound)
    for i in (0, 1):
        for quantity, bound in {"x": 1e-3, "v": 0.015, "f": 1e-3}.items():
            name = f"contact_{i}_{quantity}"
            assert 0.0 < rms_error(some[name], others[name]) < bound


def test_contact_motion_hardly_depends_on_when_it_was_read_before():
    """Measured 2e-6: from rest, and 100 s later; unread contacts are not marched in between."""
    often, seldom = near_resonance(), near_resonance()
    for k in range(200):
        often.do_step(float(k), 1.0)
        often.outputs()
        seldom.do_step(float(k), 1.0)
        if k not in (99, 199):
            continue
        first, second = often.outputs(), seldom.outputs()
        for name in ("contact_0_x", "contact_0_f"):
            assert second[name] == pytest.approx(first[name], abs=1e-5)
        slow = [name for name in first if not name.startswith("contact")]
        assert [first[name] for name in slow] == [second[name] for name in slow]


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
