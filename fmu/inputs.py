"""Inputs of a component: their names, their allowed values, how they move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipmode.rom import Model, SlipmodeError, Tanh, kernel
from slipmode.rom.arrays import Flags, Floats, in_one_line
from slipmode.rom.laws.friction import is_homogeneous
from slipmode.rom.reduction.force_response import (
    AppliedForces,
    ForcePatterns,
    forces_on_modes,
)
from slipmode.rom.short_repr import percentage
from slipmode.rom.slow.tone.tone_flow import SPAN
from slipmode.rom.table.local.tone_model import ToneModel
from slipmode.rom.validity import (
    Finding,
    carrier_findings,
    carrier_range,
    carrier_refusal,
    carriers_meet,
    is_near,
    meeting_refusal,
    spin_of,
)

MODE_NAMES = ("A", "B")
AnyModel = Model | ToneModel


def place(quantity: str, mode: int = 0) -> int:
    """Return the column of a quantity in a record, the core's sm_inputs as doubles."""
    fields = kernel.INPUTS.fields
    assert fields is not None
    return int(fields[quantity][1]) // 8 + mode


# Columns of inputs that move, and of their rates.
_MOVING = [place(name, j) for name in kernel.INPUT_QUANTITIES for j in range(kernel.MODES)]
_MOVING.append(place("limit_scale"))
_RATES = [
    place(f"{name}_rate", j) for name in kernel.INPUT_QUANTITIES for j in range(kernel.MODES)
]
_RATES.append(place("limit_scale_rate"))


def rate_of(name: str) -> str:
    """Return the name of the rate of an input: force_rate_A of force_A, limit_scale_rate."""
    return f"{name}_rate" if name == "limit_scale" else name.replace("_", "_rate_")


class Inputs:
    """Names of a model's inputs, and records (n, width) of them for the core.

    `force_patterns` and `mode_names` are as for `Component`.
    """

    def __init__(
        self,
        model: AnyModel,
        force_patterns: ForcePatterns | None,
        mode_names: Sequence[str],
    ) -> None:
        self._tone = isinstance(model, ToneModel)
        present = present_modes(model, mode_names)
        driven, self._omega = tone_names(model, present), carried_frequencies(model)
        if self._tone:  # a force moves all modes of its tone
            self.mode_names, self.carriers = present, driven
        else:
            self.mode_names = (*present, *(name for name in MODE_NAMES if name not in present))
            self.carriers = self.mode_names
        self._column = {
            f"{quantity}_{mode}": place(quantity, j)
            for j, mode in enumerate(driven)
            for quantity in kernel.INPUT_FIELDS
        }
        if is_homogeneous(model.law, model.reduced.n_contacts):
            self._column |= {name: place(name) for name in kernel.SCALE_FIELDS}
        self.names = tuple(self._column)
        self._unscaled = "velocity alpha" if isinstance(model.law, Tanh) else "gap"
        self._contacts = model.reduced.n_contacts
        natural = self._omega.tolist()
        self._range = relative_range(model)
        spins = [spin_of(model.reduced.spin, j) for j in range(len(natural))]
        self._spin = dict(zip(driven, spins, strict=False))
        self.natural = {f"frequency_{m}": w for m, w in zip(driven, natural, strict=False)}
        at_rest = kernel.inputs(1)
        at_rest["frequency"][0, : self._omega.size] = self._omega
        self.at_rest: Floats = at_rest.view(float).reshape(1, -1)
        self._ratio = model.reduced.ratio
        self._to_modal = np.ones(self.at_rest.size)
        for j, factor in enumerate(force_factors(model, force_patterns)):
            self._to_modal[[place("force", j), place("force_rate", j)]] = factor

    def column(self, name: str) -> int:
        """Return the column of an input in the records; other names are refused."""
        if name in self._column:
            return self._column[name]
        if name not in kernel.SCALE_FIELDS:
            raise SlipmodeError(f"{name}: is not an input; inputs are {', '.join(self.names)}")
        if not self._contacts:
            raise SlipmodeError(f"{name}: the model has no contacts, so it has no limits to scale")
        raise SlipmodeError(
            f"{name}: the contact law has a {self._unscaled}, which does not scale with limits "
            "and preloads; tabulate a model with the other limits"
        )

    def records(self, values: Floats) -> Floats:
        """Return records of inputs (n, inputs) in the order of the names."""
        records = np.repeat(self.at_rest, len(values), axis=0)
        records[:, list(self._column.values())] = values
        return records

    def first_refused(self, records: Floats, durations: Floats) -> int:
        """Return the number of the first record (n, width) whose frequencies are not allowed.

        They must be allowed at its start and while it moves for its duration (n,). n: all are.
        """
        fine = np.ones(len(records), dtype=bool)
        reached = []
        for j, omega in enumerate(self.natural.values()):
            start, rate = (records[:, place(name, j)] for name in ("frequency", "frequency_rate"))
            with np.errstate(all="ignore"):  # values that are not finite are refused
                end = start + rate * durations
                fine &= self._can_carry(omega, start) & self._can_carry(omega, end)
            reached.append((start, end))
        if len(reached) == kernel.MODES:
            with np.errstate(all="ignore"):
                fine &= ~carriers_meet(np.array(reached).T)
        return len(records) if fine.all() else int(np.argmin(fine))

    def modal(self, records: Floats) -> Floats:
        """Return records with modal forces, and with the carrier of a second mode on a tone."""
        modal = records * self._to_modal
        if self._ratio:
            for name in ("frequency", "frequency_rate"):
                modal[:, place(name, 1)] = self._ratio * modal[:, place(name, 0)]
        return modal

    def refusal(self, record: Floats) -> str:
        """Return why a record (1, width) is refused, naming an input; "" if it is not."""
        for name, column in self._column.items():
            value = float(record[0, column])
            refusal = ""
            if not np.isfinite(value):
                refusal = f"{name}: must be finite, got {value:g}"
            elif name in self.natural:
                refusal = self._carrier_refusal(name, value)
            elif name == "limit_scale" and value <= 0:
                refusal = f"{name}: must be > 0, got {value:g}"
            if refusal:
                return refusal
        return self._meeting(record)

    def refusal_later(self, start: Floats, end: Floats) -> str:
        """Return why a step from record to record (1, width) is refused; "" if it is not."""
        if refusal := self.refusal(end):
            return f"{refusal} at the end of the step"
        refusal = self._meeting(start, end)
        return f"{refusal}; they meet during the step" if refusal else ""

    def findings(self, records: Floats) -> list[Finding]:
        """Report frequencies of records (n, width) that are far from their mode."""
        omega = self._omega[: len(self.natural)]
        frequency = records[:, [place("frequency", j) for j in range(omega.size)]]
        if is_near(omega, frequency).all():
            return []
        return carrier_findings("frequency_{}", self.carriers, omega, frequency)

    def _can_carry(self, omega: float, frequency: Floats) -> Flags:
        """Return whether frequencies are allowed."""
        low, high = self._range
        return np.asarray((frequency >= low * omega) & (frequency <= high * omega))

    def _carrier_refusal(self, name: str, value: float) -> str:
        """Return why a frequency is refused; "" if it is not."""
        omega = self.natural[name]
        spin = self._spin[name[-1]]
        if refusal := carrier_refusal(name, name[-1], omega, value, spin=spin):
            return refusal
        if self._can_carry(omega, np.array(value)):
            return ""
        return (
            f"{name}: must be within {percentage(SPAN)} of {omega:.5g} rad/s, the middle of the "
            f"modes that share the tone, got {value:g} rad/s"
        )

    def _meeting(self, *records: Floats) -> str:
        """Return why the frequencies of a few records meet; faster than `carriers_meet`."""
        if len(self.natural) < kernel.MODES:
            return ""
        first = place("frequency")
        gaps = [record.item(first + 1) - record.item(first) for record in records]
        return meeting_refusal(", ".join(self.natural)) if min(gaps) <= 0.0 <= max(gaps) else ""


