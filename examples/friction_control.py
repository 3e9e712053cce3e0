"""A controller of the normal load at a friction contact, stepped beside an FMU of the structure.

A contact that is pressed too hard sticks and dissipates nothing; one that is pressed too lightly
slips and dissipates little. In between friction damps a mode most, at an amplitude a* that is
proportional to the friction limit mu N, so a fixed limit is right for one force only. The
controller sees |A| and lets the limit follow it,

    d(scale)/dt = (|A| / a* - scale) / tau,    scale = mu N / (mu N of the scene),

which keeps the friction at its best whatever the force: the structure responds as a linear one.

    python examples/friction_control.py                 # recordings in logs/
    slipmode replay logs/controlled.mcap
    python examples/friction_control_picture.py         # docs/friction-control.png
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from slipmode import runner
from slipmode.fmu.imported import Imported
from slipmode.runner.fmi.export import export_fmu
from slipmode.runner.recording import channels
from slipmode.runner.recording.record import Header, McapSink, Recorder
from slipmode.runner.view.rerun_sink import RerunSink

SCENE = Path(__file__).with_suffix(".toml")
TIME_CONSTANT = 10.0  # of the actuator [s]
ALLOWED = (0.05, 5.0)  # what it can do to the limit
SLOW = ("A_re", "A_im", "A_abs")
ENERGY = ("input_power", "dissipated_power", "dissipated_energy")


def most_damped(model):
    """The amplitude a* [kg^1/2 m] at which friction damps the mode most: Im Q is least."""
    amplitude = np.linspace(0.01, 1.0, 1000) * model.table.amplitude_range[0]
    friction = model.table(amplitude[:, None])[:, 0]  # Q a
    return amplitude[np.argmin(friction.imag / amplitude)]


class LoadController:
    """Lets the friction limit follow |A| / a*, as fast as its actuator can."""

    def __init__(self, best):
        self.best = best
        self.scale = 1.0

    def do_step(self, amplitude, step):
        """Inputs of the structure for the next step: the limit moves in a straight line.

        Exact for a constant |A|.
        """
        wanted = np.clip(amplitude / self.best, *ALLOWED)
        rate = (wanted - self.scale) * -np.expm1(-step / TIME_CONSTANT) / step
        inputs = {"limit_scale": self.scale, "limit_scale_rate": rate}
        self.scale += rate * step
        return inputs


def step_together(path, schedule, controller):
    """Outputs of the FMU and the scale of its friction limit, at the communication points."""
    with Imported(path) as structure:
        names = structure.input_names
        scripted = [dict(zip(names, row, strict=True)) for row in schedule.inputs(names)]
        outputs, scales = [structure.outputs()], [controller.scale]
        for step, inputs in zip(schedule.durations(), scripted, strict=True):
            now = outputs[-1]
            structure.set_inputs(**inputs | controller.do_step(now["A_abs"], step))
            structure.do_step(now["time"], step)
            outputs.append(structure.outputs())
            scales.append(controller.scale)
    return {name: np.array([row[name] for row in outputs]) for name in outputs[0]}, scales


def record(scene, schedule, outputs, scales, path):
    """The recording of a controlled run, with the scale of the friction limit."""
    header = Header("The same sweeps, friction limit controlled", scene.text)
    energy = channels.energy()  # an FMU states the first fields
    energy = replace(energy, fields=energy.fields[: len(ENERGY)])
    listed = [channels.modes("A"), channels.forcing("A"), energy, channels.control()]
    forcing = schedule.at_points(["force_A", "frequency_A", "phase_A"])
    sinks = [McapSink(path, header, listed), RerunSink(path.with_suffix(".rrd"), header, listed)]
    with Recorder(sinks) as recorder:
        recorder.event(0.0, "info", "the friction limit follows |A|")
        for topic, names in (("/modes", SLOW), ("/energy", ENERGY)):
            recorder.write(topic, schedule.time(), np.column_stack([outputs[n] for n in names]))
        recorder.write("/forcing", schedule.time(), forcing)
        recorder.write("/control", schedule.time(), np.array(scales)[:, None])


def main(folder="logs"):
    """Run the scene with its fixed limit and with the controller; peaks of |A| per sweep."""
    folder = Path(folder)
    folder.mkdir(exist_ok=True)
    scene = runner.load_scene(SCENE)
    plan = runner.make_plan(scene)
    model, _ = plan.model()
    fmu = export_fmu(scene, folder / "friction_control.fmu")
    fixed = runner.run(scene, folder, fmu=fmu).read().channels["/modes"][2][:, -1]
    outputs, scales = step_together(fmu, plan.schedule, LoadController(most_damped(model)))
    record(scene, plan.schedule, outputs, scales, folder / "controlled.mcap")
    sweeps = plan.schedule.time() // 2000
    return [
        [signal[sweeps == sweep].max() for signal in (fixed, outputs["A_abs"])]
        for sweep in range(3)
    ]


if __name__ == "__main__":
    print("peak |A| [kg^1/2 m]   fixed limit   controlled")
    for sweep, peaks in enumerate(main(*sys.argv[1:])):
        print("sweep {}             {:9.3f}    {:9.3f}".format(sweep + 1, *peaks))
