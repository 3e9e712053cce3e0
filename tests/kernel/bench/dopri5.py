"""Cost of a step of the slow flow: `python tests/kernel/bench/dopri5.py`. No test."""

import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
CORE = HERE.parents[2] / "rom" / "kernel"
FLAGS = (
    *("-O3", "-std=c99", "-fopenmp-simd", "-DSM_OPENMP_SIMD", "-DSM_CLONES"),  # as CMakeLists.txt
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-fno-tree-slp-vectorize"),
)


def main():
    """Build the program with the core, and run it."""
    drivers = [HERE.parent / room for room in ("driver", "slow")]
    own = [HERE / "dopri5.c", drivers[0] / "fixtures.c"]
    sources = [*own, *sorted(CORE.rglob("*.c"))]
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "dopri5"
        command = [
            "cc",
            *FLAGS,
            *(f"-I{folder}" for folder in (CORE, *drivers)),
            *map(str, sources),
            "-lm",
            "-o",
            str(program),
        ]
        subprocess.run(command, check=True)
        subprocess.run([program], check=True)


if __name__ == "__main__":
    main()
