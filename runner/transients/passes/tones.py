"""A pass of several modes on one or two tones."""

from __future__ import annotations

import numpy as np

from slipmode.fmu import Component
from slipmode.rom.arrays import Floats
from slipmode.runner.plan.tones import TonesPlan
from slipmode.runner.scene.keys import Window
from slipmode.runner.transients.energy import ToneBalance
from slipmode.runner.transients.motion import FastMotion
from slipmode.runner.transients.passes.loop import ComponentPass, Destination


class TonePass(ComponentPass):
    """A pass of several modes. Forces of contacts follow from their motion."""

    steps_per_block = 256  # between recordings: less than a second of work

    def __init__(self, plan: TonesPlan, destination: Destination) -> None:
        excited, scene = plan.excited, plan.scene
        component = Component(
            excited.tone_model,
            excited.force_patterns,
            contact=bool(scene.windows),
            elastic=scene.output.elastic,
            tolerance=scene.run.tolerance,
            warned=False,
        )
        super().__init__(plan, destination, component, ToneBalance(plan).rows)
        self._step_to_samples()

    def _record_window(self, window: Window) -> None:
        reduced, (first, rows) = self._plan.excited.reduced, self._kept()
        assert reduced.contacts is not None
        names, dofs = self._component.output_names, self._plan.scene.output.elastic
        contacts = range(reduced.n_contacts)
        x, v = ([names.index(f"contact_{i}_{part}") for i in contacts] for part in "xv")
        elastic = [names.index(f"x_{dof}") for dof in dofs]
        angle = rows[:, self._columns.angle]
        carrier = np.exp(1j * angle)[:, reduced.tone_numbers]
        modal = 2.0 * (self._columns.amplitudes(rows) * carrier).real
        force = self._forces(reduced.contacts, rows[:, x], first)
        columns = rows[:, x], rows[:, v], force, modal, rows[:, elastic]

        def motion_at(times: Floats) -> tuple[FastMotion, float, Floats]:
            at = self._schedule.numbers(times) - first
            return FastMotion(times, *(each[at] for each in columns)), 1.0, angle[at]

        self._record_motion(window, reduced, motion_at)
