"""How time and memory of a reduction grow with the structure: make bench-scale.

Each size is read, checked and reduced in a process of its own, from an .npz file as another
program would leave it. Times are of the processor, all its threads together.
"""

from __future__ import annotations

import argparse
import importlib.util
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from slipmode import rom
from slipmode.runner.report.cases.blade import blade

_SIZES = ((10_000, 10), (30_000, 10), (100_000, 10))  # DOFs, contacts
_STIFFNESS = 1e7  # of an elastic contact [N/m]
_LAWS = ("rigid", "elastic")
_MIB = 1024.0


def main(arguments: list[str] | None = None) -> None:
    """Print the table; sizes may be given: 1000000:100."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("sizes", nargs="*", help="DOFs:contacts")
    parser.add_argument("--law", choices=_LAWS, action="append")
    parser.add_argument("--superlu", action="store_true", help="as without slipmode[fast]")
    options = parser.parse_args(arguments)
    sizes = [tuple(map(int, size.split(":"))) for size in options.sizes] or _SIZES
    has_pardiso = importlib.util.find_spec("pypardiso") is not None and not options.superlu
    solver = "PARDISO" if has_pardiso else "SuperLU"
    print(
        f"{'DOFs':>9} {'contacts':>9} {'law':>8} {'solver':>9} {'read':>7} {'Structure':>10}"
        f" {'reduce':>8} {'in all':>8} {'memory':>10}"
    )
    with tempfile.TemporaryDirectory() as folder:
        for dofs, contacts in sizes:
            file = Path(folder) / "blade.npz"
            _in_process("make", str(file), str(dofs), str(contacts))
            for law in options.law or _LAWS:
                print(_in_process("reduce", str(file), law, solver), end="", flush=True)


def make(path: str, dofs: str, contacts: str) -> None:
    """Write a blade."""
    matrices = blade(int(dofs), int(contacts))
    arrays = {"contact": matrices["contact"]}
    for name in ("mass", "stiffness"):
        for part in ("data", "indices", "indptr", "shape"):
            arrays[f"{name}_{part}"] = getattr(matrices[name], part)
    np.savez(path, **arrays)


def reduce(path: str, law: str, solver: str) -> None:
    """Read and reduce it, and print a line."""
    if solver == "SuperLU":
        sys.modules["pypardiso"] = None  # type: ignore[assignment]
    from slipmode.rom.structure.files import read_matrices

    times = [time.process_time()]
    matrices = read_matrices(Path(path))
    times.append(time.process_time())
    structure = rom.Structure(**matrices, damping=1e-7)
    del matrices
    times.append(time.process_time())
    contacts = rom.Jenkins(1.0, _STIFFNESS) if law == "elastic" else None
    reduced = rom.reduce(structure, law=contacts, progress=sys.stderr.isatty())
    times.append(time.process_time())
    read, checked, spent = np.diff(times)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _MIB**2
    frequency = ", ".join(f"{omega / (2 * np.pi):.2f}" for omega in reduced.frequency)
    print(
        f"{structure.n_dofs:9} {structure.n_contacts:9} {law:>8} {solver:>9} {read:6.1f}s "
        f"{checked:9.1f}s {spent:7.1f}s {times[-1] - times[0]:7.1f}s {memory:6.2f} GiB  "
        f"{frequency} Hz, {reduced.nonresonant_frequency.size} nonresonant modes"
    )


def _in_process(*arguments: str) -> str:
    command = [sys.executable, "-m", "slipmode.runner.report.methods.scale", *arguments]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout


if __name__ == "__main__":
    if sys.argv[1:2] in (["make"], ["reduce"]):
        {"make": make, "reduce": reduce}[sys.argv[1]](*sys.argv[2:])
    else:
        main()
