"""Importers for the tests: Model Exchange, and scenes by both interfaces."""

import ctypes
import shutil
from itertools import pairwise

import fmpy
import numpy as np
from fmu_fixtures import instance
from scipy.integrate import solve_ivp

from slipmode.fmu.inputs import rate_of
from slipmode.runner import make_plan

STATES = ("A_re", "A_im", "B_re", "B_im", "theta_A", "theta_B", "dissipated_energy")

_DOUBLES = ctypes.POINTER(ctypes.c_double)


class Master:
    """Its own integrator, and events where it is told."""

    def __init__(self, made):
        self.made, self.fmu = made, made.fmu
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
        return self.made.get(*STATES)

    def put(self, time, states):
        states = np.ascontiguousarray(states)
        self.fmu.setTime(time)
        self.fmu.setContinuousStates(states.ctypes.data_as(_DOUBLES), states.size)

    def integrate_to(self, end):
        rates = np.empty(len(STATES))
        call = {2: "getDerivatives", 3: "getContinuousStateDerivatives"}[self.made.fmi]
        get = getattr(self.fmu, call)

        def derivative(time, states):
            self.put(time, states)
            get(rates.ctypes.data_as(_DOUBLES), rates.size)
            return rates.copy()

        span = (self.time, end)
        solved = solve_ivp(derivative, span, self.states(), "DOP853", rtol=1e-10, atol=1e-11)
        self.put(end, solved.y[:, -1])
        self.time = end


class SceneFmu:
    """An exported scene, unpacked, and the scene's script for its inputs."""

    def __init__(self, path, scene, fmi=3):
        self.fmi, self.folder = fmi, path.with_suffix("")
        shutil.unpack_archive(path, self.folder, format="zip")
        self.step = float(fmpy.read_model_description(path).defaultExperiment.stepSize)
        self.plan = make_plan(scene)
        scripts = tuple(self.plan.schedule.scripts)
        self.inputs = (*scripts, *map(rate_of, scripts))
        modes = self.plan.excited.modes
        self.names = (*self.plan.excited.start(), "dissipated_energy")
        self.states = (*self.names[:-1], *(f"theta_{m}" for m in modes), self.names[-1])

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

    def exchanged(self, integrate):
        """Likewise by Model Exchange, events where scripts bend or jump.

        `integrate(derivative, points, states)` has the states (points, states) at points.
        """
        points = self.plan.schedule.time()
        breaks, given = self._rows(self.plan.schedule.stretches())
        get = {2: "getDerivatives", 3: "getContinuousStateDerivatives"}[self.fmi]
        update = {2: "newDiscreteStates", 3: "updateDiscreteStates"}[self.fmi]
        with instance(self.folder, self.fmi, exchange=True) as made:
            rates = np.empty(len(self.states))

            def put(time, states):
                states = np.ascontiguousarray(states)
                made.fmu.setTime(time)
                made.fmu.setContinuousStates(states.ctypes.data_as(_DOUBLES), states.size)

            def derivative(time, states):
                put(time, states)
                getattr(made.fmu, get)(rates.ctypes.data_as(_DOUBLES), rates.size)
                return rates.copy()

            made.start(**given[0], **self.plan.excited.start())
            rows = []
            for k, (start, end) in enumerate(pairwise(breaks)):
                if k:
                    made.fmu.enterEventMode()
                    made.set(**given[k])
                getattr(made.fmu, update)()
                made.fmu.enterContinuousTimeMode()
                states = np.empty(len(self.states))
                made.fmu.getContinuousStates(states.ctypes.data_as(_DOUBLES), states.size)
                inside = points[(points >= start) & (points <= end)]
                through = integrate(derivative, inside, states)
                put(end, through[-1])
                rows += [*through[k > 0 :]]  # at an event, before it
        columns = [self.states.index(name) for name in self.names]
        return points, np.array(rows)[:, columns]

    def adaptive(self, derivative, points, states):
        """By an integrator that chooses its steps."""
        scale = np.maximum(np.abs(states), 1e-6)
        solved = solve_ivp(
            derivative, points[[0, -1]], states, "DOP853", points, rtol=1e-9, atol=1e-10 * scale
        )
        return solved.y.T

    def fixed(self, derivative, points, states):
        """By Runge and Kutta's, in steps no longer than the declared one."""
        rows = [states]
        for start, end in pairwise(points):
            count = int(np.ceil((end - start) / self.step - 1e-6))
            h = (end - start) / count
            for k in range(count):
                t, y = start + k * h, states
                k1 = derivative(t, y)
                k2 = derivative(t + 0.5 * h, y + 0.5 * h * k1)
                k3 = derivative(t + 0.5 * h, y + 0.5 * h * k2)
                k4 = derivative(t + h, y + h * k3)
                states = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            rows.append(states)
        return np.array(rows)
