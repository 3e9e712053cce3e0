"""Importers for the tests: Model Exchange, and scenes by both interfaces."""

import ctypes
from itertools import pairwise

import fmpy
import numpy as np
from fmu_fixtures import instance, unpacked
from scipy.integrate import solve_ivp

from slipmode.runner import make_plan

AMPLITUDES = ("A_re", "A_im", "B_re", "B_im")
STATES = (*AMPLITUDES, "theta_A", "theta_B", "dissipated_energy")


def _pointer(values):
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), values.size


class Master:
    """Its own integrator, and events where it is told; states in the order of STATES."""

    def __init__(self, made, size=7):
        self.made, self.fmu, self.size = made, made.fmu, size
        self.time = 0.0

    def update(self):
        """The event iteration; whether it changed states."""
        call = self.fmu.newDiscreteStates if self.made.fmi == 2 else self.fmu.updateDiscreteStates
        again, terminate, nominals, changed, timed, _ = call()
        assert not (again or terminate or nominals or timed)
        return bool(changed)

    def start(self, **values):
        self.made.start(**values)
        assert not self.update()
        self.fmu.enterContinuousTimeMode()
        return self

    def event(self, **inputs):
        """An event at which inputs are set; whether it changed states."""
        self.fmu.enterEventMode()
        self.made.set(**inputs)
        changed = self.update()
        self.fmu.enterContinuousTimeMode()
        return changed

    def states(self):
        found = np.empty(self.size)
        self.fmu.getContinuousStates(*_pointer(found))
        return found

    def put(self, time, states):
        self.fmu.setTime(time)
        self.fmu.setContinuousStates(*_pointer(np.ascontiguousarray(states)))

    def _rates(self, time, states):
        self.put(time, states)
        found = np.empty(self.size)
        call = {2: "getDerivatives", 3: "getContinuousStateDerivatives"}[self.made.fmi]
        getattr(self.fmu, call)(*_pointer(found))
        return found

    def integrate(self, points, step=None):
        """States at points, of which the first is now.

        Without `step` by adaptive steps, else by fourth-order steps of at most `step`.
        """
        states = self.states()
        if step is None:
            scale = 1e-10 * np.maximum(np.abs(states), 0.1)
            options = {"t_eval": points, "rtol": 1e-10, "atol": scale}
            rows = solve_ivp(self._rates, (points[0], points[-1]), states, "DOP853", **options).y.T
        else:
            rows = [states]
            for start, end in pairwise(points):
                count = int(np.ceil((end - start) / step - 1e-6))
                h = (end - start) / count
                for k in range(count):
                    states = _runge_kutta(self._rates, start + k * h, states, h)
                rows.append(states)
            rows = np.array(rows)
        self.time = points[-1]
        self.put(self.time, rows[-1])
        return rows

    def integrate_to(self, end):
        self.integrate(np.array([self.time, end]))


def _runge_kutta(rates, t, y, h):
    k1 = rates(t, y)
    k2 = rates(t + 0.5 * h, y + 0.5 * h * k1)
    k3 = rates(t + 0.5 * h, y + 0.5 * h * k2)
    k4 = rates(t + h, y + h * k3)
    return y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


class SceneFmu:
    """An exported scene, unpacked, and the scene's script for its inputs."""

    def __init__(self, path, scene, fmi=3):
        self.fmi, self.folder = fmi, unpacked(path, path.with_suffix(""))
        self.step = float(fmpy.read_model_description(path).defaultExperiment.stepSize)
        self.plan = make_plan(scene)
        self.inputs = self.plan.schedule.scripted
        self.names = (*self.plan.excited.start(), "dissipated_energy")

    def _rows(self, schedule):
        values = schedule.inputs(self.inputs)
        return schedule.time(), [dict(zip(self.inputs, row, strict=True)) for row in values]

    def co_simulated(self):
        """Time and `names` at the communication points of the scene."""
        time, given = self._rows(self.plan.schedule)
        with instance(self.folder, self.fmi) as made:
            made.start(**given[0], **self.plan.excited.start())
            rows = [made.get(*self.names)]
            for start, end, values in zip(time, time[1:], given, strict=False):
                made.set(**values)
                made.step(start, end - start)
                rows.append(made.get(*self.names))
        return time, np.array(rows)

    def exchanged(self, step=None):
        """Likewise by Model Exchange, events where scripts bend or jump."""
        points = self.plan.schedule.time()
        breaks, given = self._rows(self.plan.schedule.stretches())
        modes = len(self.names) // 2
        with instance(self.folder, self.fmi, exchange=True) as made:
            master = Master(made, 3 * modes + 1)
            master.start(**given[0], **self.plan.excited.start())
            rows = []
            for k, (start, end) in enumerate(pairwise(breaks)):
                if k:
                    master.event(**given[k])
                inside = points[(points >= start) & (points <= end)]
                rows += [*master.integrate(inside, step)[k > 0 :]]  # at an event, before it
        return points, np.array(rows)[:, [*range(2 * modes), 3 * modes]]
