"""General-purpose integrators on y' = f(t, y), y = (x, x'), with analytic Jacobians."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
from scipy.integrate import odeint

from benchmarks.cases import Case
from benchmarks.peers.library import library
from slipmode import rom
from slipmode.rom import kernel
from slipmode.rom.arrays import Floats
from slipmode.rom.laws.friction import limits
from slipmode.rom.structure.matrices import as_dense

_MOST_STEPS = 1_000_000
HAS_CVODE = find_spec("sksundae") is not None


class _Record(ctypes.Structure):
    """peer_first_order."""

    _fields_ = (
        *((name, ctypes.c_int32) for name in ("dofs", "contacts", "modes")),
        *(
            (name, ctypes.c_void_p)
            for name in ("linear", "slip", "friction", "pattern", "frequency")
        ),
    )


class FirstOrder:
    """The equations of motion of a case with tanh friction, compiled: first_order.c.

    `calls` counts evaluations of the right-hand side.
    """

    def __init__(self, case: Case) -> None:
        assert isinstance(case.law, rom.Tanh)
        s, n = case.structure, case.structure.n_dofs
        inverse = np.linalg.inv(as_dense(s.mass))
        W = as_dense(s.directions)
        arrays = {
            "linear": -inverse @ np.hstack((as_dense(s.stiffness), as_dense(s.damping))),
            "slip": W.T / case.law.alpha,
            "friction": inverse @ (W * limits(case.law, W.shape[1])),
            "pattern": case.excitation.patterns @ inverse,
            "frequency": np.array(case.frequency),
        }
        self._arrays = {name: kernel.contiguous(array) for name, array in arrays.items()}
        self._record = _Record(
            *(n, W.shape[1], len(case.frequency)),
            **{name: array.ctypes.data for name, array in self._arrays.items()},
        )
        self._address = ctypes.addressof(self._record)
        self._rate = library().peer_first_order_rate
        self._jacobian = library().peer_first_order_jacobian
        self.size = 2 * n
        self.calls = 0

    def rate_into(self, t: float, y: Floats, f: Floats) -> None:
        """Write f(t, y) into a contiguous array."""
        self.calls += 1
        self._rate(self._address, t, y.ctypes.data, f.ctypes.data)

    def jacobian_into(self, y: Floats, J: Floats) -> None:
        """Write df/dy into a contiguous array (size, size)."""
        self._jacobian(self._address, y.ctypes.data, J.ctypes.data)

    def rate(self, t: float, y: Floats) -> Floats:
        """Return f(t, y)."""
        f = np.empty(self.size)
        self.rate_into(t, y, f)
        return f

    def jacobian(self, _: float, y: Floats) -> Floats:
        """Return df/dy (size, size)."""
        J = np.empty((self.size, self.size))
        self.jacobian_into(y, J)
        return J


Integrate = Callable[[FirstOrder, Floats, float], Floats]


def lsoda(problem: FirstOrder, times: Floats, tolerance: float) -> Floats:
    """Return states (samples, size) by LSODA through odeint, whose time loop is compiled."""
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


def cvode(problem: FirstOrder, times: Floats, tolerance: float) -> Floats:
    """Return states (samples, size) by SUNDIALS' CVODE, BDF, through scikit-sundae."""
    from sksundae.cvode import CVODE

    def jacobian(_t: float, y: Floats, _f: Floats, J: Floats) -> None:
        problem.jacobian_into(y, J)

    solver = CVODE(
        problem.rate_into,
        jacfn=jacobian,
        rtol=tolerance,
        atol=0.1 * tolerance,
        max_num_steps=_MOST_STEPS,
    )
    return np.asarray(solver.solve(np.append(0.0, times), np.zeros(problem.size)).y[1:])
