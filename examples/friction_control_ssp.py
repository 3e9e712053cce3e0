"""The structure and the controller of friction_control.py: two FMUs in a system structure package.

The controller is 150 lines of C beside its description, in friction_controller/, compiled here.
The package says what is connected and with which values it starts; what sweeps the forcing is
outside of it. The master below reads the package and steps both FMUs side by side: each sees what
the other was at the last communication point, so the controller is one step late.

    python examples/friction_control_ssp.py                 # logs/friction_control.ssp
"""

import subprocess
import sys
import tempfile
import zipfile
from contextlib import ExitStack
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.ssd import find_components, read_ssd, read_ssv
from friction_control import SCENE, most_damped

from slipmode import runner
from slipmode.fmu.archive.binaries import extension, fmi_headers, folder, host_platform
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.fmi.ssp import Part, write_ssp

CONTROLLER = Path(__file__).with_name("friction_controller")
CONNECTIONS = (
    ("structure.A_abs", "controller.amplitude"),
    ("controller.limit_scale", "structure.limit_scale"),
    ("controller.limit_scale_rate", "structure.limit_scale_rate"),
    *((name, f"structure.{name}") for name in ("force_A", "frequency_A", "frequency_rate_A")),
)


def build_controller(path):
    """The FMU of the controller, for this machine, with its source."""
    source = CONTROLLER / "friction_controller.c"
    machine = host_platform()
    library = path.with_suffix(extension(machine))
    flags = ("-std=c99", "-O2", "-shared", "-fPIC", f"-I{fmi_headers()}")
    subprocess.run(["cc", *flags, source, "-lm", "-o", library], check=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(CONTROLLER / "modelDescription.xml", "modelDescription.xml")
        archive.write(source, f"sources/{source.name}")
        archive.write(library, f"binaries/{folder(machine, 2)}/{source.stem}{library.suffix}")
    return path


def export(package):
    """The package, from the scene; the schedule of its inputs."""
    scene = runner.load_scene(SCENE)
    plan = runner.make_plan(scene)
    model, _ = plan.model()
    with tempfile.TemporaryDirectory() as made:
        structure = export_fmu(scene, Path(made) / f"{scene.name}.fmu", fmi=2)
        controller = build_controller(Path(made) / "controller.fmu")
        best = {"best_amplitude": most_damped(model)}
        beside = [Part("controller", controller, best)]
        write_ssp(structure, scene, package, beside, CONNECTIONS)
    return plan.schedule


class Instance:
    """A component of the system, with the start values that are bound to it."""

    def __init__(self, component, unpacked, stack):
        path = str(unpacked / component.source)
        description = fmpy.read_model_description(path)
        self.variables = {v.name: v for v in description.modelVariables}
        self.outputs = [c.name for c in component.connectors if c.kind == "output"]
        made = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(path, stack.enter_context(tempfile.TemporaryDirectory())),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=component.name,
        )
        made.instantiate()
        stack.callback(made.freeInstance)
        made.setupExperiment(startTime=0.0)
        self._fmu = made
        for binding in component.parameterBindings:
            for parameter in read_ssv(str(unpacked / binding.source)).parameters:
                if self.variables[parameter.name].type == "Real":
                    self.set({parameter.name: float(parameter.value)})
        made.enterInitializationMode()
        made.exitInitializationMode()

    def set(self, values):
        """Of real variables by name."""
        references = [self.variables[name].valueReference for name in values]
        self._fmu.setReal(references, list(values.values()))

    def get(self):
        """Its real outputs by name."""
        names = [name for name in self.outputs if self.variables[name].type == "Real"]
        references = [self.variables[name].valueReference for name in names]
        return dict(zip(names, self._fmu.getReal(references), strict=True))

    def do_step(self, time, step):
        """On to the next communication point."""
        self._fmu.doStep(currentCommunicationPoint=time, communicationStepSize=step)


def simulate(package, schedule):
    """|A| and the scale of the friction limit at the communication points."""
    with ExitStack() as stack:
        unpacked = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        with zipfile.ZipFile(package) as archive:
            archive.extractall(unpacked)
        system = read_ssd(str(package), validate=True).system
        parts = {c.name: Instance(c, unpacked, stack) for c in find_components(system)}
        inputs = [c.name for c in system.connectors if c.kind == "input"]
        time, rows = 0.0, []
        for step, row in zip(schedule.durations(), schedule.inputs(inputs), strict=True):
            now = {name: part.get() for name, part in parts.items()}
            now[None] = dict(zip(inputs, row.tolist(), strict=True))
            rows.append((now["structure"]["A_abs"], now["controller"]["limit_scale"]))
            for link in system.connections:
                if link.endElement is not None and link.startConnector in now[link.startElement]:
                    value = now[link.startElement][link.startConnector]
                    parts[link.endElement].set({link.endConnector: value})
            for part in parts.values():
                part.do_step(time, step)
            time += step
    return np.array(rows)


def main(output="logs/friction_control.ssp"):
    """Peaks of |A| per sweep, both FMUs stepped as the package has them connected."""
    package = Path(output)
    package.parent.mkdir(exist_ok=True)
    schedule = export(package)
    amplitude, _ = simulate(package, schedule).T
    return amplitude.reshape(3, 2000).max(axis=1)


if __name__ == "__main__":
    print("peak |A| [kg^1/2 m]   controlled")
    for sweep, peak in enumerate(main(*sys.argv[1:])):
        print(f"sweep {sweep + 1}              {peak:9.3f}")
