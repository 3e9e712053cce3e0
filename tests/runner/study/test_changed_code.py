"""Results on disk after a change of slipmode's code without a change of its version."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import slipmode

SCRIPT = """
import sys
import numpy as np, scipy.sparse
from slipmode import rom
from slipmode.rom.table import disk_cache
from slipmode.rom.table.cache import cached_model
from slipmode.runner.scene.kept import kept_reduction
from slipmode.runner.study.study_file import load_study

n = 10_000  # so large that reductions are kept
chain = scipy.sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)).tocsc()
structure = rom.Structure(mass=scipy.sparse.eye_array(n).tocsc(), stiffness=chain, contact=[5])
kept_reduction(structure, (0,), "consistent", rom.Jenkins(1.0, 1.0), None)
reduced = rom.reduce(rom.two_mass(), (0,), warned=False)
cached_model(reduced, rom.Coulomb(2.0), (3.0,), 3e-2)
print(len(disk_cache.entries()), load_study(sys.argv[1]).digest)
"""

STUDY = """
scene = "one-mode"
[[vary]]
key = "forcing.A.amplitude"
values = [0.1, 0.15]
[outputs]
steady = true
"""


def test_tables_reductions_and_studies_are_of_the_code_that_computed_them(tmp_path):
    package = tmp_path / "code" / "slipmode"
    for name in ("rom", "fmu", "runner"):
        source = Path(importlib.util.find_spec(f"slipmode.{name}").origin).parent
        shutil.copytree(
            source, package / name, ignore=shutil.ignore_patterns("*.c", "__pycache__")
        )
    kernel = Path(importlib.util.find_spec("slipmode.rom._core").origin)
    shutil.copy(kernel, package / "rom")
    shutil.copy(slipmode.__file__, package)
    (tmp_path / "study.toml").write_text(STUDY)
    libraries = str(Path(np.__file__).parents[1])

    def found():
        """Entries of the cache, and the digest of the study, by the copied code."""
        path = os.pathsep.join((str(package.parent), libraries))
        environment = os.environ | {"PYTHONPATH": path, "SLIPMODE_CACHE": str(tmp_path / "cache")}
        command = [sys.executable, "-S", "-c", SCRIPT, str(tmp_path / "study.toml")]
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr
        entries, digest = done.stdout.split()
        return int(entries), digest

    def change(name):
        with (package / name).open("a") as file:
            file.write("# changed\n")

    entries, first = found()
    assert entries == 2
    change("runner/run.py")  # tables and reductions do not depend on it
    entries, second = found()
    assert entries == 2 and second != first
    change("rom/reduction/reduction.py")
    entries, third = found()
    assert entries == 4 and third not in (first, second)