def moved_on(record: Floats, duration: float) -> Floats:
    """Return a record (1, width) after its inputs moved at their rates for `duration`."""
    rates = record.take(_RATES, axis=1)
    if not rates.any():
        return record
    later = record.copy()
    with np.errstate(invalid="ignore"):  # records that are not finite are refused
        later[:, _MOVING] += duration * rates
    return later


def limit_scale(record: Floats) -> float:
    """Return friction limits and preloads relative to the model's."""
    return float(record[0, place("limit_scale")])


def carried_frequencies(model: AnyModel) -> Floats:
    """Return the frequencies [rad/s] near which the forcing frequencies are, (modes or tones,)."""
    if isinstance(model, ToneModel):
        return model.carrier
    reduced = model.reduced
    return reduced.frequency if reduced.spin is None else reduced.carrier


def relative_range(model: AnyModel) -> tuple[float, float]:
    """Return the allowed range of forcing frequencies, relative to `carried_frequencies`."""
    if isinstance(model, ToneModel):
        return 1.0 - SPAN, 1.0 + SPAN
    if (spin := spin_of(model.reduced.spin, 0)) is None:
        return carrier_range(1.0)
    low, high = (spin[2:] / model.reduced.carrier[0]).tolist()
    return low, high


def present_modes(model: AnyModel, mode_names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the model's modes; further names are left out.

    Modes that share a tone have names of their own.
    """
    if isinstance(model, ToneModel):
        return tuple(model.reduced.mode_names)
    present = tuple(mode_names)[: model.modes] if isinstance(mode_names, Sequence) else ()
    unknown = any(name not in MODE_NAMES for name in present)
    if unknown or len(set(present)) < model.modes:
        raise SlipmodeError(
            f"mode_names: must have {model.modes} different names out of A and B, got "
            f"{in_one_line(mode_names)}"
        )
    return present


def tone_names(model: AnyModel, mode_names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the tones: of the first mode of each."""
    reduced = model.reduced
    return tuple(mode_names[own.start] for own in reduced.on_tones[: reduced.tones])


def force_factors(model: AnyModel, force_patterns: ForcePatterns | None) -> Floats:
    """Return the modal force per unit of the force input, (MODES,).

    The flow of modes that share a tone takes the force itself.
    """
    factors = np.ones(kernel.MODES)
    if force_patterns is not None and not isinstance(model, ToneModel):
        patterns = forces_on_modes(model.reduced, force_patterns, "force_patterns")
        factors[: model.modes] = AppliedForces(model.reduced, patterns).modal
    return factors
