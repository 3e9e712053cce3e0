"""`python ecos.py FMU STEPS NAME...`: values after steps of 1 s in ecos, in hexadecimal."""

import sys
from contextlib import suppress
from ctypes import CDLL, RTLD_GLOBAL
from pathlib import Path

# ecos needs oneTBB, which the package `tbb` brings but puts where no linker looks.
with suppress(OSError):
    CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=RTLD_GLOBAL)

from ecospy import EcosSimulation, EcosSimulationStructure

path, steps, *names = sys.argv[1:]
with EcosSimulationStructure() as structure:
    structure.add_model("ours", path)
    with EcosSimulation(1.0, structure=structure) as simulation:
        assert simulation.init()
        simulation.step(int(steps))
        values = [simulation.get_real(f"ours::{name}") for name in names]
        simulation.terminate()
print(*(value.hex() for value in values))
