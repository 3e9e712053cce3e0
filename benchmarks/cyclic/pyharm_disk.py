"""A response curve of a bladed disk beside pyHarm-os, harmonic balance of all sectors.

    make bench-pyharm

The disk is the lumped disk of pyHarm's tutorial, with a Jenkins contact between the blade tips
of neighbours and an excitation of engine order 3. pyHarm solves the full annulus at successive
frequencies by Newton's method with its analytical Jacobian; the tangent at a solution predicts
the next one. slipmode follows the travelling wave of one sector: by a model and its response
curve, and without a table by `TravellingWave.steady_states`. The table of results has the
processor time per point, with BLAS on one thread and without compilation, and its ratio to the
time of slipmode's curve. Errors of the amplitude of a blade tip are differences from the finest
setting of pyHarm, relative to the peak: at the peak, and the largest one.
"""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from pyHarm.Maestro import Maestro

from benchmarks.measure import one_thread, processor_time
from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.structure.matrices import as_dense

SECTORS, ORDER, TIP = 24, 3, 2
LIMIT, STIFFNESS, FORCE = 1.0, 5e4, 4.0  # of a contact [N], [N/m]; on a blade tip [N]
SPAN = 0.97, 0.99  # of the curve, relative to the frequency with stuck contacts
CURVE_POINTS, POINTS = 250, 25  # of the response curve; solved without a table and by pyHarm
FINEST = (1, 3, 5, 7), 1024  # harmonics; time samples per period
SETTINGS = ((1,), 32), ((1,), 64), ((1, 3), 64), ((1, 3), 128), ((1, 3, 5), 256)


def annulus() -> dict[str, Any]:
    """Return the disk as input of pyHarm: substructure, contacts and forces."""
    whole = rom.lumped_disk(SECTORS, 1e-5).annulus()
    matrices = {"M": whole.mass, "C": whole.damping, "K": whole.stiffness}
    contact = {"type": "Jenkins", "dirs": [0], "mu": 1.0, "N0": LIMIT, "k": STIFFNESS}
    force = {"type": "GOForcing", "dirs": [0], "amp": FORCE, "dto": 0, "ho": 1}
    tips = [("disk", [3 * j + TIP]) for j in range(SECTORS)]
    connectors = {}
    for j, tip in enumerate(tips):
        connectors[f"contact {j}"] = contact | {"connect": [tip, tips[(j + 1) % SECTORS]]}
        # pyHarm subtracts phi from the phase of the carrier.
        phase = -2.0 * np.pi * ORDER * j / SECTORS
        connectors[f"force {j}"] = force | {"connect": [tip, ("GROUND", [0])], "phi": phase}
    disk = {"matrix": {name: as_dense(each) for name, each in matrices.items()}, "ndofs": 1}
    return {"substructures": {"disk": disk}, "connectors": connectors}


def balanced(omega: Floats, harmonics: tuple[int, ...], samples: int) -> tuple[float, Floats]:
    """Return pyHarm's processor time per point [s], and the amplitudes of the tips [m]."""
    step = omega[1] - omega[0]
    curve = {
        "study": "frf",
        "corrector": "nocontinuation",
        "predictor": "tangent",
        "predictor_options": {"norm": "om", "bifurcation_detect": False},
        "stepsizer": "constant",
        "solver": "NewtonRaphson",
        "solver_options": {"tol_residual": 1e-3, "tol_delta_x": 1e-6},  # norms are 20 N and 2 mm
        "puls_inf": omega[0],
        "puls_sup": omega[-1] - 0.5 * step,  # it stops at the first point beyond
        "ds0": step,
        "ds_max": step,
        "verbose": False,
    }
    system = {"type": "Base", "nh": list(harmonics), "nti": samples}
    maestro = Maestro(annulus() | {"system": system, "analysis": {"curve": curve}})
    solver, dofs = maestro.nls["curve"], maestro.system.expl_dofs
    seconds, _ = processor_time(solver.Solve)
    found = solver.SolList
    assert len(found) == omega.size
    assert all(each.flag_accepted for each in found)
    carrier = dofs[dofs.harm == 1]
    parts = [carrier[carrier.node_num == 3 * j + TIP].index for j in range(SECTORS)]
    tips = [[np.linalg.norm(each.x[part]) for part in parts] for each in found]
    return seconds / omega.size, np.array(tips)


def followed(omega: Floats, wave: rom.TravellingWave) -> tuple[float, float, Floats]:
    """Return slipmode's times of the table and per point [s], and the amplitude of a tip [m]."""
    force, middle = {TIP: FORCE}, 0.5 * (omega[0] + omega[-1])
    (state,) = wave.steady_states(middle, force)
    table, model = processor_time(
        lambda: wave.tabulate(1.5 * abs(state.amplitude), force, frequency=middle)
    )
    follow: Callable[..., Any] = partial(
        rom.response_curve, model, [middle], [force], "frequency_A", (omega[0], omega[-1])
    )
    step = 1.0 / CURVE_POINTS
    for _ in range(3):  # points are closer where the curve bends
        curve = follow(largest_step=step)
        step *= curve.parameter.size / CURVE_POINTS
    seconds, curve = processor_time(lambda: follow(largest_step=step), 5)
    amplitude = np.interp(omega, curve.parameter, curve.displacement(TIP)[:, 0])
    return table, seconds / curve.parameter.size, amplitude


def main() -> None:
    """Print times, errors and ratios."""
    logging.disable()
    warnings.filterwarnings("ignore", message=".*faster on contiguous arrays")  # of numba
    disk, law = rom.lumped_disk(SECTORS, 1e-5), rom.Jenkins(LIMIT, STIFFNESS)
    wave = rom.travelling_wave(disk, law, ORDER)
    omega = wave.frequency * np.linspace(*SPAN, POINTS)
    with one_thread():
        balanced(omega[:2], (1,), 64)  # compiles
        finest, blades = balanced(omega, *FINEST)
        exact = blades.mean(axis=1)
        table, point, tip = followed(omega, wave)
        direct, states = processor_time(
            lambda: [wave.steady_states(each, {TIP: FORCE})[0] for each in omega]
        )
        steady = np.array([2.0 * abs(state.displacement[TIP]) for state in states])

        def show(name: str, seconds: float, amplitude: Floats) -> None:
            at_peak = amplitude.max() / exact.max() - 1.0
            worst = np.abs(amplitude - exact).max() / exact.max()
            cost = f"{1e3 * seconds:9.3f} ms {seconds / point:8.0f}"
            print(f"{name:>26} {cost} {1e3 * amplitude.max():9.5f} mm {at_peak:8.3%} {worst:8.3%}")

        print(f"{'':>26} {'a point':>12} {'times':>8} {'peak':>12} {'error':>8} {'worst':>8}")
        show(f"slipmode (table {table:.2f} s)", point, tip)
        show("slipmode without table", direct / POINTS, steady)
        for harmonics, samples in SETTINGS:
            seconds, tips = balanced(omega, harmonics, samples)
            show(f"pyHarm {harmonics}, {samples}", seconds, tips.mean(axis=1))
        show(f"pyHarm {FINEST[0]}, {FINEST[1]}", finest, exact)
        spread = np.ptp(blades, axis=1).max() / exact.max()
        print(f"the blades of pyHarm differ by {spread:.0e} of the peak")


if __name__ == "__main__":
    main()
