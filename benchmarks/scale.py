"""How time and memory of a reduction grow with the structure: make bench-scale.

Each size is read, checked and reduced in a process of its own, from an .npz file as another
program would write it. Times are of the processor, all threads together.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.blade import blade
from slipmode import rom

_SIZES = ((10_000, 10), (30_000, 10), (100_000, 10), (300_000, 30), (1_000_000, 100))
_STIFFNESS = 1e7  # of an elastic contact [N/m]


class Spent(NamedTuple):
    """Processor times [s] of reading, checking and reducing, memory [GiB], frequencies [Hz]."""

    n_dofs: int
    n_contacts: int
    times: list[float]
    memory: float
    frequency: list[float]


def main(arguments: list[str]) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", help="DOFs:contacts")
    parser.add_argument("--superlu", action="store_true", help="as without slipmode[fast]")
    parser.add_argument("--picture", type=Path, help="of the growth, a .png")
    options = parser.parse_args(arguments)
    sizes = [tuple(map(int, size.split(":"))) for size in options.sizes] or _SIZES
    has_pardiso = importlib.util.find_spec("pypardiso") is not None and not options.superlu
    solver = "PARDISO" if has_pardiso else "SuperLU"
    print(f"elastic contacts, {solver}")
    heads = ("DOFs", "contacts", "read", "Structure", "reduce", "in all", "memory")
    print("".join(f"{head:>11}" for head in heads))
    found = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "blade.npz"
        for dofs, contacts in sizes:
            _in_process("make", str(file), str(dofs), str(contacts))
            each = Spent(*json.loads(_in_process("reduce", str(file), solver)))
            print(
                f"{each.n_dofs:11}{each.n_contacts:11}",
                *(f"{seconds:10.1f}s" for seconds in (*each.times, sum(each.times))),
                f"{each.memory:7.2f} GiB  {', '.join(f'{f:.2f}' for f in each.frequency)} Hz",
                sep="",
                flush=True,
            )
            found.append(each)
    if options.picture is not None:
        _draw(found, options.picture)


def make(path: str, dofs: str, contacts: str) -> None:
    """Write a blade."""
    matrices = blade(int(dofs), int(contacts))
    arrays = {"contact": matrices["contact"]}
    for name in ("mass", "stiffness"):
        for part in ("data", "indices", "indptr", "shape"):
            arrays[f"{name}_{part}"] = getattr(matrices[name], part)
    np.savez(path, **arrays)


def reduce(path: str, solver: str) -> None:
    """Read and reduce a blade, and print what that took."""
    if solver == "SuperLU":
        sys.modules["pypardiso"] = None  # type: ignore[assignment]
    from slipmode.rom.structure.files import read_matrices

    times = [time.process_time()]
    matrices = read_matrices(Path(path))
    times.append(time.process_time())
    structure = rom.Structure(**matrices, damping=1e-7)
    del matrices
    times.append(time.process_time())
    law = rom.Jenkins(1.0, _STIFFNESS)
    reduced = rom.reduce(structure, law=law, progress=sys.stderr.isatty())
    times.append(time.process_time())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
    hertz = (reduced.frequency / (2 * np.pi)).tolist()
    spent = np.diff(times).tolist()
    print(json.dumps(Spent(structure.n_dofs, structure.n_contacts, spent, memory, hertz)))


def _in_process(*arguments: str) -> str:
    command = [sys.executable, "-m", "benchmarks.scale", *arguments]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout


def _draw(found: Sequence[Spent], path: Path) -> None:
    """Time and memory against DOFs, beside lines of proportional growth."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 2.9), layout="constrained")
    dofs = np.array([each.n_dofs for each in found])
    panels = figure.subplots(1, 2)
    for panel, values, title in (
        (panels[0], np.array([sum(each.times) for each in found]), "processor time [s]"),
        (panels[1], np.array([each.memory for each in found]), "memory [GiB]"),
    ):
        panel.loglog(dofs, values, "o-", color="#c1272d")
        proportional = values[-1] * dofs / dofs[-1]
        panel.loglog(dofs, proportional, ":", color="#777777", label="proportional")
        panel.set(xlabel="DOFs", title=title)
        panel.spines[["top", "right"]].set_visible(False)
    panels[1].legend(loc="lower right", frameon=False)
    figure.savefig(path, dpi=170)


if __name__ == "__main__":
    if sys.argv[1:2] in (["make"], ["reduce"]):
        (make if sys.argv[1] == "make" else reduce)(*sys.argv[2:])
    else:
        main(sys.argv[1:])
