"""A model in slow time: what several tests march."""

import numpy as np

from slipmode.fmu import Component
from slipmode.rom import SlowTrajectory
from slipmode.rom.reduction.force_response import AppliedForces
from slipmode.rom.slow.slow_flow import ForcedFlow


def mass_and_slow_root(reduced, frequency):
    """P [rad/s] and r [rad/s] of the amplitude equations (d/dt + P) (d/dt - r) a = G, written out.

    In the "paper" formulation the carrier is the natural frequency, the detuning enters to first
    order and P alone stands for d/dt + P; in "consistent" the carrier is the forcing itself, and r
    is how the mode vibrates without contacts.
    """
    Omega = np.asarray(frequency, dtype=float)
    omega, half = reduced.frequency, 0.5 * reduced.modal_damping
    if reduced.formulation == "paper":
        return np.broadcast_to(2j * omega, Omega.shape), -half + 1j * (omega - Omega)
    vibration = np.sqrt(omega**2 - half**2)
    return half + 1j * (vibration + Omega), -half + 1j * (vibration - Omega)


def steady_balance(model, amplitude, frequency, force):
    """What balances at amplitudes (points, modes) under modal forces (modes,)."""
    points = np.atleast_2d(np.asarray(amplitude, dtype=complex))
    return ForcedFlow.of(model, np.broadcast_to(frequency, points.shape), force).balance(points)


def slow_trajectory(model, force_patterns, time, *, start=(0.0, 0.0), tolerance=1e-6, **inputs):
    """March from amplitudes `start` through `time`.

    Inputs are named like the component's; each is a number or its values at the start of every
    step. What is not given is 0, but for the frequencies, which are the natural ones, and the
    friction limits, which are the model's.
    """
    component = Component(model, force_patterns, tolerance=tolerance)
    component.reset(time[0], start)
    given = {f"frequency_{m}": f for m, f in zip("AB", model.reduced.frequency, strict=False)}
    if "limit_scale" in component.input_names:
        given["limit_scale"] = 1.0
    scripted = np.zeros((time.size - 1, len(component.input_names)))
    for name, values in (given | inputs).items():
        scripted[:, component.input_names.index(name)] = values
    first = np.array(list(component.outputs().values()))
    rows = np.vstack((first, component.run(np.diff(time), scripted)))
    output = dict(zip(component.output_names, rows.T, strict=True))
    modes = "AB"[: model.modes]

    def inputs_of(quantity):
        names = [component.input_names.index(f"{quantity}_{mode}") for mode in modes]
        return scripted[:, names]

    to_modal = [
        model.reduced.modal_force(mode, pattern) for mode, pattern in enumerate(force_patterns)
    ]
    excitation = to_modal * np.exp(1j * inputs_of("phase"))
    held, rate = inputs_of("force") * excitation, inputs_of("force_rate") * excitation
    rate = rate + 1j * inputs_of("phase_rate") * held
    until = np.diff(time)[:, np.newaxis]
    grown = inputs_of("force") + inputs_of("force_rate") * until
    end = grown * excitation * np.exp(1j * inputs_of("phase_rate") * until)
    onset = np.vstack((np.zeros_like(held[:1]), held[1:] - end[:-1]))
    angle = np.column_stack([output[f"theta_{m}"] for m in modes])
    force_response = AppliedForces.of(model.reduced, force_patterns)
    return SlowTrajectory(
        time=output["time"],
        amplitude=np.column_stack([output[f"{m}_re"] + 1j * output[f"{m}_im"] for m in modes]),
        angle=angle,
        frequency=inputs_of("frequency"),
        frequency_rate=inputs_of("frequency_rate"),
        force=held,
        force_rate=rate,
        discontinuity=force_response.free_vibration(onset, inputs_of("frequency"), angle[:-1]),
    )
