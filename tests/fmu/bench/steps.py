"""Cost of the FMI calls in a C loop: `python tests/fmu/bench/steps.py`. Figures, not a test."""

import platform
import shutil
import subprocess
import tempfile
from pathlib import Path

import fmpy

from slipmode import fmu, rom
from slipmode.fmu.archive.binaries import folder, host_platform
from slipmode.fmu.archive.cross_compiler import fmi_headers

STEPS = 500  # a round
START = {"force_A": 0.15, "frequency_A": 0.98, "force_B": 0.25, "frequency_B": 1.65}
AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")
SLOW = (*AMPLITUDES, "A_abs", "B_abs", "input_power", "dissipated_power", "dissipated_energy")


def measure(model, where, contact, names):
    """One line of figures for an FMU with or without contact motion."""
    force_patterns = ({0: 1.0}, {1: 1.0})
    path = fmu.export(model, where / "bench.fmu", force_patterns, contact=contact, start=START)
    shutil.unpack_archive(path, where / "FMU", format="zip")
    description = fmpy.read_model_description(path)
    reference = {v.name: str(v.valueReference) for v in description.modelVariables}
    library = next((where / "FMU" / "binaries" / folder(host_platform(), 3)).iterdir())
    program = where / "steps"
    source = Path(__file__).with_name("steps.c")
    flags = ("-O2", "-std=c99", f"-I{fmi_headers()}")
    subprocess.run(["cc", *flags, str(source), "-ldl", "-o", str(program)], check=True)
    arguments = [library, f"{where}/FMU/resources/", description.guid, STEPS]
    chosen = [reference["force_A"], *(reference[name] for name in names)]
    command = [str(word) for word in (program, *arguments, *chosen)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def main():
    """Print the figures."""
    reduced, law = rom.reduce(rom.two_mass()), rom.Tanh(2.0, 0.02)
    model = rom.tabulate(reduced, law, amplitude=(4.0, 4.0), harmonics=5)
    print(platform.processor() or platform.machine())
    for contact, names in ((False, AMPLITUDES), (False, SLOW), (True, (*SLOW, "contact_0_x"))):
        with tempfile.TemporaryDirectory() as where:
            words = "with" if contact else "without"
            print(f"{words} contact motion: {measure(model, Path(where), contact, names)}")


if __name__ == "__main__":
    main()
