"""Cost of stepping through FMPy, beside an FMU that does next to nothing. Figures, not a test.

`python tests/fmu/bench/through_fmpy.py` exports the two-mode scene and prints microseconds of
processor time per communication step of 1 s: one input set, doStep, four outputs got. Native: our
FMU in a C loop.
"""

import platform
import re
import subprocess
import tempfile
import time
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.simulation import instantiate_fmu
from steps import AMPLITUDES, measure, of_scene, program

from slipmode.fmu.archive.binaries import extension, fmi_headers, folder, host_platform
from slipmode.runner import export_fmu

SCENE = "two-mode"
STEPS, ROUNDS = 500, 150
FORCE = 0.15
SLAVES = {2: FMU2Slave, 3: FMU3Slave}
SOURCE = Path(__file__).with_name("decay.c")


def idle(where, fmi):
    """An instance of the idle FMU, and a variable to set and four to get.

    FMPy wants every function of the standard to be there, so the others are added.
    """
    written = SOURCE.read_text()
    others = [name for name in dir(SLAVES[fmi]) if name.startswith(f"fmi{fmi}")]
    absent = "".join(f"int {n}(void) {{ return 3; }}\n" for n in others if f" {n}(" not in written)
    (where / "absent.c").write_text(absent)
    host = host_platform()
    library = where / "binaries" / folder(host, fmi) / f"decay{extension(host)}"
    library.parent.mkdir(parents=True)
    flags = ("-O2", "-shared", "-fPIC", f"-I{fmi_headers()}")
    subprocess.run(["cc", *flags, SOURCE, where / "absent.c", "-o", library], check=True)
    slave = SLAVES[fmi](guid="", modelIdentifier="decay", unzipDirectory=str(where))
    slave.instantiate()
    return slave, [0, 1, 1, 1, 1]


def ours(where, fmi, start):
    """Likewise of the scene, under its last forces."""
    path = export_fmu(SCENE, where / f"ours{fmi}.fmu", fmi)
    description = fmpy.read_model_description(path)
    slave = instantiate_fmu(fmpy.extract(path, where / str(fmi)), description)
    if fmi == 2:
        slave.setupExperiment()
    slave.enterInitializationMode()
    reference = {v.name: v.valueReference for v in description.modelVariables}
    put = slave.setReal if fmi == 2 else slave.setFloat64
    put([reference[name] for name in start], list(start.values()))
    slave.exitInitializationMode()
    return slave, [reference[name] for name in ("force_A", *AMPLITUDES)]


def microseconds(slave, references, first):
    """Cost of a communication step, over STEPS of them from number `first` on."""
    two = isinstance(slave, FMU2Slave)
    put, get = (slave.setReal, slave.getReal) if two else (slave.setFloat64, slave.getFloat64)
    force, outputs = references[:1], references[1:]
    started = time.thread_time()
    for k in range(first, first + STEPS):
        put(force, [FORCE])
        slave.doStep(float(k), 1.0)
        get(outputs)
    return (time.thread_time() - started) / STEPS * 1e6


def main():
    """Print the figures: the least of several rounds, ours and the idle FMU in turn."""
    print(platform.processor() or platform.machine())
    with tempfile.TemporaryDirectory() as temporary:
        where = Path(temporary)
        path, step, start, *_ = of_scene(SCENE, where)
        line = measure(program(where), path, step, AMPLITUDES, start)
        native = float(re.search(r"all three (\d+) ns", line)[1]) * 1e-3
        for fmi in SLAVES:
            pair = (ours(where, fmi, start), idle(where, fmi))
            rounds = [
                [microseconds(*stepped, number * STEPS) for stepped in pair]
                for number in range(ROUNDS)
            ]
            cost, least = (min(column) for column in zip(*rounds, strict=True))
            print(
                f"FMI {fmi}: ours {cost:.2f}, idle {least:.2f}, native {native:.2f} us: "
                f"{cost / (least + native):.2f} x (idle + native)"
            )


if __name__ == "__main__":
    main()
