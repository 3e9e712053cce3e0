"""How time and memory of a reduction grow with the structure: make bench-scale.

Each size is read, checked and reduced in a process of its own, from an .npz file as another
program would leave it. Times are of the processor, all its threads together.
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

from slipmode import rom
from slipmode.runner.report.cases.blade import blade

_SIZES = ((10_000, 10), (30_000, 10), (100_000, 10), (300_000, 30), (1_000_000, 100))
_STIFFNESS = 1e7  # of an elastic contact [N/m]
_LAWS = ("rigid", "elastic")
_MIB = 1024.0


class Reduced(NamedTuple):
    """A structure read, checked and reduced.

    Attributes
    ----------
    read, checked, reduced : float
        Processor time of each [s].
    memory : float
        At most [GiB].
    frequency : list of float
        Of the retained modes [Hz].
    """

    n_dofs: int
    n_contacts: int
    law: str
    solver: str
    read: float
    checked: float
    reduced: float
    memory: float
    frequency: list[float]

    @property
    def seconds(self) -> float:
        """Of all three."""
        return self.read + self.checked + self.reduced

    def line(self) -> str:
        """Of the table."""
        return (
            f"{self.n_dofs:9} {self.n_contacts:9} {self.law:>8} {self.solver:>9} {self.read:6.1f}s"
            f" {self.checked:9.1f}s {self.reduced:7.1f}s {self.seconds:7.1f}s"
            f" {self.memory:6.2f} GiB  {', '.join(f'{f:.2f}' for f in self.frequency)} Hz"
        )


def main(arguments: list[str] | None = None) -> None:
    """Print the table; sizes may be given: 1000000:100."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("sizes", nargs="*", help="DOFs:contacts")
    parser.add_argument("--law", choices=_LAWS, default="elastic")
    parser.add_argument("--superlu", action="store_true", help="as without slipmode[fast]")
    parser.add_argument("--picture", type=Path, help="of the growth, a .png or .svg")
    options = parser.parse_args(arguments)
    sizes = [tuple(map(int, size.split(":"))) for size in options.sizes] or _SIZES
    has_pardiso = importlib.util.find_spec("pypardiso") is not None and not options.superlu
    solver = "PARDISO" if has_pardiso else "SuperLU"
    print(
        f"{'DOFs':>9} {'contacts':>9} {'law':>8} {'solver':>9} {'read':>7} {'Structure':>10}"
        f" {'reduce':>8} {'in all':>8} {'memory':>10}"
    )
    found = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "blade.npz"
        for dofs, contacts in sizes:
            _in_process("make", str(file), str(dofs), str(contacts))
            spent = _in_process("reduce", str(file), options.law, solver)
            found.append(Reduced(*json.loads(spent)))
            print(found[-1].line(), flush=True)
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


def reduce(path: str, law: str, solver: str) -> None:
    """Read and reduce it, and print what that took."""
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
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _MIB**2
    hertz = (reduced.frequency / (2 * np.pi)).tolist()
    size = structure.n_dofs, structure.n_contacts
    read, checked, spent = np.diff(times).tolist()
    print(json.dumps(Reduced(*size, law, solver, read, checked, spent, memory, hertz)))


def _in_process(*arguments: str) -> str:
    command = [sys.executable, "-m", "slipmode.runner.report.methods.scale", *arguments]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout


def _draw(found: Sequence[Reduced], path: Path) -> None:
    """Time and memory against DOFs, beside lines of proportional growth."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 2.9), layout="constrained")
    dofs = np.array([each.n_dofs for each in found])
    panels = figure.subplots(1, 2)
    for panel, name, title in zip(
        panels, ("seconds", "memory"), ("processor time [s]", "memory [GiB]"), strict=True
    ):
        values = np.array([getattr(each, name) for each in found])
        panel.loglog(dofs, values, "o-", color="#c1272d")
        panel.loglog(
            dofs, values[-1] * dofs / dofs[-1], ":", color="#777777", label="proportional"
        )
        panel.set(xlabel="DOFs", title=title)
        panel.spines[["top", "right"]].set_visible(False)
    panels[1].legend(loc="lower right", frameon=False)
    figure.savefig(path, dpi=170)


if __name__ == "__main__":
    if sys.argv[1:2] in (["make"], ["reduce"]):
        {"make": make, "reduce": reduce}[sys.argv[1]](*sys.argv[2:])
    else:
        main()
