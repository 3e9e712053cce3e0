"""A Model Exchange importer for the tests."""

import ctypes

import numpy as np
from scipy.integrate import solve_ivp

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
