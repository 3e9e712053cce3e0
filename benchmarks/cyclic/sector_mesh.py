"""A sector mesh of 1e5 DOFs: all nodal diameters, and a response curve: make bench-disk.

Times are of the wall clock and of the processors. With one thread (MKL_NUM_THREADS=1,
OPENBLAS_NUM_THREADS=1) the processor needs 170 to 180 s: 22 s for the matrices, 11 s for the
elimination of the interior, 6 s a nodal diameter, 58 s for the wave. The memory is 2.4 GB.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from benchmarks.cyclic.sector import sector
from slipmode import rom
from slipmode.rom.cyclic.diameter_modes import DiameterModes

_SECTORS, _DIAMETER, _MODES = 24, 5, 4
_LIMIT, _STIFFNESS = 20.0, 2e6  # of the contacts between blade tips [N], [N/m]
_FORCE = 10.0  # at each contact node of the blade, along the axis [N]


def main(arguments: list[str] | None = None) -> None:
    """Print what each step takes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--elements", type=int, nargs=3, default=(48, 26, 25), help="of a sector")
    options = parser.parse_args(arguments)
    with _timed("mesh and matrices"):
        solid = sector(_SECTORS, *options.elements)
        own, other = solid.mesh.dofs[solid.right_face, 2], solid.mesh.dofs[solid.left_face, 2]
        rubbing = slice(0, own.size, max(own.size // 6, 1))  # along the axis
        size, count = solid.mass.shape[0], own[rubbing].size
        following = np.zeros((size, count))
        following[other[rubbing], np.arange(count)] = -1.0
    with _timed(f"cyclic structure of {size} DOFs a sector, {count} contacts"):
        structure = rom.Structure(solid.mass, solid.stiffness, 2e-7, contact=own[rubbing])
        disk = solid.mesh.cyclic(structure, _SECTORS, following)
    law = rom.Jenkins(_LIMIT, _STIFFNESS)
    springs = law.elements(disk.n_contacts).reference
    with _timed(f"{_MODES} modes of {disk.highest_diameter + 1} nodal diameters"):
        for k in range(disk.highest_diameter + 1):
            modes = DiameterModes.of(disk, k, springs, _MODES, lambda squares: 0.0)
            hertz = modes.frequency[:_MODES] / (2.0 * np.pi)
            print(f"  {k:2}: {', '.join(f'{each:.1f}' for each in hertz)} Hz", flush=True)
    with _timed(f"travelling wave of nodal diameter {_DIAMETER}"):
        wave = rom.travelling_wave(disk, law, _DIAMETER)
        force = {int(np.searchsorted(disk.free_dofs, dof)): _FORCE for dof in own}
    with _timed("its steady state at the natural frequency"):
        (state,) = wave.steady_states(wave.frequency, force)
    with _timed("its friction table"):
        model = wave.tabulate(3.0 * abs(state.amplitude), force)
    with _timed("its response curve"):
        span = (0.98 * wave.frequency, 1.02 * wave.frequency)
        curve = rom.response_curve(model, [wave.frequency], [force], vary="frequency_A", span=span)
    print(f"{curve}")


@contextmanager
def _timed(what: str) -> Iterator[None]:
    start, used = time.perf_counter(), time.process_time()
    yield
    wall, processor = time.perf_counter() - start, time.process_time() - used
    print(f"{what}: {wall:.1f} s, {processor:.1f} s of the processors", flush=True)


if __name__ == "__main__":
    main()
