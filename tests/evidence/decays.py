"""Laws that are identified from drawn decays, beside the nonlinear mode of the structure."""

import numpy as np
from oracles.families import Case
from oracles.harmonic_balance import nonlinear_mode
from oracles.time_integration import integrate

from evidence.answers import Answer, limited
from slipmode import rom

PER_PERIOD, STEPS = 16, 128  # samples and steps
STARTS = 1.0, 0.85, 0.7  # of the records, relative to the expected amplitude
CONFIDENCE = 2.0  # standard deviations: 95 %


def identified(given: Case) -> list[Answer]:
    """Frequency and damping at four amplitudes; the stated error is a 95 % interval."""
    shape, size = given.shapes[:, 0], 2.0 * given.amplitude[0]
    dof = int(np.argmax(np.abs(shape)))
    omega = float(np.sqrt(shape @ given.system.stuck() @ shape))
    zeta = 0.5 * float(shape @ given.system.C @ shape) / omega
    periods = int(2.0 / (2.0 * np.pi * zeta))
    records, nothing = [], np.zeros((len(shape), 1))
    for i, part in enumerate(STARTS):
        z = np.append(part * size * shape, np.zeros(len(shape)))
        motion = integrate(
            *(given.system, nothing, lambda t: np.zeros((t.size, 1))),
            *(2.0 * np.pi / omega * periods, STEPS * periods, STEPS // PER_PERIOD, z),
        )
        noise = (
            1e-3 * size * abs(shape[dof]) * np.random.default_rng(i).standard_normal(motion.t.size)
        )
        signal = (motion.x[:, dof] + noise)[np.newaxis]
        records.append(rom.Record(f"decay {i + 1}", signal, PER_PERIOD * omega / (2.0 * np.pi)))
    measurement = rom.Measurement(records, "displacement", "m", ("sensor",))
    band = 0.9 * omega / (2.0 * np.pi), 1.06 * omega / (2.0 * np.pi)
    law = limited(lambda: rom.identify(measurement, bands=[band]))
    answers: list[Answer] = []
    mode = coarse = None
    for part in (0.15, 0.25, 0.4, 0.55):
        mode = nonlinear_mode(given.system, shape, part * size, mode)
        coarse = nonlinear_mode(given.system, shape, part * size, coarse, 9)
        found = law.backbone(amplitude=[abs(mode.X[1, dof])])
        for what, value, deviation, exact, other in (
            ("frequency", found.frequency, found.frequency_deviation, mode.omega, coarse.omega),
            ("damping", found.damping, found.damping_deviation, mode.zeta, coarse.zeta),
        ):
            true, own = abs(value[0] - exact) / exact, abs(other - exact) / exact
            stated = CONFIDENCE * float(deviation[0]) / exact
            answers.append(Answer(f"{what} at {part}", float(true), stated, float(own)))
    return answers
