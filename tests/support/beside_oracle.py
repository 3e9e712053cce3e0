"""Structures and laws of slipmode as systems of the oracles; runs of both."""

from collections.abc import Mapping, Sequence

import numpy as np
from oracles.system import Coulomb, Frictional, Law, Sliders, System, Tanh, Tone, jenkins
from oracles.time_integration import Integrator, steady_harmonics

from slipmode import fmu, rom

PER_PERIOD = 32  # samples of a demodulated signal


def system_of(structure: rom.Structure, law: rom.Friction) -> System:
    """Return the matrices of a structure with its contacts as the oracles describe them."""
    contacts = structure.directions.shape[1]

    def each(value):
        return np.broadcast_to(value, contacts).astype(float).tolist()

    if isinstance(law, rom.Jenkins):
        laws = [jenkins(*pair) for pair in zip(each(law.limit), each(law.stiffness), strict=True)]
    elif isinstance(law, rom.Iwan):
        laws = [Sliders(*(tuple(part.tolist()) for part in law.distribution()))] * contacts
    elif isinstance(law, rom.Tanh):
        laws = [Tanh(limit, law.alpha) for limit in each(law.limit)]
    elif isinstance(law, rom.Coulomb):
        laws = [Coulomb(limit) for limit in each(law.limit)]
    else:
        stiffnesses = law.tangential_stiffness, law.normal_stiffness
        laws = [Frictional(law.mu, law.preload, *stiffnesses)] * (contacts // 2)
    return with_laws(structure, laws)


def with_laws(structure: rom.Structure, laws: Sequence[Law]) -> System:
    """Return the matrices of a structure with laws in the order of its contact DOFs."""
    M, C, K, W = (
        each.toarray() if hasattr(each, "toarray") else np.array(each, dtype=float)
        for each in (structure.mass, structure.damping, structure.stiffness, structure.directions)
    )
    return System(M, C, K, W, laws)


def relative_rms(found: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Return the RMS of each column's error, relative to the RMS of its exact values."""
    return np.linalg.norm(found - exact, axis=0) / np.linalg.norm(exact, axis=0)


def fluttering(system: System, shape: np.ndarray, coefficient: complex) -> System:
    """Return the system with the aerodynamic force -c q on a mode: Im c / omega is a damper."""
    along = system.M @ shape
    omega = np.sqrt(shape @ system.stuck() @ shape)
    K = system.K + coefficient.real * np.outer(along, along)
    C = system.C + coefficient.imag / omega * np.outer(along, along)
    return System(system.M, C, K, system.W, system.laws)


def vector(force: Mapping[int, float] | np.ndarray, dofs: int) -> np.ndarray:
    """Return a force {DOF: amplitude} as an array (n,)."""
    if not isinstance(force, Mapping):
        return np.asarray(force, dtype=complex)
    found = np.zeros(dofs, dtype=complex)
    found[list(force)] = list(force.values())
    return found


def steady_amplitudes(system, reduced, frequency, force, **options):
    """Return a_j (modes,) by time integration from rest, and their errors."""
    tones = [
        Tone(float(Omega), vector(f, len(system.M)))
        for Omega, f in zip(frequency, force, strict=True)
    ]
    found = steady_harmonics(system, tones, np.eye(len(tones), dtype=int).tolist(), **options)
    rows = reduced.mode_shapes.T @ system.M
    a = 0.5 * np.einsum("jn,jn->j", rows, found.amplitude)
    return a, 0.5 * np.einsum("jn,jn->j", np.abs(rows), found.error)


def demodulated(system, shape, frequency, force, start, periods, steps=256):
    """Integrate from x = 2 Re(shape start exp(i Omega t)); return a of each period (periods,)."""
    n, h = len(system.M), 2.0 * np.pi / frequency / steps
    inner = Integrator(system, vector(force, n).real[:, np.newaxis], h)
    inner.z[:n] = 2.0 * np.real(start) * shape
    inner.z[n:] = 2.0 * np.real(1j * frequency * start) * shape
    t = h * np.arange(periods * steps + 1)
    z, _ = inner.advance(np.cos(frequency * t)[:, np.newaxis], steps // PER_PERIOD)
    sampled = t[steps // PER_PERIOD :: steps // PER_PERIOD]
    carried = z[:, :n] @ (system.M @ shape) * np.exp(-1j * frequency * sampled)
    return carried.reshape(periods, PER_PERIOD).mean(axis=1)


def run(model, force_patterns, times, start=0.0, dofs=(), tolerance=1e-6, **inputs):
    """Step a component from time 0 to `times`; return its outputs there by name.

    `inputs` are numbers, or values at the start of every step. `dofs`: displacements among the
    outputs.
    """
    motion = {"contact": True, "elastic": dofs} if len(dofs) else {}
    component = fmu.Component(model, force_patterns, tolerance=tolerance, warned=False, **motion)
    component.reset(amplitude=start)
    natural = zip("AB", model.reduced.frequency, strict=False)
    given = {f"frequency_{mode}": omega for mode, omega in natural} | inputs
    if "limit_scale" in component.input_names:
        given = {"limit_scale": 1.0} | given
    rows = np.zeros((len(times), len(component.input_names)))
    for name, values in given.items():
        rows[:, component.input_names.index(name)] = values
    found = component.run(np.diff(times, prepend=0.0), rows)
    return dict(zip(component.output_names, found.T, strict=True))


def amplitudes(outputs):
    """Return a_j (times, modes) of the outputs of a run."""
    names = [mode for mode in "AB" if f"{mode}_re" in outputs]
    return np.column_stack([outputs[f"{m}_re"] + 1j * outputs[f"{m}_im"] for m in names])
