"""Communication steps from tiny to huge, and runs of ten million cycles."""

from __future__ import annotations

import math
import tracemalloc
from decimal import Decimal, getcontext
from functools import cache, partial

import numpy as np

from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.arrays import Floats
from slipmode.runner.report.cases.cases import two_mode
from slipmode.runner.report.hard.hard_case import FLOW, HardCase

_PHASE = 1e-6  # [rad], over 1e7 cycles
_CYCLES, _CYCLES_PER_STEP, _STEPS_PER_BATCH = 10_000_000, 10, 10_000
# Bytes by which a long run may grow. The least that can leak in each step is a pointer, 8 bytes;
# what the interpreter allocates once and for all, some 1e4, is no leak. In between: 0.1 a step.
_MEMORY = 0.1 * _CYCLES / _CYCLES_PER_STEP
_OMEGA = 0.98
_PERIOD = 2 * math.pi / _OMEGA
_PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")
_START = 1.5 - 0.7j  # far from steady, so that the amplitude moves


def _component() -> Component:
    reduced = rom.reduce(rom.two_mass(), modes=(0,))
    component = Component(
        rom.tabulate(reduced, two_mode().law, (5.0,), 1e-2), ({0: 1.0},), tolerance=FLOW
    )
    component.set_inputs(force_A=0.15, frequency_A=_OMEGA)
    component.reset(amplitude=_START)
    return component


def _after(periods: float, step: float) -> complex:
    """Amplitude after so many periods in equal steps, both in periods."""
    component = _component()
    count = round(periods / step)
    _run(component, np.full(count, step * _PERIOD))
    outputs = component.outputs()
    return complex(outputs["A_re"], outputs["A_im"])


def _run(component: Component, durations: Floats) -> None:
    given = {"force_A": 0.15, "frequency_A": _OMEGA}
    row = [given.get(name, 0.0) for name in component.input_names]
    component.run(durations, np.tile(row, (durations.size, 1)))


def _step_error(periods: float, step: float, other: float) -> float:
    """Difference between two communication steps, relative to the amplitude."""
    one, two = _after(periods, step), _after(periods, other)
    return abs(one - two) / abs(two)


@cache
def _ten_million_cycles() -> tuple[float, float]:
    """Phase error [rad] and growth of memory after the first batch [bytes]."""
    getcontext().prec = 50
    component = _component()
    step = _CYCLES_PER_STEP * _PERIOD
    durations = np.full(_STEPS_PER_BATCH, step)
    batches = _CYCLES // (_CYCLES_PER_STEP * _STEPS_PER_BATCH)
    tracemalloc.start()
    _run(component, durations)
    _, first = tracemalloc.get_traced_memory()
    tracemalloc.reset_peak()
    for _ in range(batches - 1):
        _run(component, durations)
    _, later = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # from the very doubles that the component was given, so that only its own rounding counts
    turned = Decimal(_OMEGA) * Decimal(step) * (_STEPS_PER_BATCH * batches)
    difference = component.outputs()["theta_A"] - float(turned % (2 * _PI))
    return abs(math.remainder(difference, 2 * math.pi)), float(later - first)


def _phase_error() -> float:
    return _ten_million_cycles()[0]


def _memory_growth() -> float:
    return _ten_million_cycles()[1]


def stepping_cases() -> list[HardCase]:
    """What must not depend on the communication step, and what must not drift."""
    steps = {
        "1e-6 periods": (1e-2, 1e-6, 1e-2),
        "1e-3 periods": (1.0, 1e-3, 1.0),
        "1 period": (100.0, 1.0, 100.0),
        "1e4 periods": (1e4, 1e4, 1.0),
    }
    found = [
        HardCase(
            f"communication step {name}",
            "results that depend on the step; a step too small to move the time",
            "change of the amplitude, relative",
            FLOW,
            partial(_step_error, *given),
        )
        for name, given in steps.items()
    ]
    risk = "rounding that adds up in the angle of the carrier"
    found.append(HardCase("1e7 cycles, phase", risk, "radians", _PHASE, _phase_error, slow=True))
    risk = "memory that grows with the run"
    found.append(HardCase("1e7 cycles, memory", risk, "bytes", _MEMORY, _memory_growth, slow=True))
    return found
