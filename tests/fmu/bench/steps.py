"""Cost of the FMI calls in a C loop, of FMUs as they are shipped. Figures, not a test.

`python tests/fmu/bench/steps.py [SCENE...]` exports the scenes, by default all shipped ones, and
steps them at the scene's step under the last forces of its script: nothing read, amplitudes and
powers, then also every contact.
"""

import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy

from slipmode.fmu.archive.binaries import fmi_headers, folder, host_platform
from slipmode.runner import export_fmu, load_scene, make_plan, shipped_scenes

STEPS = 500  # a round
AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")


def program(where):
    """The C loop."""
    made = where / "steps"
    source = Path(__file__).with_name("steps.c")
    flags = ("-O2", "-std=c99", f"-I{fmi_headers()}")
    subprocess.run(["cc", *flags, str(source), "-ldl", "-o", str(made)], check=True)
    return made


def measure(made, path, step, names, start):
    """Lines of figures of an FMU, some of whose variables are read after each step."""
    unpacked = path.with_suffix("")
    shutil.unpack_archive(path, unpacked, format="zip")
    description = fmpy.read_model_description(path)
    reference = {v.name: str(v.valueReference) for v in description.modelVariables}
    library = next((unpacked / "binaries" / folder(host_platform(), 3)).iterdir())
    (force, *_) = (name for name in start if name.startswith("force_"))
    chosen = [reference[force], *(reference[name] for name in names)]
    chosen += [f"{reference[name]}={value!r}" for name, value in start.items()]
    command = [made, library, f"{unpacked}/resources/", description.guid, STEPS, step, *chosen]
    words = [str(word) for word in command]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    return done.stdout.strip()


def of_scene(name, where):
    """Its FMU, step, last inputs, and what may be read."""
    scene = load_scene(name)
    path = export_fmu(scene, where / f"{name}.fmu")
    schedule = make_plan(scene).schedule
    inputs = list(schedule.scripts)
    last = schedule.at_ends(inputs, slice(schedule.steps - 1, schedule.steps))[0].tolist()
    names = [v.name for v in fmpy.read_model_description(path).modelVariables]
    slow = [n for n in names if n[0] in "AB" or n.endswith(("_power", "_energy"))]
    contacts = [n for n in names if re.fullmatch(r"contact_\d+_[xvf]", n)]
    return path, scene.run.step, dict(zip(inputs, last, strict=True)), slow, contacts


def main(names):
    """Print the figures."""
    print(platform.processor() or platform.machine())
    with tempfile.TemporaryDirectory() as temporary:
        where = Path(temporary)
        made = program(where)
        for name in names or [n for n in shipped_scenes() if not load_scene(n).mistuning]:
            path, step, start, slow, contacts = of_scene(name, where)
            print(f"{name}, step {step:g} s")
            for words, read in (("slow outputs", slow), ("and contacts", slow + contacts)):
                print(f"  {words}: {measure(made, path, step, read, start)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
