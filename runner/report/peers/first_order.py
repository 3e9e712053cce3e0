"""General-purpose integrators on y' = f(t, y), y = (x, x'), with analytic Jacobians."""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np
from scipy.integrate import odeint, solve_ivp

from slipmode import rom
from slipmode.rom.arrays import Floats
from slipmode.rom.laws.friction import limits
from slipmode.rom.structure.matrices import as_dense
from slipmode.runner.report.cases.cases import Case

_MOST_STEPS = 1_000_000
HAS_CVODE = find_spec("sksundae") is not None


class FirstOrder:
    """Equations of motion of a case with tanh friction, in numpy: two products, one tanh.

    Parameters
    ----------
    case : Case

    Attributes
    ----------
    calls : int
        Evaluations of the right-hand side.
    """

    def __init__(self, case: Case) -> None:
        assert isinstance(case.law, rom.Tanh)
        s, n = case.structure, case.structure.n_dofs
        inverse = np.linalg.inv(as_dense(s.mass))
        W = as_dense(s.directions)
        self._linear = np.block(
            [
                [np.zeros((n, n)), np.eye(n)],
                [-inverse @ as_dense(s.stiffness), -inverse @ as_dense(s.damping)],
            ]
        )
        nothing = np.zeros((W.shape[1], n))
        self._slip = np.hstack([nothing, W.T]) / case.law.alpha
        self._friction = np.vstack([nothing.T, -inverse @ (W * limits(case.law, W.shape[1]))])
        patterns = np.hstack(
            [np.zeros_like(case.excitation.patterns), case.excitation.patterns @ inverse]
        )
        self._excitation_of = [
            (int(dof), float(row[dof]), frequency)
            for row, frequency in zip(patterns, case.frequency, strict=True)
            for dof in np.flatnonzero(row)
        ]
        self.size = 2 * n
        self.calls = 0

    def rate(self, t: float, y: Floats) -> Floats:
        """f(t, y)."""
        self.calls += 1
        f: Floats = self._linear @ y + self._friction @ np.tanh(self._slip @ y)
        for dof, force, frequency in self._excitation_of:
            f[dof] += force * math.cos(frequency * t)
        return f

    def jacobian(self, _: float, y: Floats) -> Floats:
        """df/dy."""
        slope = 1.0 - np.tanh(self._slip @ y) ** 2
        return np.asarray(self._linear + (self._friction * slope) @ self._slip)


Integrate = Callable[[FirstOrder, Floats, float], Floats]


def lsoda(problem: FirstOrder, times: Floats, tolerance: float) -> Floats:
    """LSODA through odeint, whose time loop is compiled; states (samples, size)."""
    states = odeint(
        problem.rate,
        np.zeros(problem.size),
        np.append(0.0, times),
        Dfun=problem.jacobian,
        tfirst=True,
        rtol=tolerance,
        atol=0.1 * tolerance,
        mxstep=_MOST_STEPS,
    )
    return np.asarray(states[1:])


def _scipy(method: Literal["Radau", "BDF"]) -> Integrate:
    def integrate(problem: FirstOrder, times: Floats, tolerance: float) -> Floats:
        solution: Any = solve_ivp(
            problem.rate,
            (0.0, float(times[-1])),
            np.zeros(problem.size),
            method=method,
            t_eval=times,
            jac=problem.jacobian,
            rtol=tolerance,
            atol=0.1 * tolerance,
        )
        return np.asarray(solution.y.T)

    return integrate


radau, bdf = _scipy("Radau"), _scipy("BDF")


def cvode(problem: FirstOrder, times: Floats, tolerance: float) -> Floats:
    """SUNDIALS' CVODE, BDF, through scikit-sundae; states (samples, size)."""
    from sksundae.cvode import CVODE

    def rate(t: float, y: Floats, f: Floats) -> None:
        f[:] = problem.rate(t, y)

    def jacobian(t: float, y: Floats, f: Floats, J: Floats) -> None:
        J[:] = problem.jacobian(t, y)

    solver = CVODE(
        rate, jacfn=jacobian, rtol=tolerance, atol=0.1 * tolerance, max_num_steps=_MOST_STEPS
    )
    return np.asarray(solver.solve(np.append(0.0, times), np.zeros(problem.size)).y[1:])
