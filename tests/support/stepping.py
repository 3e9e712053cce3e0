"""Components of the two-mass model, and ways to step them."""

from functools import cache

import numpy as np

from slipmode import rom
from slipmode.fmu import Component
from slipmode.rom.reduction.nonresonant import RESPONSE_ORDER

FORCE_PATTERNS = ({0: 1.0}, {1: 1.0})
HELD = {"force_A": 0.15, "frequency_A": 0.98, "force_B": 0.25, "frequency_B": 1.65}
SWEPT = HELD | {"frequency_rate_A": -1e-4, "force_rate_B": 1e-4, "phase_rate_A": 0.01}
STEPS = np.tile([0.3, 2.0, 31.0, 1e-3, 7.0], 4)  # shorter and longer than the contacts' memory


@cache
def model(modes=(0, 1), formulation="consistent", combinations=None):
    reduced = rom.reduce(rom.two_mass(beta=0.01), modes, formulation)
    law = rom.Tanh(limit=2.0, alpha=0.02)
    amplitude, kept = (4.0, 2.0)[: len(modes)], RESPONSE_ORDER
    return rom.tabulate(
        reduced, law, amplitude, tolerance=1e-3, combinations=combinations, harmonics=kept
    )


def model_with_steady_states(modes=(0, 1), formulation="consistent"):
    """Without combination resonances, which beat for ever."""
    return model(modes, formulation, combinations=())


def component(inputs=HELD, of=None, **options):
    of = of or model()
    made = Component(of, FORCE_PATTERNS[: of.modes], **options)
    made.set_inputs(**{name: inputs[name] for name in inputs if name in made.input_names})
    return made


def march(stepped, durations):
    """Outputs after each step, as rows."""
    rows = []
    for duration in durations:
        stepped.do_step(stepped.time, duration)
        rows.append(list(stepped.outputs().values()))
    return np.array(rows)


def amplitude(stepped):
    now = stepped.outputs()
    return np.array([now["A_re"] + 1j * now["A_im"], now["B_re"] + 1j * now["B_im"]])


def state_of(stepped):
    return stepped.get_state().tolist(), stepped.outputs()
