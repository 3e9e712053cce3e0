"""Cost of the FMI calls in a C loop, of FMUs as they are shipped.

`python -m benchmarks.fmu.steps [SCENE...]` exports the scenes, by default all shipped ones, and
steps them at the scene's step under the last forces of its script: nothing read, amplitudes and
powers, then also every contact.
"""

import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy

from slipmode.runner import export_fmu, load_scene, make_plan, shipped_scenes

HEADERS = Path(fmpy.__file__).parent / "c-code"
SOURCE = Path(__file__).with_name("steps.c")


def measure(name: str, where: Path) -> None:
    """Print the figures of a scene."""
    scene = load_scene(name)
    path = export_fmu(scene, where / f"{name}.fmu")
    folder = path.with_suffix("")
    shutil.unpack_archive(path, folder, format="zip")
    (library,) = folder.glob("binaries/*/slipmode.*")
    flags = ("-O2", "-std=c99", f"-I{HEADERS}", f"-Wl,-rpath,{library.parent}")
    subprocess.run(
        [os.environ.get("CC", "cc"), *flags, SOURCE, library, "-o", folder / "steps"], check=True
    )

    schedule = make_plan(scene).schedule
    inputs = list(schedule.scripts)
    last = schedule.at_ends(inputs, slice(schedule.steps - 1, schedule.steps))[0].tolist()
    description = fmpy.read_model_description(path)
    reference = {v.name: str(v.valueReference) for v in description.modelVariables}
    given = zip(inputs, last, strict=True)  # a mode without force has no input in the FMU
    start = [f"{reference[n]}={value!r}" for n, value in given if n in reference]
    slow = [n for n in reference if n[0] in "AB" or n.endswith(("_power", "_energy"))]
    contacts = [n for n in reference if re.fullmatch(r"contact_\d+_[xvf]", n)]
    print(f"{name}, step {scene.run.step:g} s")
    for words, read in (("slow outputs", slow), ("and contacts", slow + contacts)):
        chosen = [*(reference[n] for n in read), *start]
        command = [folder / "steps", f"{folder}/resources/", description.guid]
        done = subprocess.run(
            [*map(str, command), str(scene.run.step), *chosen],
            check=True,
            capture_output=True,
            text=True,
        )
        print(f"  {words}: {done.stdout.strip()}", flush=True)


if __name__ == "__main__":
    print(platform.processor() or platform.machine())
    with tempfile.TemporaryDirectory() as temporary:
        for scene in sys.argv[1:] or [n for n in shipped_scenes() if load_scene(n).tabulated]:
            measure(scene, Path(temporary))
