"""Two structures with friction, each an FMU, joined by a spring that the master of both computes.

The first is forced near its resonance; the spring carries part of its vibration to the second,
whose contact is pressed less. The master exchanges amplitudes at communication points: the force
of the spring on each structure follows from both displacements, and between two points it is held,
or moves on a straight line. Either way it is not quite what the displacements would have it be:
the spring takes or gives energy that nobody has. That energy, which the master can sum up as it
goes, tells its error.

    python examples/coupled_structures.py
"""

import tempfile
from contextlib import ExitStack
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave

from slipmode import fmu, rom

FREQUENCY = 0.985  # of the force and of both carriers [rad/s]
FORCE = 0.15  # on the first structure [N]
SPRING = 0.02  # between the first DOFs of both [N/m]
LIMITS = (2.0, 0.5)  # of friction: mu N [N]
DURATION = 400.0  # [s]
STEPS = (8.0, 4.0, 2.0, 1.0, 0.5)  # of the master [s]
FINEST = 0.05  # of the reference


def export(folder):
    """The FMUs of both structures, and the displacement of DOF 0 per amplitude."""
    reduced = rom.reduce(rom.two_mass(beta=0.01), modes=(0,), carrier=(FREQUENCY,))
    paths = []
    for number, limit in enumerate(LIMITS):
        model = rom.tabulate(reduced, rom.Tanh(limit, alpha=0.02), amplitude=(4.0,))
        paths.append(fmu.export(model, folder / f"structure {number}.fmu", ({0: 1.0},)))
    return paths, 2.0 * reduced.mode_shapes[0, 0]


class Structure:
    """An instance, with complex amplitudes: x = Re(displacement exp(i theta)), so forces too."""

    def __init__(self, path, shape, stack):
        description = fmpy.read_model_description(path)
        self._reference = {v.name: v.valueReference for v in description.modelVariables}
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        self._fmu = FMU3Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(path, folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=Path(path).stem,
        )
        self._fmu.instantiate()
        stack.callback(self._fmu.freeInstance)
        self._shape = shape
        self._set(frequency_A=FREQUENCY)
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()

    def _set(self, **values):
        self._fmu.setFloat64([self._reference[name] for name in values], list(values.values()))

    def _get(self, *names):
        return self._fmu.getFloat64([self._reference[name] for name in names])

    def displacement(self):
        """Of DOF 0, and its rate: as complex amplitudes."""
        re, im, d_re, d_im = self._get("A_re", "A_im", "der(A_re)", "der(A_im)")
        return self._shape * complex(re, im), self._shape * complex(d_re, d_im)

    def push(self, force, rate):
        """A force that moves on from its present value in modulus and phase."""
        size = max(abs(force), 1e-12)
        turning = (rate * force.conjugate()) / size
        self._set(
            force_A=abs(force),
            phase_A=float(np.angle(force)),
            force_rate_A=turning.real,
            phase_rate_A=turning.imag / size,
        )

    def step(self, time, step):
        """Through a communication step."""
        self._fmu.doStep(time, step)


def power(force, displacement, rate):
    """Mean power of a force at its DOF [W]."""
    return 0.5 * (force * (1j * FREQUENCY * displacement + rate).conjugate()).real


def couple(paths, shape, step, *, extrapolate):
    """Displacement amplitudes (points, 2), and what the spring took that it does not hold.

    That energy [J], and what went through the spring [J].
    """
    with ExitStack() as stack:
        both = [Structure(path, shape, stack) for path in paths]
        rows, taken, through, held = [], 0.0, 0.0, 0.0
        for k in range(round(DURATION / step)):
            now, rates = zip(*(one.displacement() for one in both), strict=True)
            rows.append(now)
            spring = SPRING * (now[1] - now[0])
            moving = SPRING * (rates[1] - rates[0]) if extrapolate else 0.0
            both[0].push(FORCE + spring, moving)
            both[1].push(-spring, -moving)
            powers = []
            for end in (False, True):
                if end:
                    for one in both:
                        one.step(k * step, step)
                force = spring + moving * step * end
                moved = [one.displacement() for one in both]
                powers.append(
                    [power(sign * force, *of) for sign, of in zip((1, -1), moved, strict=True)]
                )
            first, second = step * np.mean(powers, axis=0)
            taken -= first + second
            through += abs(second)
        now = [one.displacement()[0] for one in both]
        held = 0.25 * SPRING * abs(now[1] - now[0]) ** 2
        return np.array([*rows, now]), taken - held, through


def main():
    """Rows: step, then error of the displacements and lost energy, held and extrapolated."""
    with tempfile.TemporaryDirectory() as folder:
        paths, shape = export(Path(folder))
        finest, *_ = couple(paths, shape, FINEST, extrapolate=True)
        table = []
        for step in STEPS:
            row = [step]
            for extrapolate in (False, True):
                found, lost, through = couple(paths, shape, step, extrapolate=extrapolate)
                expected = finest[:: round(step / FINEST)]
                row += [np.abs(found - expected).max() / np.abs(finest).max(), lost / through]
            table.append(row)
        return table


if __name__ == "__main__":
    print("            force held               on straight lines")
    print("step [s]    error     energy lost    error     energy lost")
    for row in main():
        print("{:8.2f}    {:.1e}   {:+.1e}       {:.1e}   {:+.1e}".format(*row))
